"""Ropes go slack and come taut at the instants that their law gives, and never push."""

from math import atan, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from chain import CLOSED_FORMS, G, channel, happenings, near, play, the_only
from load_on_a_rope import MASS, SETTLED, STIFFNESS, WEIGHT, Rope, winding_time

FORM = CLOSED_FORMS["C11"]
EVENT = 1e-4  # [s] of the winch law
CONSTANT_STIFFNESS = 3e-3  # of the value for a rope of constant stiffness
FACTOR = 1e-5  # of the snatch factor: samples every 1 ms stand 0.5 ms from the peak at most, 9e-6 below it
BOUNCE = 1e-6  # [s] of falls, snatches and flights that no winch disturbs

VERY_LONG = Rope(height=6000.0, EA=STIFFNESS * 6000.0)

Events = list[tuple[float, str]]


@pytest.mark.parametrize("in_process", [True, False], ids=["one process", "processes"])
def test_setting_down_a_load_brings_its_rope_tension_to_zero(tmp_path: Path, in_process: bool) -> None:
    rope = Rope()
    scene = (
        rope.scene(samples=100, end=5, z=0.0, length=rope.carrying) + "actions:\n  - rope: lower 0.05 m/s by 0.2 m\n"
    )

    recording = play(tmp_path, scene, in_process=in_process)

    assert recording.result["digest"] == play(tmp_path, scene).result["digest"]

    slack = the_only(happenings(recording, "slack", "rope"))
    assert slack.t == pytest.approx(winding_time(rope.height - rope.carrying, 0.05, 1.0), abs=EVENT)
    assert near(slack.t - 0.05 / 2, FORM["expected"]["t_unload"], CONSTANT_STIFFNESS)
    _, force = channel(recording, "support/force", "ground")
    assert near(force[-1], WEIGHT, 1e-6)


def pick_up(folder: Path, rope: Rope, speed: float) -> tuple[Events, Events]:
    """The rope's events after a lift-off at this speed: those of the run, and those of SciPy."""
    slack, ramp, end = 0.2, 10.0, 3
    scene = rope.scene(samples=200, end=end, z=-SETTLED, length=rope.height + slack, ramp=ramp)
    recording = play(folder, scene + f"actions:\n  - rope: hoist {speed} m/s by 10 m\n")
    lifted = winding_time(rope.height + slack - rope.carrying, speed, ramp)
    assert the_only(happenings(recording, "open", "ground")).t == pytest.approx(lifted, abs=EVENT)
    assert channel(recording, "rope/tension")[1].min() == 0.0
    got = [(h.t, what) for what in ("slack", "taut") for h in happenings(recording, what, "rope") if h.t > lifted]
    return sorted(got), rope.hoisted(lifted, speed, end)


def test_a_load_hoisted_above_a_critical_speed_bounces_on_the_ground_once_more(tmp_path: Path) -> None:
    got, want = pick_up(tmp_path, Rope(), FORM["given"]["v_pick"])

    assert [what for _, what in got] == [what for _, what in want]
    assert len(got) > 4
    assert max(abs(mine - yours) for (mine, _), (yours, _) in zip(got, want, strict=True)) < EVENT


def test_a_load_bouncing_on_a_very_long_rope_stays_in_the_air_as_long_as_with_a_rope_of_constant_stiffness(
    tmp_path: Path,
) -> None:
    """On 60 m the winch has shortened the rope by 1 % before the first flight, which then takes 3 % longer."""
    got, want = pick_up(tmp_path, VERY_LONG, FORM["given"]["v_pick"])

    assert max(abs(mine - yours) for (mine, _), (yours, _) in zip(got, want, strict=True)) < EVENT
    assert near(got[1][0] - got[0][0], FORM["expected"]["t_slack"], CONSTANT_STIFFNESS)


@pytest.mark.parametrize(("speed", "flies"), [(1.17, False), (1.19, True)])
def test_a_load_jumps_off_its_supports_only_above_a_critical_hoist_speed(
    tmp_path: Path, speed: float, flies: bool
) -> None:
    assert 1.17 < FORM["expected"]["v_slack"] < 1.19

    got, want = pick_up(tmp_path, VERY_LONG, speed)

    assert bool(got) == bool(want) == flies


def test_a_bouncing_load_snatches_its_rope_again_and_again(tmp_path: Path) -> None:
    fall, sag = FORM["given"]["h"], FORM["given"]["d_st"]
    length = 60.0 + fall
    scene = Rope(60.0, STIFFNESS * length).scene(samples=1000, end=10, z=0.0, length=length, pad=False)

    recording = play(tmp_path, scene)

    w, speed = sqrt(STIFFNESS / MASS), sqrt(2 * G * fall)
    held, flight = 2 * (pi - atan(speed / (w * sag))) / w, 2 * speed / G
    caught = sqrt(2 * fall / G) + np.arange(20) * (held + flight)
    taut, slack = ([h.t for h in happenings(recording, what, "rope")] for what in ("taut", "slack"))
    assert len(taut) > 10
    assert np.abs(taut - caught[: len(taut)]).max() < BOUNCE
    assert np.abs(slack - caught[: len(slack)] - held).max() < BOUNCE
    _, tension = channel(recording, "rope/tension")
    assert near(tension.max() / WEIGHT, FORM["expected"]["phi_snatch"], FACTOR)
    assert tension.min() == 0.0
