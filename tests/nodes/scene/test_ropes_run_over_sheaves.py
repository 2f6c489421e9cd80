"""`over` in a rope of a scene: points make lines of one tension, sheaves with radius or friction make a reeving."""

import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.description import InputSignal, Line, Point, Reeving, Rope, Sheave
from heavylift.nodes.plan import CrossingCondition, Move, SlingsCondition
from heavylift.nodes.scene import parse

SCENE = """\
heavylift: 1
name: tackle
mechanism:
  bodies:
    load: {mass: 1 t}
  joints:
    guide: {type: prismatic, child: load, axis: [0, 0, 1], start: -10 m}
  ropes:
    fall:
      start: {body: world, at: [-1 m, 0, 0]}
      over: [{body: load}, {body: world, SHEAVE}]
      end: {body: load}
      EA: 20 MN
      length: 30.4 m
      damping: 3 kN s/m
      winch: {ramp: 1 m/s2, shortest: 5 m, longest: 80 m}
actions:
  - fall: hoist 3 m/min by 1 m or until tension of fall >= 5 MN
  - when: fall taut
    fall: lower 3 m/min by 1 m
"""
SHEAVES = "at: [0.2 m, 0, 0], axis: [0, 2, 0], radius: 0.2 m, friction: 0.1, efficiency: 98 %"


def mechanism(sheave):
    return parse(SCENE.replace(", SHEAVE", f", {sheave}" if sheave else "")).plan.machines[0]


def test_a_rope_over_several_points_without_friction_has_one_tension():
    w, o, load = Point("world", (-1.0, 0.0, 0.0)), Point("world"), Point("load")
    system = mechanism("").system
    lines = (Line(w, load), Line(load, o), Line(o, load))
    assert system.ropes == (Rope("fall", lines, 2e7, 30.4, 3e3, winch=True),)
    assert system.forces == ()


def test_a_rope_over_sheaves_is_modelled_as_a_reeving():
    found = mechanism(SHEAVES)
    sheave = Sheave(Point("world", (0.2, 0.0, 0.0)), (0.0, 1.0, 0.0), 0.2, 0.1, 0.98)
    rope = Reeving(
        "fall",
        Point("world", (-1.0, 0.0, 0.0)),
        (Sheave(Point("load")), sheave),
        Point("load"),
        2e7,
        InputSignal(30.4, driven=True),
        3e3,
    )
    assert found.system.forces == (rope,)
    assert found.taut == ("fall",), "30.63 m of way for 30.4 m of rope"
    assert [(a.name, a.start, a.lower, a.upper) for a in found.actuators] == [("fall", 30.4, 5.0, 80.0)]


def test_a_rope_over_sheaves_takes_orders_and_can_be_waited_for():
    first, second = parse(SCENE.replace("SHEAVE", SHEAVES)).plan.actions
    hoist = first.orders[0]
    assert isinstance(hoist, Move)
    assert (hoist.verb, hoist.actuator, hoist.by) == ("hoist", "fall", -1.0)
    assert isinstance(hoist.until, CrossingCondition)
    assert isinstance(second.when, SlingsCondition)
    assert second.when.names == ("fall",)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("efficiency: 98 %", "efficiency: 120 %", "sheave 2 has an efficiency outside (0, 1]"),
        ("radius: 0.2 m", "radius: 20 m", "part 2 has no length; keep its ends apart"),
        ("{body: world, at: [0.2", "{body: hook, at: [0.2", "there is no body 'hook'"),
        ("length: 30.4 m", "length: 0 m", "a length must be greater than zero here, not 0 m"),
        ("length: 30.4 m", "length: 3.4 m", "3.4 m of rope is not between 5 and 80 m"),
    ],
)
def test_mistakes_in_ropes_over_sheaves_are_reported(old, new, told):
    text = SCENE.replace("SHEAVE", SHEAVES)
    assert text.count(old) == 1
    with pytest.raises(SceneError) as e:
        parse(text.replace(old, new))
    assert told in str(e.value)
    assert "scene.yaml:" in str(e.value)
