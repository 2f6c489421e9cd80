"""A scene with wind, a spring and a law of the user's own, from its file to its recording, in processes as in one."""

from pathlib import Path

import numpy as np
import pytest
from chain import CLOSED_FORMS, G, channel, near, play

FORM = CLOSED_FORMS["C16"]
STATIC = 1e-3  # what C16 accepts

SCENE = """\
heavylift: 1
name: gust
accuracy: 1e-4 %
samples: 50 Hz
end: {end} s
mechanism:
  bodies:
    load: {{mass: 300 t, com: [0, 0, -50 m]}}
    cart: {{mass: 2 t}}
  joints:
    pivot: {{type: revolute, child: load, axis: [0, 1, 0], start: {start} deg}}
    rail: {{type: prismatic, child: cart, axis: [0, 1, 0], start: 0.3 m}}
  forces:
    gale:
      {{type: wind, body: load, at: [0, 0, -50 m], area: 360 m2, drag: 1.2, direction: [1, 0, 0], gusts: {gusts}}}
    buffer: {{type: law, function: "{law}:buffer", joint: rail, parameters: [8000]}}
"""
LAW = "def buffer(x):\n    return -x.parameters[0] * x.q\n"


@pytest.fixture
def law(tmp_path: Path, code_allowed: None) -> str:
    (tmp_path / "mine.py").write_text(LAW)
    return str(tmp_path / "mine.py")


def test_a_load_in_steady_wind_hangs_at_its_equilibrium_angle(tmp_path: Path, law: str) -> None:
    theta = FORM["expected"]["theta_deg"]
    recording = play(tmp_path, SCENE.format(end=10, start=-theta, gusts="[[0 s, 15 m/s]]", law=law))

    t, angle = channel(recording, "joint/position", "pivot.angle")
    assert near(channel(recording, "wind/force", "gale")[1][0], FORM["expected"]["F"], 1e-9)
    assert np.abs(np.degrees(angle) + theta).max() < STATIC * theta
    _, place = channel(recording, "joint/position", "rail.travel")
    assert place == pytest.approx(0.3 * np.cos(2.0 * t), abs=1e-5)


def test_a_run_in_gusts_has_the_same_recording_in_one_process_and_in_several(tmp_path: Path, law: str) -> None:
    scene = SCENE.format(end=4, start=0, gusts="[[1 s, 0], [1 s, 15 m/s], [2 s, 15 m/s], [3 s, 10 m/s]]", law=law)
    one, many = (play(tmp_path, scene, in_process=here) for here in (True, False))

    assert one.result["digest"] == many.result["digest"]
    _, speed = channel(one, "wind/speed", "gale")
    assert (speed[0], speed[-1]) == (0.0, 10.0)
    t, angle = channel(one, "joint/position", "pivot.angle")
    assert np.all(angle[t <= 1.0] == 0.0)
    drag = FORM["expected"]["F"] / 3e5
    assert angle[t <= 1.2][-1] == pytest.approx(-drag / 50.0 * 0.2**2 / 2, rel=0.02)
    assert drag < G
