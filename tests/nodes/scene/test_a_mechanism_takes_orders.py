"""A mechanism takes orders by the names of its drives, winches and brakes, and conditions may refer to it."""

import math

from heavylift.kernel.description import Point, Threshold
from heavylift.nodes.plan import And, BrakeOrder, CrossingCondition, LiftedCondition, Move, SlingsCondition, Wait
from heavylift.nodes.scene import parse

SCENE = """\
heavylift: 1
name: portal
mechanism:
  name: portal
  bodies:
    cart: {mass: 400 t}
    jib: {mass: 10 t, com: [5 m, 0, 0], inertia: [0, 80000 kg m2, 80000 kg m2]}
    load: {mass: 450 t, inertia: [1e7 kg m2, 1e7 kg m2, 1e7 kg m2]}
  joints:
    rail: {type: prismatic, child: cart, at: [0, 0, 60 m], axis: [0, 1, 0], start: 2 m}
    slew: {type: revolute, parent: cart, child: jib, axis: [0, 0, 1], start: 90 deg}
    free: {type: free, child: load}
  drives:
    trolley: {joint: rail, type: servo, stiffness: 10 MN/m, damping: 4 MN s/m, ramp: 0.05 m/s2, range: [-10 m, 60 m]}
    turntable: {joint: slew, type: prescribed, ramp: 1 deg/s2}
  brakes:
    parking: {joint: rail, holds: 10 kN, stiffness: 1 MN/m, damping: 10 kN s/m}
  ropes:
    rope:
      start: {body: cart}
      end: {body: load}
      EA: 1870.176 MN
      length: 60.1 m
      winch: {ramp: 1 m/s2, shortest: 5 m, longest: 80 m}
  supports:
    ground: {body: load, height: 0 m, stiffness: 800 MN/m, damping: 20 MN s/m}
actions:
  - rope: hoist 3 m/min until lifted
    parking: release
  - trolley: drive 20 m/min by 2 m
    turntable: drive 1 deg/s to -30 deg
  - when: height of load >= 1 m and rope taut
    timeout: 5 min
    rope: hoist 3 m/min to 50 m of rope or until tension of rope >= 5 MN
  - wait 5 s
"""


def test_orders_to_a_mechanism_reach_its_actuators() -> None:
    built = parse(SCENE).plan
    first, second, third, last = built.actions
    release, hoist = first.orders  # parking before rope, whatever the file says first
    assert isinstance(hoist, Move)
    assert (hoist.model, hoist.actuator, hoist.speed, hoist.accel, hoist.by) == ("portal", "rope", -0.05, 1.0, None)
    assert isinstance(hoist.until, LiftedCondition)
    assert hoist.until.model == "portal"
    assert release == BrakeOrder(model="portal", brake="parking", engaged=False, where="scene.yaml:29:5")
    drive, turn = second.orders
    assert isinstance(drive, Move)
    assert isinstance(turn, Move)
    assert (drive.actuator, drive.by, drive.accel) == ("trolley", 2.0, 0.05)
    assert (turn.actuator, turn.to, turn.speed) == ("turntable", math.radians(-30), math.radians(1))
    wind = third.orders[0]
    assert isinstance(wind, Move)
    assert (wind.to, third.timeout) == (50.0, 300.0)
    assert last.orders == (Wait(seconds=5.0, where="scene.yaml:35:5"),)


def test_conditions_on_a_mechanism_use_thresholds_of_their_own() -> None:
    built = parse(SCENE).plan
    when, until = built.actions[2].when, built.actions[2].orders[0]
    assert isinstance(when, And)
    height, taut = when.all
    assert isinstance(height, CrossingCondition)
    assert height.threshold == Threshold("height-2", "height", point=Point("load"))
    assert (height.model, height.value, height.rising) == ("portal", 1.0, True)
    assert isinstance(taut, SlingsCondition)
    assert (taut.names, taut.state) == (("rope",), "taut")
    assert isinstance(until, Move)
    assert isinstance(until.until, CrossingCondition)
    assert until.until.threshold == Threshold("tension-1", "tension", ropes=("rope",))


def test_actuators_of_a_mechanism_have_the_start_and_end_positions_written_in_the_scene() -> None:
    mechanism = parse(SCENE).plan.machines[0]
    message = {a.name: (a.start, a.accel, a.lower, a.upper) for a in mechanism.actuators}
    assert message == {
        "trolley": (2.0, 0.05, -10.0, 60.0),
        "turntable": (math.pi / 2, math.radians(1), None, None),
        "rope": (60.1, 1.0, 5.0, 80.0),
    }
    assert (mechanism.taut, mechanism.closed) == ((), ())
