"""A block that touches what no support is has the speed of the points that touch, on every crane type."""

from __future__ import annotations

from math import sqrt
from random import Random

import numpy as np
import pytest
from heavylift.coordinator.record import Played, play
from heavylift.kernel.description import Check
from heavylift.nodes.limits import SignalColumns, checks_of, uses_of
from heavylift.nodes.scene import load
from lift_of_a_type import Lift

G = 9.80665
FALLS = 2e-3  # of the speed of a fall: slings that are let go pull the block for less than a sample
SHAKES = 0.1  # of an ordered speed: a block hangs in springs, and tilts to and fro
BETWEEN = 2e-3  # of a speed: between samples a constant acceleration is assumed


def row(run: Played, quantity: str) -> Check:
    (found,) = (x for x in run.verdict.checks if x.quantity == quantity and " on " not in x.subject)
    return found


def test_a_block_hoisted_against_a_shelf_touches_at_the_ordered_speed(lift: Lift) -> None:
    draw = Random(lift.text)
    gap, speed = draw.uniform(0.3, 0.6), draw.uniform(0.5, 0.95)
    block = lift.read().scene.all_blocks["block"]
    (x, y, z), (a, b, c) = block.at, block.size
    place = f"[{x + a / 2} m, {y + b / 2} m, {z + c / 2 + gap + 0.25} m]"
    text = lift.beginning("").replace("hoist 1 m/min by 1 m", f"hoist {speed!r} m/min by {gap + 0.02!r} m")
    shelf = f"obstacles: {{shelf: {{box: [0.6 m, 0.6 m, 0.5 m], at: {place}}}}}\nmay touch: [[block, shelf]]\n"
    run = play(lift.read(text=text.replace("actions:", f"{shelf}actions:", 1)).plan)
    found = row(run, "landing speed")
    assert 60.0 * (found.value or 0.0) == pytest.approx(speed, rel=SHAKES)
    assert found.basis.endswith("as simulated")
    assert "did not occur" not in found.sentence


def dropped(height: float, *settings: str, more: str = "") -> Played:
    """The block of the hall, dropped beside its supports on a shelf."""
    shelf = f"{{box: [9 m, 9 m, 1 m], at: [-10 m, 8 m, 0.5 m]{more}}}"
    up = '{hall: "hoist 0.5 m/min until all slings taut"}, {hall: "hoist 0.5 m/min until lifted"}'
    aside = '{hall travelling: "travel 30 m/min ramp one swing by 10 m"}'
    over = f'{{hall: "hoist 4 m/min by {0.5 + height!r} m"}}, {aside}'
    actions = f"actions=[{up}, {over}, {{wait: 20 s}}, {{legs: release}}, {{wait: 1 s}}]"
    given = [f"obstacles={{shelf: {shelf}}}", "may touch=[[block, shelf]]", actions, "end=200 s", *settings]
    return play(load("hall", given).plan)


@pytest.mark.parametrize("hz", ["1 Hz", "5 Hz", "50 Hz"])
def test_a_fall_on_an_obstacle_has_the_speed_of_the_closed_form_at_each_sampling_rate(hz: str) -> None:
    height = Random(hz).uniform(0.2, 0.8)
    run = dropped(height, f"samples={hz}")
    found, past = row(run, "landing speed"), run.past.part(0, len(run.t))
    fell = max(past.poses["block"][past.t > 40.0, 2]) - 3.0
    assert found.value == pytest.approx(sqrt(2.0 * G * fell), rel=FALLS)
    assert found.state == "red"
    (force,) = (x for x in run.verdict.checks if x.quantity == "impact")
    (load,) = (x for x in run.verdict.checks if x.quantity == "support load" and x.subject == "shelf")
    assert (force.subject, force.state, force.why) == ("block on shelf", "amber", "not checked")
    assert (load.state, load.why) == ("amber", "not checked")


@pytest.mark.parametrize("MN", [20.0, 200.0])
def test_a_fall_on_an_obstacle_that_yields_has_the_force_of_the_closed_form(MN: float) -> None:
    """m g (1 + sqrt(1 + v^2 k / (m g^2))) of a mass that falls on a spring, on its impact and on what it falls on."""
    run = dropped(0.4, more=f", stiffness: {MN} MN/m, capacity: 2 MN")
    speed, m = row(run, "landing speed").value or 0.0, 80e3
    force = m * G * (1.0 + sqrt(1.0 + speed**2 * MN * 1e6 / (m * G**2)))
    impact, load = (row(run, "impact"), next(x for x in run.verdict.checks if x.subject == "shelf"))
    assert (impact.state, load.state) == ("red", "red" if force > 2e6 else load.state)
    assert impact.value == pytest.approx(force, rel=1e-9)
    assert (load.value or 0.0) * G == pytest.approx(force, rel=1e-9)


def test_an_obstacle_bears_a_block_that_stands_on_it() -> None:
    run = play(load("in-turn").plan)
    loads = {x.subject: x for x in run.verdict.checks if x.quantity == "support load"}
    for name in ("a-plinth", "b-plinth"):
        assert (loads[name].value or 0.0) == pytest.approx(20e3, rel=SHAKES)
        assert loads[name].limit == pytest.approx(300e3 / G)


def test_landing_speeds_on_plinths_are_checked_with_their_simulated_values() -> None:
    """Of the bundled scene in which two cranes set blocks down on obstacles."""
    run = play(load("in-turn").plan)
    found = {x.subject: x for x in run.verdict.checks if x.quantity == "landing speed"}
    assert {*found} == {"a-block", "b-block"}
    for check in found.values():
        assert 60.0 * (check.value or 0.0) == pytest.approx(1.0, rel=SHAKES)
        assert check.basis.endswith("as simulated")
    assert not [x for x in run.verdict.checks if x.quantity == "impact" and "did not occur" in x.sentence]


def test_each_lift_off_from_an_obstacle_is_checked_with_the_hoisting_speed_at_that_lift_off() -> None:
    shelf = "{box: [9 m, 9 m, 0.4 m], at: [-10 m, 8 m, 0.4 m]}"
    up = '{hall: "hoist 0.5 m/min until all slings taut"}, {hall: "hoist 0.5 m/min until lifted"}'
    over = '{hall: "hoist 4 m/min by 0.6 m"}, {hall travelling: "travel 30 m/min ramp one swing by 10 m"}'
    down = '{hall: "lower 0.6 m/min until landed on shelf and all slings slack"}'
    again = '{hall: "hoist 0.8 m/min by 0.3 m"}'
    actions = f"actions=[{up}, {over}, {{wait: 20 s}}, {down}, {again}]"
    run = play(load("hall", [f"obstacles={{shelf: {shelf}}}", actions, "end=300 s"]).plan)
    for quantity, speed in (("landing speed", 0.6), ("lift-off speed", 0.8)):
        assert 60.0 * (row(run, quantity).value or 0.0) == pytest.approx(speed, rel=SHAKES)


def test_a_landing_speed_is_not_checked_if_the_run_recorded_no_supports() -> None:
    plan = load("hall", ["actions=[{wait: 1 s}]"]).plan
    (limit,) = (x for x in plan.limits if x.quantity == "landing speed")
    seen: list[tuple[str, str]] = []
    for tensions in ({}, dict.fromkeys(limit.elements, np.ones(3))):
        (use,) = (x for x in uses_of(plan, [SignalColumns(np.arange(3.0), tensions, dynamic=True)]) if x.limit == limit)
        (check,) = (x for x in checks_of(plan, [use], (), {}, ()) if x.quantity == "landing speed")
        seen.append((check.state, check.why))
    assert seen == [("amber", "not checked"), ("none", "")]
