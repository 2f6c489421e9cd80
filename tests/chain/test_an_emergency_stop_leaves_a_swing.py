"""An emergency stop: gantry and winches stand after v / a, and the block swings on as Duhamel's integral says."""

from __future__ import annotations

from math import degrees
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load, parse
from heavylift.recordings import Recording

DRIVES = ["crane.gantry.drive", "crane.lower-slide.drive", "crane.upper-slide.drive"]
V, RAMP, EMERGENCY, HOISTING = 0.5, 0.05, 0.3, 0.05  # m/s and m/s2
LINEAR = 0.02  # of one pendulum for hook, loader and block, and of a rope that becomes shorter on the way


@pytest.fixture(scope="module")
def stopped(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("stop") / "stop.mcap"
    run(load("emergency-stop"), path, in_process=True)
    return Recording(path)


def test_in_an_emergency_stop_every_moving_axis_uses_its_own_deceleration(stopped: Recording) -> None:
    done = {e.value["actor"]: e.t_ns * 1e-9 for e in stopped.events() if e.type == "Done"}
    begun = {name: t for t, name in stopped.stages()}
    hit = begun["emergency stop"]
    assert hit - begun["travel"] == pytest.approx(30.0)
    assert done["crane.gantry.drive"] - hit == pytest.approx(V / EMERGENCY, abs=1e-9)
    assert done["crane.H1"] - hit == pytest.approx(HOISTING / EMERGENCY, abs=1e-9)
    assert begun["swing"] == pytest.approx(done["crane.gantry.drive"])
    distance = stopped["pose/crane.main"].values[-1, 0] - 40.0
    assert distance == pytest.approx(V * (30.0 - V / RAMP / 2) + V**2 / (2 * EMERGENCY), abs=2e-3)


def test_the_swing_after_an_emergency_stop_is_that_given_by_duhamels_integral(stopped: Recording) -> None:
    """w'' + w0^2 w = -s'': what is left of the ramp of the start and of the stop, w0 as it swings at the end."""
    begun = {name: t for t, name in stopped.stages()}
    pose = stopped["pose/block"]
    after = pose.t > begun["swing"] + 0.5
    x = pose.values[after, 0] - stopped["pose/crane.main"].values[-1, 0]
    x -= (x.max() + x.min()) / 2
    crossings = pose.t[after][:-1][np.diff(np.sign(x)) != 0]
    w0 = np.pi / np.mean(np.diff(crossings))
    hit, start = begun["emergency stop"], begun["travel"]
    pulses = [(start, V / RAMP, RAMP), (hit, V / EMERGENCY, -EMERGENCY)]
    left = sum(a * (np.exp(1j * w0 * (t + d)) - np.exp(1j * w0 * t)) / (1j * w0) for t, d, a in pulses)
    assert np.ptp(x) / 2 == pytest.approx(abs(left) / w0, rel=LINEAR)


def test_an_emergency_stop_during_a_turn_stops_all_axes_of_the_turn() -> None:
    """One hook of three is reported to stop: the whole turn stands near 3 degrees, and the list comes to its end."""
    turn = "{block: turn 0.18 deg/s to 30 deg}"
    scene = parse(
        "extends: single-turn\nname: single-turn\nactions:\n"
        "  - all hooks: hoist 0.3 m/min until all slings taut\n  - all hooks: hoist 0.3 m/min until lifted\n"
        f"  - all hooks: hoist 3 m/min by 2 m\n  - {turn}\n  - {{when: angle >= 3 deg, crane H3: stop}}\n",
        "scene.yaml",
        passing=True,
    )
    assert scene.statics.known
    last = scene.statics.states[-1]
    assert degrees(last.references["turn"]) == pytest.approx(3.0 + 0.18**2 / (2 * 0.18 / 20.0), abs=0.3)


def test_an_emergency_stop_of_an_axis_at_rest_takes_no_time(tmp_path: Path) -> None:
    scene = parse("extends: lift\nname: lift\nend: 5 s\nactions: [{crane: stop}, {crane H1: stop}]\n", passing=True)
    run(scene, tmp_path / "run.mcap", in_process=True)
    done = [(e.t_ns, e.value["actor"]) for e in Recording(tmp_path / "run.mcap").events() if e.type == "Done"]
    assert sorted(actor for t, actor in done if t == 0) == ["crane.H1", "crane.H1", "crane.H2", "crane.H3", *DRIVES]
