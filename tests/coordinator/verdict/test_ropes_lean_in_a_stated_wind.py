"""The off-lead in the wind of a factor sheet is the closed form, and that of an equilibrium in such a wind."""

from __future__ import annotations

from math import atan, radians, tan
from random import Random

import pytest
from heavylift.kernel.description import Check
from heavylift.nodes.limits import checks_of
from heavylift.nodes.plan import Shapes
from heavylift.nodes.scene import LoadedScene, load
from lift_of_a_type import Lift

G, AIR = 9.80665, 1.25
ALONE = 2e-3  # of the lean: booms bend, and some hook ropes have a weight of their own
SHARED = 0.06  # of the lean: a load on several hooks turns, too, and hook blocks have a weight of their own
HEIGHTS = 1.2  # ropes of three hooks differ by less in height
DRAG = 1.2
OFF_LEADS = ("off-lead", "off-lead along", "off-lead across")
SAME = 1e-9  # relative: the same path at rest
OF_A_FORCE = 1.225  # [kg/m3] density of the air of `forces`


def stated(lift: Lift, random: Random) -> tuple[float, float, float]:
    """Speed [m/s], area [m2] and push [N] of a wind in which the load leans by 0.6 to 3 degrees."""
    speed, push = random.uniform(5.0, 8.9), random.uniform(0.01, 0.05) * G * lift.read().scene.all_blocks["block"].mass
    return speed, push / (0.5 * AIR * DRAG * speed * speed), push


def rows(scene: LoadedScene) -> list[Check]:
    return [check for check in scene.checks if check.quantity == "off-lead in wind"]


def leads(scene: LoadedScene, stage: str) -> dict[str, float]:
    """The off-lead of each hook's rope as a load hangs at rest [rad], of the rope's own vertical plane."""
    (state,) = [x for x in scene.states if x.stage == stage and not x.grounded][-1:]
    found = {}
    for machine in scene.plan.machines:
        for hook in machine.hooks:
            (line, *_) = next(rope for rope in machine.system.straight_ropes if rope.name == hook.rope).lines
            a, b = ([*state.poses[p.body][0]] for p in (line.a, line.b))
            (ra, rb) = (state.poses[p.body][1] for p in (line.a, line.b))
            for place, R, p in ((a, ra, line.a.p), (b, rb, line.b.p)):
                for i in range(3):
                    place[i] += sum(R[i][j] * p[j] for j in range(3))
            found[hook.rope] = atan(((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5 / abs(a[2] - b[2]))
    return found


def test_a_load_in_wind_leans_by_the_ratio_of_wind_force_to_weight(lift: Lift) -> None:
    speed, area, push = stated(lift, Random(lift.text))
    scene = lift.read(f"factors={{wind: {speed!r} m/s, area: {area!r} m2}}")
    found, shapes = rows(scene), Shapes(scene.plan)
    hooks = {hook.rope: hook for machine in scene.plan.machines for hook in machine.hooks}
    used = {hooks[check.subject].eye.body for check in found}
    bodies = [body for machine in scene.plan.machines for body in machine.system.bodies]
    hangs = sum(x.mass for x in bodies if x.name in shapes.cargo or (shapes.hanging(x.name) and x.name in used))
    hangs += sum(x.mass for x in bodies if x.name.startswith("loader") and x.name not in used)
    own = max(x.value or 0.0 for x in scene.uses if x.limit.quantity in OFF_LEADS)
    assert found
    for check in found:
        closed, apart = push / (hangs * G), 1.0 if len(found) in (1, 4) else HEIGHTS
        assert closed / apart * (1.0 - ALONE) <= tan(check.value or 0.0) <= (tan(own) + closed * apart) * (1.0 + ALONE)


def test_the_reported_off_lead_of_ropes_in_wind_is_that_of_statics_with_a_wind_force(lift: Lift) -> None:
    random = Random(f"{lift.text} blown")
    speed, area, _ = stated(lift, random)
    along = random.choice(("[1, 0, 0]", "[0, 1, 0]"))
    drag = DRAG * AIR / OF_A_FORCE
    blows = f"type: wind, body: block, direction: {along}, speed: {speed!r} m/s, area: {area!r} m2, drag: {drag!r}"
    blown = leads(lift.read(f"mechanism={{forces: {{breeze: {{{blows}}}}}}}"), "up")
    found = {x.subject: x.value or 0.0 for x in rows(lift.read(f"factors={{wind: {speed!r} m/s, area: {area!r} m2}}"))}
    assert found == pytest.approx({hook: blown[hook] for hook in found}, rel=ALONE if len(found) == 1 else SHARED)


def test_an_off_lead_in_wind_beyond_its_limit_gives_a_red_check(lift: Lift) -> None:
    sets = "limits={off-lead: 1 deg}", "factors={wind: 10 m/s, area: 1e4 m2}"
    found = rows(lift.read(*sets))
    assert {(x.state, x.limit) for x in found} == {("red", radians(1.0))}
    assert len({x.subject for x in found}) == len(found)


def test_the_off_lead_in_wind_is_checked_in_the_direction_that_is_nearer_to_its_limit() -> None:
    for tight in ("along", "across"):
        given = {"along": 5.0, "across": 5.0} | {tight: 0.1}
        limits = ", ".join(f"off-lead {key}: {value} deg" for key, value in given.items())
        found = rows(load("lift", (f"limits={{{limits}}}", "factors={wind: 10 m/s, area: 200 m2}")))
        assert {(x.state, x.limit) for x in found} == {("red", radians(0.1))}


def test_the_off_lead_in_wind_is_checked_at_the_worst_values_of_uncertain_inputs(lift: Lift) -> None:
    speed, area, _ = stated(lift, Random(f"{lift.text} uncertain"))
    mass, wind = lift.read().scene.all_blocks["block"].mass, f"factors={{wind: {speed!r} m/s, area: {area!r} m2}}"
    worst = rows(lift.read(wind, f"block.mass={0.8 * mass!r} kg"))
    found = rows(lift.read(wind, f"block.mass={mass!r} kg +- 20 %"))
    assert [x.value for x in found] == pytest.approx([x.value for x in worst], rel=SAME)
    assert all("at the worst of block.mass" in x.basis for x in found)


def test_the_off_lead_in_wind_and_its_error_are_the_same_at_rest_and_after_a_run() -> None:
    scene = load("lift", ("factors={wind: 10 m/s, area: 200 m2}", "assumed=accept"))
    uses = [x for x in scene.uses if x.limit.quantity == "off-lead in wind"]
    assert {x.state for x in checks_of(scene.plan, uses, [], {}, ()) if x.quantity == "off-lead in wind"} == {"green"}


def test_the_area_in_the_wind_is_that_of_the_largest_face_unless_stated(lift: Lift) -> None:
    scene = lift.read("factors={wind: 10 m/s}")
    x, y, z = next(c.size for machine in scene.plan.machines for c in machine.cargo)
    stated = lift.read(f"factors={{wind: 10 m/s, area: {max(x * y, y * z, z * x)!r} m2}}")
    assert [(r.subject, r.value) for r in rows(scene)] == [(r.subject, r.value) for r in rows(stated)]
    assert rows(scene)
    assert not rows(lift.read("factors={wind: 0 m/s}"))
