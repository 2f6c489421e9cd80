"""The speed of a lift-off is that of the fastest hoisting that may part the block from its stools."""

from random import Random

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.fidelity import by_ways, case_of, drive_name, girder, lift_of
from heavylift.nodes.plan import Fidelity
from heavylift.nodes.scene import load
from heavylift.nodes.scene.checks.orders import LOADED
from heavylift.nodes.scene.text import library
from lifted import lifted

SLOW, FAST = 0.3 / 60.0, 3.0 / 60.0  # [m/s]
NEARLY = 0.9  # of its speed at least, since the stools give way as the ropes do
CREEPS = "{stage: take up slack, all hooks: hoist 0.3 m/min until all slings taut}"


def hoisting(*orders):
    """The bundled lift with other hoists behind the creep."""
    stages = [f"{{stage: lift {i}, all hooks: hoist {order}}}" for i, order in enumerate(orders)]
    return [f"actions=[{', '.join([CREEPS, *stages, '{stage: hang, wait: 5 s}'])}]", "end=60 s"]


def case(*orders):
    scene = load("lift", hoisting(*orders))
    return case_of(scene.plan, scene.followed)


@pytest.mark.parametrize(
    ("orders", "speed"),
    [
        (["0.3 m/min until lifted", "3 m/min by 1 m"], SLOW),
        (["3 m/min by 1 m"], FAST),
        (["0.3 m/min by 20 mm", "3 m/min by 1 m"], FAST),  # so little only stretches the ropes
        (["0.3 m/min by 1 m", "3 m/min by 1 m"], SLOW),
    ],
    ids=str,
)
def test_what_hoists_while_the_block_may_stand_counts(orders, speed):
    found = max(hook.picks for hook in case(*orders).hooks)
    assert NEARLY * speed <= found <= speed


def test_what_is_predicted_bounds_a_lift_by_a_way():
    orders = hoisting("3 m/min by 1 m")
    predicted = girder(case("3 m/min by 1 m"), Fidelity(girder="elastic")).errors["rope tension"]
    stiff, bent = (lifted(load("lift", [*orders, f"fidelity.girder={g}"])).peaks for g in ("rigid", "elastic"))
    measured = float(abs(stiff / bent - 1.0).max())
    assert 0.005 < measured <= predicted


def test_a_move_to_a_place_has_a_way():
    scene = load("lift", ["actions.3.trolleys=traverse 20 m/min to 82 m"])
    starts = {
        drive_name("crane", t.name): t.axis.start
        for t in (lift_of(scene.plan).cranes[0].upper, lift_of(scene.plan).cranes[0].lower)
    }
    assert scene.plan.actions[3].orders[0].by is None
    sideways = by_ways(scene.plan, scene.followed).actions[3].orders
    assert {m.actuator: m.by for m in sideways} == {name: 82.0 - y for name, y in starts.items()}
    ramps = [knot.accel for knot in case_of(scene.plan, scene.followed).swings.knots[1] if abs(knot.accel) > 0.01]
    assert len(ramps) == 6, "each trolley ramps up, cruises, ramps down; they begin together, the nearer ends first"


@pytest.mark.parametrize("way", ["by 1 m", "until lifted"])
def test_what_lifts_is_no_faster_than_a_loaded_winch_may_be(way):
    with pytest.raises(SceneError, match=r"hoist 4 m/min is faster than crane can with a load: 3 m/min"):
        load("lift", ["cranes.crane={type: goliath-900, at: 40 m, hoist speed: 3 m/min}", *hoisting(f"4 m/min {way}")])


def test_an_empty_winch_may_be_faster():
    assert load(
        "lift",
        [
            "cranes.crane={type: goliath-900, at: 40 m, hoist speed: 3 m/min}",
            "actions.0.all hooks=hoist 4 m/min by 10 mm",
        ],
    )


@pytest.mark.parametrize("crane", sorted(x for x in library() if x.startswith("goliath")))
def test_a_load_on_the_hook_is_one_on_its_supports_too(crane: str):
    """Whatever the way down, a hook is as fast as an empty one only once its slings carry next to nothing."""
    draw, seen = Random(crane), set()
    up = ["all hooks: hoist 0.3 m/min until all slings taut", "all hooks: hoist 0.3 m/min until lifted"]
    given = [f"cranes.crane={{type: {crane}, at: 40 m, hoist speed: 3 m/min, hook spacing: 6 m}}", "end=10 min"]
    for way in (draw.uniform(5, 30), draw.uniform(100, 150)):
        lists = [
            [*up, f"all hooks: lower 0.3 m/min by {way:.4g} mm", f"all hooks: lower {speed} m/min by 0.2 m"]
            for speed in (0.3, 4)
        ]
        slow, fast = ([*given, f"actions=[{', '.join(f'{{{x}}}' for x in orders)}]"] for orders in lists)
        scene = load("lift", slow)
        before = scene.statics.acted[3].before
        loaded = any(before.tensions[sling.name] > LOADED for sling in scene.plan.rig.slings)
        seen.add((loaded, before.grounded))
        if loaded:
            with pytest.raises(SceneError, match=r"lower 4 m/min is faster than crane can with a load: 3 m/min"):
                load("lift", fast)
        else:
            assert load("lift", fast)
    assert seen == {(True, True), (False, True)}
