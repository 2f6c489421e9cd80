"""Speeds at lift-off and landing after a run are those of the simulation, on every crane type, and say so."""

from __future__ import annotations

from math import sqrt
from random import Random

import numpy as np
import pytest
from heavylift.coordinator.record import Played, play
from heavylift.kernel.description import Check
from heavylift.nodes.limits import SignalColumns, checks_of, uses_of
from lift_of_a_type import Lift
from msgspec.structs import replace

G = 9.80665
TIPS = 1.5  # times the speed of a level rod that lands on one end first: that of its other end then
STIFF = 0.03  # of a speed: ropes, booms and pads spring back and forth as a load is lifted and set down
SAG = 0.1  # of the speed of a drop: what the ropes had stretched is no height


def row(checks: list[Check], quantity: str) -> Check:
    (found,) = (x for x in checks if x.quantity == quantity)
    return found


def lifted(lift: Lift, speed: float, least: str = "20 m/min") -> Played:
    """The lift with another speed of lift-off and landing [m/min]."""
    text = lift.text
    for until in ("lifted", "landed"):
        before, _, after = text.partition(f" until {until}")
        start = before.rindex("all hooks: ")
        verb = before[start:].split()[2]
        text = f"{before[:start]}all hooks: {verb} {speed!r} m/min until {until}{after}"
    return play(lift.read(f"limits={{touch: {least}}}", text=text).plan)


@pytest.mark.large(beyond=3)
def test_lift_off_and_landing_speeds_of_a_slow_lift_are_those_of_its_winches(lift: Lift) -> None:
    speed = Random(lift.text).uniform(0.3, 0.8)
    scene = lift.read()
    assert row(scene.checks, "landing speed").basis.endswith("as ordered")
    checks = list(lifted(lift, speed).verdict.checks)
    for quantity, most in (("lift-off speed", 1.0), ("landing speed", TIPS)):
        found = row(checks, quantity)
        assert speed * (1.0 - STIFF) <= 60.0 * (found.value or 0.0) <= most * speed * (1.0 + STIFF)
        assert "as simulated" in found.basis


@pytest.mark.large(beyond=3)
def test_the_landing_speed_of_a_dropped_block_is_that_of_a_free_fall(lift: Lift) -> None:
    """sqrt(2 g h) from so high above the supports, more where the block tips, and nothing had ordered it."""
    height = Random(f"{lift.text} drop").uniform(0.1, 0.3)
    text = lift.beginning("").replace("  - stage: up\n    all hooks: hoist 1 m/min by 1 m\n", "")
    ropes = [tie.rope for machine in lift.read().plan.machines for tie in machine.ties]
    parted = ", ".join(f"{rope}: release" for rope in ropes)
    drop = f"  - all hooks: hoist 1 m/min by {height!r} m\n  - wait: 5 s\n  - {{{parted}}}\n  - wait: 2 s\n"
    checks = play(lift.read(text=text + drop).plan).verdict.checks
    found = row([*checks], "landing speed")
    fell = sqrt(2.0 * G * height)
    assert (1.0 - SAG) * fell <= (found.value or 0.0) <= (1.0 + SAG) * TIPS * fell
    assert found.state == "red"
    assert [x.state for x in checks if x.quantity == "landing"] == ["red"]


@pytest.mark.large(beyond=3)
def test_a_simulated_landing_speed_beyond_its_limit_gives_a_red_check_whatever_speed_was_ordered(lift: Lift) -> None:
    checks = list(lifted(lift, 0.95, "0.8 m/min").verdict.checks)
    assert (row(checks, "landing speed").state, row(checks, "lift-off speed").state) == ("red", "red")
    assert "as simulated" in row(checks, "landing speed").sentence


@pytest.mark.large(beyond=3)
def test_an_order_above_its_limit_gives_a_red_check_even_if_the_error_of_the_run_is_large(lift: Lift) -> None:
    run = lifted(lift, 0.95, "0.8 m/min")
    for quantity in ("lift-off speed", "landing speed"):
        use = next(x for x in run.uses if x.limit.quantity == quantity)
        error = {f"use of {use.limit.subject} {quantity}": 0.9}
        for factor, state in ((1.0, "red"), (1.3, "undecided")):  # of the limit, which then allows what was ordered
            limit = replace(use.limit, value=(use.limit.value or 0.0) * factor)
            peaks = {f"{limit.subject} {quantity}": (0.95 / 60.0, 1.0)}
            signals = SignalColumns(np.arange(2.0), {}, peaks=peaks, dynamic=True)
            plan = replace(run.plan, limits=(limit,))
            (check,) = (x for x in checks_of(plan, uses_of(plan, [signals]), (), error, ()) if x.quantity == quantity)
            assert check.state == state


def test_a_block_that_comes_down_on_its_supports_in_a_turn_gives_a_red_check_after_a_run(lift: Lift) -> None:
    turn = "  - stage: turn\n    block: turn 20 deg/min to 15 deg\n  - wait: 1 s\n"
    if not lift.text.count("crane: {type: goliath") + lift.text.count("crane: {type: twin"):
        pytest.skip("it cannot turn a block")
    checks = play(lift.read(text=lift.beginning(turn)).plan).verdict.checks
    assert [x.stage for x in checks if x.quantity == "landing" and x.state == "red"] == ["turn"]


@pytest.mark.large(beyond=3)
def test_a_lift_off_ordered_exactly_at_the_speed_limit_is_green(lift: Lift) -> None:
    """A speed read off lengths is as exact as these, which is no error of the run."""
    speed = 0.5
    run = lifted(lift, speed, f"{speed!r} m/min")
    row_ = next(use for use in run.uses if use.limit.quantity == "lift-off speed")
    error = {f"use of {row_.limit.subject} lift-off speed": 1e-12}
    (check,) = checks_of(run.plan, [row_], (), error, ())[:1]
    assert (check.quantity, check.state) == ("lift-off speed", "green")
