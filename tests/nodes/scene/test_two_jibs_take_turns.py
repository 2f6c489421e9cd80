"""The scene `in-turn`: a lift begins when another stands and is out of the way, by angles and places in closed form."""

from __future__ import annotations

from math import hypot
from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import bundled, load, parse
from heavylift.recordings import Recording

SPEED, RAMP, AWAY = 2.0, 0.2, 60.0  # of slewing [deg/s, deg/s2], and how far the first crane is out of the way [deg]
AHEAD_m = 1e-6  # of a place at an event: samples are recorded as 32-bit numbers
STANDS_m = 1e-3  # of a module on its plinth, whose contact gives way under 20 t
SWINGS_s = 1e-6  # of times of both lifts: each is followed to 0.1 % by steps of its own


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path: Path = tmp_path_factory.mktemp("in-turn") / "run.mcap"
    assert run(load("in-turn"), path, in_process=True).digest == run(load("in-turn"), path, force=True).digest
    return Recording(path)


def test_the_second_jib_starts_when_the_first_jib_has_slewed_60_degrees(recording: Recording) -> None:
    """A ramp takes v / a and v^2 / 2a; the rest goes at v."""
    stages = {name: t for t, name in recording.stages()}
    took = SPEED / RAMP + (AWAY - SPEED**2 / (2.0 * RAMP)) / SPEED
    assert stages["the second"] == stages["b: up"] == pytest.approx(stages["a: away"] + took, abs=SWINGS_s)
    assert stages["a: let go"] > stages["the first stands"]


def test_a_load_chart_interlock_trips_at_the_radius_where_the_capacity_falls(recording: Recording) -> None:
    """20 t and a hook block of 2 t are 61 % of 36 t within 22 m, and 76 % of 29 t beyond."""
    first = next(e for e in recording.events() if e.type == "Tripped" and e.value["actor"] == "a-jib.heavy")
    hook = recording["pose/a-jib.main"]
    at = abs(hook.t - first.t_ns * 1e-9).argmin()
    assert hook.t[at] == pytest.approx(first.t_ns * 1e-9, abs=1e-9)
    assert hypot(*hook.values[at, :2]) == pytest.approx(22.0, abs=AHEAD_m)
    assert not [e for e in recording.events() if e.type == "Tripped" and ".apart" in e.value["actor"]]


def test_both_modules_of_the_example_with_two_jibs_land_symmetrically_on_their_plinths(recording: Recording) -> None:
    a, b = (recording[f"pose/{lift}-block"].values[-1] for lift in "ab")
    assert (a[2], b[2]) == pytest.approx((1.0 + 1.5,) * 2, abs=STANDS_m)
    assert a[1] + b[1] == pytest.approx(64.0, abs=STANDS_m)
    assert a[0] == pytest.approx(b[0], abs=STANDS_m)


def test_two_jibs_that_would_collide_are_stopped_by_their_interlock(tmp_path: Path) -> None:
    text = bundled()["in-turn"].read_text(encoding="utf-8")
    text = text[: text.index("actions:                ")].replace("start: ordered", "start: 1 s")
    result = run(parse(text.replace("samples: 5 Hz", "end: 160 s")), tmp_path / "run.mcap", in_process=True)
    assert result.verdict is not None
    assert "worst: the interlock a-jib.apart stopped a-jib.slewer: gap a-jib.boom b-jib" in result.verdict.line
