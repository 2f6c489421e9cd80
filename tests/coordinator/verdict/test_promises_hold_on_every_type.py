"""What a verdict promises, attacked by random scenes of every bundled type."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
from pathlib import Path
from random import Random

import msgspec
import pytest
from heavylift.coordinator.record import play
from heavylift.coordinator.verdict import near_at_rest, with_worst_clearances
from heavylift.kernel import SceneError
from heavylift.kernel.description import UNKNOWN, Check
from heavylift.nodes.limits import checks_of, signals_of, uses_of, uses_on_path
from heavylift.nodes.plan import Use
from heavylift.nodes.scene import LoadedScene
from lift_of_a_type import Lift

STILL = "  - wait: 1 s\n"
ORDERED = ("lift-off speed", "landing speed")
AT_ONCE = ("clearance", "interlock")  # checked by shapes, or as they trip


def wall(lift: Lift, gap: float, spread: str = "") -> str:
    """A wall that stands so far from the long side of the block, up to which it does not move."""
    x = lift.x + lift.half + gap + 0.5
    return f"obstacles={{wall: {{box: [1 m, 4 m, 4 m], at: ['{x!r} m{spread}', {lift.y} m, 2 m]}}}}"


def apart(scene: LoadedScene) -> list[Check]:
    checks = scene.checked(near_at_rest(scene.plan, scene.statics))
    return [x for x in checks if x.quantity == "clearance" and "block" in x.subject and "wall" in x.subject]


@pytest.mark.large(beyond=3)
def test_a_clearance_below_its_limit_at_the_worst_corner_of_uncertain_inputs_gives_a_red_check(lift: Lift) -> None:
    """The gap of the wall as it is written, and a scene in which it stands where it is worst."""
    random = Random(lift.x)
    for _ in range(2):
        gap, half = random.uniform(0.55, 1.2), random.uniform(0.02, 0.5)
        text = lift.beginning(STILL)
        scene = with_worst_clearances(lift.read(wall(lift, gap, f" +- {half!r} m"), text=text))
        worst = apart(lift.read(wall(lift, gap - half), text=text))
        row = next(x for x in apart(scene) if "at the worst of" in f"{x.basis} {x.sentence}")
        assert row.value == pytest.approx(gap - half, abs=0.05)
        assert (row.state == "red") == (gap - half < 0.5) == bool([x for x in worst if x.state == "red"])
        assert "obstacles.wall.at.x" in row.basis


@pytest.mark.large(beyond=3)
def test_clearances_after_a_run_are_reduced_by_the_effect_of_uncertain_inputs(lift: Lift) -> None:
    text = lift.beginning(STILL)
    scene = with_worst_clearances(lift.read(wall(lift, 0.7, " +- 0.3 m"), text=text))
    rows = [x for x in play(scene.plan).verdict.checks if x.quantity == "clearance" and "wall" in x.subject]
    assert [(x.state, x.value) for x in rows if "block" in x.subject] == [("red", pytest.approx(0.4, abs=0.05))]


@pytest.mark.large(beyond=2)
def test_a_lift_has_the_same_worst_clearance_beside_another_lift_as_when_it_is_alone(lift: Lift) -> None:
    """One with a wall at an uncertain place and a limit of its own, beside one without both."""
    random = Random(lift.y)
    gap, half, limit = random.uniform(0.7, 1.2), random.uniform(0.02, 0.4), random.uniform(0.55, 0.9)
    text = lift.beginning(STILL)
    own = (wall(lift, gap, f" +- {half!r} m"), f"limits={{clearance: {limit!r} m, off-lead: 3 deg}}")
    alone = with_worst_clearances(lift.read(*own, text=text))
    Path(lift.name).with_name("one.yaml").write_text(text, encoding="utf-8")
    made = ", ".join(["extends: one.yaml", "at: [0 m, 400 m]", *(x.replace("=", ": ", 1) for x in own)])
    pair = f"heavylift: 1\nname: pair\nlifts:\n  a: {{extends: one.yaml}}\n  b: {{{made}}}\n"
    both = with_worst_clearances(lift.read(text=pair))
    (one,), (other,) = (
        [x for x in apart(scene) if "at the worst of" in f"{x.basis} {x.sentence}"] for scene in (alone, both)
    )
    assert (other.subject, other.state) == ("b-block and b-wall", one.state)
    assert other.value == pytest.approx(one.value, abs=2e-3)
    assert other.limit == one.limit == pytest.approx(limit)
    assert "lifts.b.obstacles.wall.at.x" in f"{other.basis} {other.sentence}"
    kept = {x.subject: x.value for x in both.plan.limits if x.quantity == "clearance" and not x.inputs}
    assert kept == {"a": 0.5, "b": pytest.approx(limit)}


def test_an_obstacle_that_overlaps_the_block_at_the_start_is_reported_with_its_line_in_the_scene(lift: Lift) -> None:
    random = Random(lift.half)
    deep = random.uniform(0.05, 1.0)
    text = f"{lift.text}\nobstacles:\n  wall: {wall(lift, -deep).partition('wall: ')[2].removesuffix('}')}\n"
    with pytest.raises(SceneError, match=r"made\.yaml:\d+:\d+: error: obstacles\.wall: .*begins") as told:
        lift.read(text=text)
    line = int(str(told.value).split(":")[1])
    assert text.splitlines()[line - 1].startswith("  wall: ")


def test_the_order_to_stop_all_cranes_has_the_effect_of_an_order_to_stop_each_crane(lift: Lift) -> None:
    one, all_ = (lift.read(text=lift.beginning(f"  - {{stage: halt, {x}: stop}}\n")).plan for x in ("crane", "cranes"))
    halted = [{order.actuator for order in plan.actions[-1].orders} for plan in (one, all_)]
    assert halted[0] == halted[1]
    winches = {hook.rope for machine in one.machines for hook in machine.hooks}
    drives = {x.name for machine in one.machines if machine.hooks for x in machine.actuators if x.verb != "hoist"}
    assert winches | drives <= halted[0]


def moved(use: Use, share: float) -> Use | None:
    """The limit of a use, without contingencies, so that its value uses `share` of it."""
    limit, value = msgspec.structs.replace(use.limit, spread=0.0, inputs=""), use.value
    if value is None or not value or not limit.known or use.use is None or not isfinite(use.use) or limit.rest:
        return None
    if limit.between is not None:
        low, high = limit.between
        middle, half = (low + high) / 2.0, abs(value - (low + high) / 2.0) / share
        row = msgspec.structs.replace(limit, between=(middle - half, middle + half)) if half else None
    elif limit.chart:
        row = msgspec.structs.replace(limit, chart=tuple((x, y * use.use / share) for x, y in limit.chart))
    else:
        row = msgspec.structs.replace(limit, value=value * share if limit.least else value / share)
    return None if row is None else Use(row, value)


@pytest.mark.parametrize("share", [0.95, 1.2])
def test_the_check_of_each_limit_is_red_exactly_when_the_limit_is_exceeded(lift: Lift, share: float) -> None:
    scene, seen = lift.read(), set()
    states = scene.statics.states
    ran = replace(signals_of(states), dynamic=True)
    for use in (x for x in scene.uses if x.limit.quantity not in AT_ONCE):
        if (row := moved(use, share)) is None:
            continue
        plan = msgspec.structs.replace(scene.plan, limits=(row.limit,))
        (check,) = (x for x in checks_of(plan, uses_on_path(plan, states), (), None, ()) if x.basis)
        assert (check.state == "red") == (share > 1.0), (use.limit.quantity, use.limit.subject)
        seen.add(use.limit.quantity)
        if use.limit.quantity in ORDERED:  # without an error
            continue
        (check,) = (x for x in checks_of(plan, uses_of(plan, [ran]), (), {}, ()) if x.basis)
        assert check.state == "red" if share > 1.0 else check.why == UNKNOWN, (use.limit.quantity, use.limit.subject)
        error = {f"use of {row.limit.subject} {row.limit.quantity}": 0.04}
        (check,) = (x for x in checks_of(plan, uses_of(plan, [ran]), (), error, ()) if x.basis)
        assert check.state == ("red" if share > 1.0 else "green"), (use.limit.quantity, use.limit.subject)
        error = {f"use of {row.limit.subject} {row.limit.quantity}": 0.3}
        (check,) = (x for x in checks_of(plan, uses_of(plan, [ran]), (), error, ()) if x.basis)
        assert check.state == "undecided", (use.limit.quantity, use.limit.subject)
    assert len(seen) >= 8, seen
