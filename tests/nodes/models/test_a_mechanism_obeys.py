"""A mechanism of a scene executes orders: drives, winches, brakes, supports and ropes."""

from heavylift.kernel.description import Body, Brake, Drive, Joint, Line, Point, Rope, Support, System, Threshold
from heavylift.nodes.models.parts import Finished, Limit, Reached, SetBrake, SetProfile, StateEvent, Touched, Watch
from heavylift.nodes.plan import Actuator, Mechanism, Plan, actions as a
from yard import Yard

SYSTEM = System(
    bodies=(Body("load", 1000.0), Body("arm", 10.0)),
    joints=(
        Joint("slide", "prismatic", "world", "load", q0=(0.0,), v0=(0.0,)),
        Joint("hinge", "revolute", "load", "arm", q0=(0.5,), v0=(0.0,)),
    ),
    brakes=(Brake("arm brake", "hinge", 10.0, 1e4, 1e2, engaged=True),),
    drives=(Drive("motor", "hinge", "servo", 1e4, 1e3),),
    ropes=(Rope("rope", (Line(Point("world", (0.0, 0.0, 10.0)), Point("load")),), 1e7, 10.0, winch=True),),
    supports=(Support("left", Point("load"), 0.0, 1e6, 1e3), Support("right", Point("load"), 0.0, 1e6, 1e3)),
)
ACTUATORS = (Actuator(name="motor", start=0.5, accel=0.1, lower=0.0, upper=1.5),)


def plan(*actions: a.Action) -> Plan:
    mechanism = Mechanism(name="rig", system=SYSTEM, actuators=ACTUATORS, closed=("left", "right"))
    return Plan(name="test", machines=(mechanism,), actions=actions)


def move(actuator: str, speed: float, by: float | None = None, until: a.Condition | None = None) -> a.Move:
    return a.Move(verb="drive", model="rig", actuator=actuator, speed=speed, accel=0.1, by=by, until=until)


def test_in_a_mechanism_the_brake_is_released_before_the_motor_turns() -> None:
    release = a.Action(orders=(a.BrakeOrder(model="rig", brake="arm brake", engaged=False),))
    builder = Yard(plan(release, a.Action(orders=(move("motor", 0.1, by=0.5),)))).run()
    assert [(t, m) for t, _, m in builder.kernel.got] == [
        (0.0, SetBrake("arm brake", False)),
        (0.0, SetProfile("motor", 0, 0.1, 0.1, 0.5)),
    ]
    assert builder.said("commander.actions", Finished) == [(6.0, Finished())]


def test_the_load_of_a_mechanism_is_lifted_off_its_two_supports() -> None:
    up = a.Action(orders=(move("rope", -0.1, until=a.LiftedCondition(model="rig")),))
    script = [(7.0, StateEvent("left", "open", 0.0)), (8.0, StateEvent("right", "open", 0.0))]
    builder = Yard(plan(up), *script).run()
    assert [t for t, _ in builder.inputs(SetProfile)] == [0.0, 8.0]
    assert builder.said("commander.actions", Finished) == [(9.0, Finished())]


def test_a_block_that_touches_only_one_of_its_supports_has_not_landed_yet() -> None:
    down = a.Action(when=a.LandedCondition(model="rig"), orders=(move("rope", 0.1, by=1.0),))
    wait = a.Action(when=a.LiftedCondition(model="rig"), orders=())
    script = [(7.0 + i, StateEvent(name, "open", 0.0)) for i, name in enumerate(("left", "right"))]
    script += [(17.0 + i, StateEvent(name, "closed", 0.0)) for i, name in enumerate(("left", "right"))]
    builder = Yard(plan(wait, down), *script).run()
    assert [t for t, _ in builder.said("rig.load-body.supports", Touched)] == [17.0]
    assert [t for t, _ in builder.inputs(SetProfile)] == [18.0]


def test_the_motor_of_a_mechanism_stops_at_the_end_of_its_range() -> None:
    builder = Yard(plan(a.Action(orders=(move("motor", 0.1),)))).run()
    assert builder.said("rig.hinge-joint.motor", Limit) == [(11.0, Limit("motor", "travel limit", 1.5))]


def test_the_winch_of_a_mechanism_stops_when_its_rope_tension_reaches_the_threshold() -> None:
    guard = Threshold("tension-1", "tension", ropes=("rope",))
    tight = a.CrossingCondition(model="rig", threshold=guard, value=5e3, rising=True)
    pull = a.Action(orders=(move("rope", -0.1, until=tight),))
    builder = Yard(plan(pull), (4.0, StateEvent("tension-1", "reached", 5e3))).run()
    assert builder.inputs(Watch) == [(0.0, Watch("tension-1", 5e3, True))]
    assert builder.said("rig.gauge", Reached) == [(4.0, Reached("tension-1", 5e3))]
    assert [(t, m.speed) for t, m in builder.inputs(SetProfile)] == [(0.0, -0.1), (4.0, 0.0)]
