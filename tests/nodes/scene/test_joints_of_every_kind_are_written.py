"""Every type of joint in a scene file : frames, axes, limits, friction, laws on coordinates, locks."""

import math

import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.description import JOINTS, Brake, Drive, JointSpring, Lock, Stop
from heavylift.kernel.model import Program
from heavylift.nodes.plan import actions as a
from heavylift.nodes.scene import parse

HEAD = "heavylift: 1\nname: joints\nend: 1 s\nmechanism:\n  name: rig\n  bodies:\n"
BODY = "{mass: 1 t, inertia: [900 kg m2, 900 kg m2, 900 kg m2]}"
SCENE = (
    HEAD
    + "".join(f"    b{i}: {BODY}\n" for i in range(10))
    + """\
  joints:
    mast: {type: revolute, child: b0, rotation: [90 deg, 0, 90 deg], at: [0, 0, 2 m], axis: [0, 0, 1]}
    ram:
      type: cylindrical
      parent: b0
      child: b1
      axis: [1, 0, 0]
      start: [200 mm, 30 deg]
      speed: [6 m/min, 1 rad/s]
      limits: {travel: {range: [0, 3 m], stiffness: 10 MN/m}}
      friction: {angle: {viscous: 2 kN m s/rad, dry: 1 kN m, stiffness: 1 MN m/rad, damping: 5 kN m s/rad}}
    spindle: {type: screw, child: b2, axis: [0, 0, 2], lead: 10 mm, start: 1 deg}
    cross: {type: universal, parent: b1, child: b3, axis: [1, 0, 0], second axis: [0, 1, 0], start: [1 deg, 2 deg]}
    table: {type: planar, child: b4, normal: [0, 0, 1], x axis: [0, 1, 0], start: [1 m, 2 m, 90 deg]}
    floor: {type: planar, child: b5, normal: [1, 0, 0]}
    shaft: {type: constant-velocity, parent: b2, child: b6, shaft: [0, 0, 1], start: [0, 20 deg]}
    ball: {type: spherical, parent: b3, child: b7}
    loose: {type: free, child: b8, position: [0, 0, 9 m]}
    weld: {type: fixed, parent: b8, child: b9}
  stops:
    fence: {joint: table, coordinate: y, range: [-1 m, 5 m], stiffness: 1 MN/m}
  brakes:
    shoe: {joint: ram, coordinate: travel, holds: 5 kN, stiffness: 1 MN/m}
  springs:
    return: {joint: shaft, coordinate: angle2, stiffness: 3 kN m/rad, rest: 10 deg}
  locks:
    bolt: {joint: cross}
    pin: {joint: loose, engaged: true}
  drives:
    slew: {joint: ram, coordinate: angle, type: prescribed, ramp: 1 deg/s2}
    push: {joint: ram, coordinate: travel, type: servo, stiffness: 1 MN/m, damping: 1 kN s/m, ramp: 1 m/s2}
    turn: {joint: spindle, type: prescribed, ramp: 1 deg/s2}
actions:
  - bolt: lock
    pin: unlock
  - slew: drive 5 deg/s by 10 deg
  - when: position of ram.travel >= 2 m and speed of spindle <= 1 deg/s
    slew: drive 5 deg/s by 10 deg
"""
)


def test_a_scene_file_with_every_joint_type_is_read():
    built = parse(SCENE).plan
    (mechanism,) = built.machines
    s = mechanism.system
    joints = {j.name: j for j in s.joints}
    assert {j.kind for j in s.joints} == set(JOINTS) - {"prismatic", "slider"}
    assert joints["mast"].R_PJ == ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), "exact quarter turns"
    assert (joints["ram"].q0, joints["ram"].v0) == ((0.2, math.radians(30)), (0.1, 1.0))
    assert (joints["spindle"].axis, joints["spindle"].pitch) == ((0.0, 0.0, 1.0), 0.01 / (2 * math.pi))
    assert (joints["cross"].axis, joints["cross"].second) == ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    assert (joints["table"].axis, joints["table"].second) == ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0))
    assert joints["floor"].second == (0.0, 1.0, 0.0), "x lies across the normal, whatever that is"
    assert joints["shaft"].second == (1.0, 0.0, 0.0)
    assert s.stops == (
        Stop("fence", "table", -1.0, 5.0, 1e6, 0.0, "y"),
        Stop("ram.travel.limits", "ram", 0.0, 3.0, 1e7, 0.0, "travel"),
    )
    assert s.brakes == (
        Brake("shoe", "ram", 5e3, 1e6, 0.0, False, "travel"),
        Brake("ram.angle.dry", "ram", 1e3, 1e6, 5e3, True, "angle"),
    )
    assert s.springs == (
        JointSpring("return", "shaft", 3e3, 0.0, math.radians(10), "angle2"),
        JointSpring("ram.angle.viscous", "ram", d=2e3, coordinate="angle"),
    )
    assert s.locks == (Lock("bolt", "cross"), Lock("pin", "loose", True))
    assert s.drives[1] == Drive("slew", "ram", "prescribed", coordinate="angle")
    assert [round(x.start, 12) for x in mechanism.actuators] == [
        0.2,
        round(math.radians(30), 12),
        round(math.radians(1), 12),
    ]
    Program(s)
    travel, spindle = built.actions[2].when.all
    assert (travel.threshold.of, travel.threshold.coordinate) == ("ram", "travel")
    assert (spindle.threshold.of, spindle.threshold.coordinate) == ("spindle", "")
    bolt, pin = built.actions[0].orders
    assert bolt == a.BrakeOrder(model="rig", brake="bolt", engaged=True, where="scene.yaml:50:5")
    assert pin == a.BrakeOrder(model="rig", brake="pin", engaged=False, where="scene.yaml:51:5")


def lines(old: str, new: str) -> list[str]:
    assert SCENE.count(old) == 1, old
    with pytest.raises(SceneError) as e:
        parse(SCENE.replace(old, new))
    return [line for line in str(e.value).splitlines() if line.startswith("scene.yaml:")]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "second axis: [0, 1, 0]",
            "second axis: [1, 1, 0]",
            "scene.yaml:29:5: error: mechanism.joints.cross: joint 'cross': the angle between its axes is 45 deg; "
            "the second axis of a universal joint must be perpendicular to the first",
        ),
        (
            "second axis: [0, 1, 0]",
            "second axis: [0, 0, 0]",
            "scene.yaml:29:83: error: mechanism.joints.cross.second axis: an axis needs a direction, such as [0, 0, 1]",
        ),
        (
            "lead: 10 mm",
            "lead: 0 mm",
            "scene.yaml:28:5: error: mechanism.joints.spindle: joint 'spindle': its pitch is 0; give the pitch of a "
            "screw in m/rad, or make the joint revolute",
        ),
        (
            "fence: {joint: table, coordinate: y,",
            "fence: {joint: table,",
            "scene.yaml:37:20: error: mechanism.stops.fence.joint: the planar joint 'table' has several coordinates: "
            "add 'coordinate: x' or 'coordinate: y' or 'coordinate: angle'",
        ),
        (
            "coordinate: y,",
            "coordinate: z,",
            "scene.yaml:37:39: error: mechanism.stops.fence.coordinate: a planar joint has no coordinate 'z'",
        ),
        (
            "coordinate: y,",
            "coordinate: angle,",
            "scene.yaml:37:54: error: mechanism.stops.fence.range[0]: '-1 m' is "
            "not a valid angle: 'm' is a unit of length; "
            "use deg, rad",
        ),
        (
            "{travel: {range: [0, 3 m]",
            "{way: {range: [0, 3 m]",
            "scene.yaml:26:16: error: mechanism.joints.ram.limits.way: a cylindrical joint has no coordinate 'way' to "
            "act on",
        ),
        (
            "dry: 1 kN m,",
            "dry: 1 kN,",
            "scene.yaml:27:54: error: mechanism.joints.ram.friction.angle.dry: "
            "'1 kN' is not a valid moment: 'kN' is a unit of "
            "force; use kN m, N m, MN m",
        ),
        (
            "bolt: {joint: cross}",
            "bolt: {joint: cros}",
            "scene.yaml:43:19: error: mechanism.locks.bolt.joint: there is no joint 'cros'",
        ),
        (
            "slew: {joint: ram, coordinate: angle,",
            "slew: {joint: ram, coordinate: travel,",
            "two drives",
        ),
        ("bolt: lock", "bolt: release", "cannot release"),
        ("position of ram.travel", "position of ram", "there is no 'ram' with position"),
    ],
)
def test_faults_of_a_joint_are_reported_with_their_line_in_the_scene(old, new, told):
    found = lines(old, new)
    assert any(told in line for line in found), found


def test_an_impossible_inertia_is_reported_at_the_line_of_its_body():
    wrong = HEAD + "    top: {mass: 1 t, inertia: [1 kg m2, 1 kg m2, 3 kg m2]}\n"
    wrong += "  joints:\n    pin: {type: spherical, child: top}\n"
    with pytest.raises(SceneError) as e:
        parse(wrong)
    assert (
        str(e.value)
        .splitlines()[0]
        .startswith(
            "scene.yaml:7:22: error: mechanism.bodies.top.inertia: body 'top': its principal moments of inertia are 1, "
            "1, 3 kg m2; none can be larger than the sum of the other two"
        )
    )
