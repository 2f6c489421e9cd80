"""Each quantity in the table of limits is checked, and red if its limit is narrow enough."""

from dataclasses import replace
from typing import get_args

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.coordinator.verdict import Conduct, History, verdict_of_run
from heavylift.kernel import SceneError
from heavylift.nodes.limits import BASES, KINDS, REDUCTIONS, RatedLimit, Use, signals_of, uses_of, uses_on_path
from heavylift.nodes.plan import Quantity
from heavylift.nodes.scene import LoadedScene, check, load
from lifting import cranes, findings_of as judged

SIDE = "cranes.crane.{}=1 MN"
LIFT = (
    "block.lugs.P1=[-9 m, -6 m, 4.3 m]",  # its sling leads aside
    "cranes.crane.drum pull=1 MN",
    "limits={signals: [load of crane H1 <= 1 t]}",
    *(SIDE.format(key) for key in ("gantry drive", "gantry brake", "trolley drive", "trolley brake")),
)
SCENES = {"lift": LIFT, "tandem": (), "tackle": ("limits={ropes: {fall: {breaking: 1 MN, factor: 2}}}",)}
GIVEN = "factors={weight: 1.05, dynamics: not included, wind: 10 m/s, area: 20 m2}"
WIND = "limits={wind: 10 m/s}"
GROUND = ["ground={bearing: 200 kPa}", "block.mass=20 t"]
ELSEWHERE = ("clearance", "inputs", "factor", "sharing", "heavy sling")  # rows without a value, or checked by others
AT_SEA = {"relative heave", "slack sling", "splash load"}  # checked in lifts at sea
PEAKS = {"sling peak", "rope peak", "impact"}  # of runs alone


def narrow(use: Use) -> RatedLimit:
    """A limit that is a little beyond, or short of, the worst that was met."""
    value, limit = use.value, use.limit
    assert value is not None
    if limit.between is not None:
        return msgspec.structs.replace(limit, between=(value + 1.0, value + 2.0))
    return msgspec.structs.replace(
        limit, value=value * 1.2 if limit.least else value - 0.2 * max(value, 1e-9), chart=()
    )


@pytest.fixture(scope="module")
def scenes() -> dict[str, LoadedScene]:
    jib = load("jib", [GIVEN, "block.lug capacity=20 t", "rigging.legs.shackle=20 t"])
    more = {"gust": load("gust", [WIND]), "spreader": load("spreader"), "jib": jib, "crawler": load("crawler", GROUND)}
    return {name: load(name, given) for name, given in SCENES.items()} | more


def test_each_limited_quantity_gives_a_red_check_both_at_rest_and_in_a_run(scenes: dict[str, LoadedScene]) -> None:
    on_path, in_run = set(), set()
    for scene in scenes.values():
        peaks = {
            f"{x.subject} {x.quantity}": (2.0 * (x.value or 0.0), 0.0)
            for x in scene.plan.limits
            if "speed" in x.quantity
        }
        signals = replace(signals_of(scene.statics.states), dynamic=True, peaks=peaks)
        for quantity in {x.quantity for x in scene.plan.limits} - {"clearance"}:
            met = [u for u in scene.uses if u.limit.quantity == quantity and u.value]
            if quantity in PEAKS:
                rows = tuple(msgspec.structs.replace(x, value=1.0) for x in scene.plan.limits if x.quantity == quantity)
            else:
                rows = tuple(narrow(u) for u in met[:1])
            tight = msgspec.structs.replace(scene.plan, limits=rows)
            for findings, found in (
                (judged(tight, uses_on_path(tight, scene.statics.states), dynamic=False), on_path),
                (judged(tight, uses_of(tight, [signals]), dynamic=True), in_run),
            ):
                found |= {quantity for f in findings if f.state == "red"}
    assert in_run == set(get_args(Quantity)) - set(ELSEWHERE) - AT_SEA
    assert on_path == in_run - PEAKS
    assert {*KINDS, *REDUCTIONS, *BASES, "signal", "interlock", "off-lead in wind"} - AT_SEA == in_run


def test_a_clearance_below_its_limit_turns_the_verdict_red() -> None:
    """Two portals that come within a metre of each other."""
    for limit, red in (("0.9 m", False), ("1.1 m", True)):
        plan = load("tandem", [f"limits={{clearance: {limit}}}"]).plan
        poses = {f"{c.name}.main": np.tile([c.actuators[0].start, 0.0, 0, 0, 0, 0, 1], (3, 1)) for c in cranes(plan)}
        poses["east.main"][:, 0] -= 1.0
        text = Conduct(end=2.0)
        assert verdict_of_run(plan, History(np.arange(3.0), poses, {}, {}, []), text).red == red


def test_wind_is_checked_against_its_limit_up_to_the_end_of_a_run(tmp_path) -> None:
    """It blows with 7.5 m/s at 11 s and with 15 m/s from 12 s on."""
    message = "red: wind would be 15.00 m/s; 10.00 m/s is allowed (the scene)"
    assert message in str(check(load("gust", [WIND])))
    for end, red in (("11 s", False), ("12.1 s", True)):
        scene = load("gust", [WIND, f"end={end}", "samples=1 Hz"])
        verdict = run(scene, tmp_path / "run.mcap", in_process=True, force=True).verdict
        assert verdict is not None
        assert [(f.quantity, f.value, f.t) for f in verdict.findings] == ([("wind", 15.0, 12.0)] if red else [])
    (calm,) = [u for u in load("jib", [WIND]).uses if u.limit.quantity == "wind"]
    assert (calm.value, calm.limit.note) == (None, "no wind is modelled")


def test_a_rope_over_sheaves_is_checked_by_its_most_loaded_part(tmp_path) -> None:
    """40 t on four parts are 98.1 kN at rest; hoisting, the lead part carries 1.046 times as much."""
    limit = "limits={ropes: {fall: {tension: 100 kN}}}"
    page = str(check(load("tackle", [limit])))
    assert "red: rope tension of fall would be 102.6 kN, 103 %; 100 kN is allowed" in page
    scene = load("tackle", [limit, "end=2 s"])
    verdict = run(scene, tmp_path / "run.mcap", in_process=True).verdict
    assert verdict is not None
    (red,) = [f for f in verdict.findings if f.state == "red" and f.quantity == "rope tension"]
    assert red.subject == "fall"
    assert red.value == pytest.approx(107.5e3, rel=0.01)
    assert "tension of ropes over sheaves between samples" in verdict.not_modelled


def test_a_limit_for_a_quantity_that_the_scene_does_not_have_is_reported_as_an_error() -> None:
    for key, value in (("clearance", "1 m"), ("off-lead along", "2 deg"), ("bridle", "50 deg")):
        with pytest.raises(SceneError, match=f"limits.{key}: this limit checks nothing: the scene has no hooks"):
            load("gust", [f"limits={{{key}: {value}}}"])
    with pytest.raises(
        SceneError, match=r"limits\.off-lead along: this limit checks nothing: no hook has one of its own"
    ):
        load("hall", ["limits={off-lead along: 2 deg}"])
    with pytest.raises(SceneError, match=r"limits\.heave: this limit checks nothing: the scene has no vessels"):
        load("lift", ["limits={heave: 1 m}"])
