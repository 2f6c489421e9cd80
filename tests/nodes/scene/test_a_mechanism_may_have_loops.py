"""A joint to a body that already has a joint, or to the world, closes a loop."""

import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.scene import parse

FOUR_BAR = """\
heavylift: 1
name: four-bar
mechanism:
  bodies:
    crank: {mass: 1 kg, com: [0, 0, 0.5 m], inertia: [0.1 kg m2, 0.1 kg m2, 0]}
    coupler: {mass: 1 kg, com: [0, 0, 0.5 m], inertia: [0.1 kg m2, 0.1 kg m2, 0]}
    rocker: {mass: 1 kg, com: [0, 0, 0.5 m], inertia: [0.1 kg m2, 0.1 kg m2, 0]}
  joints:
    a: {type: revolute, child: crank, axis: [0, 1, 0], speed: 1 rad/s}
    b: {type: revolute, parent: crank, child: coupler, at: [0, 0, 1 m], axis: [0, 1, 0], start: 90 deg, speed: -1 rad/s}
    c: {type: revolute, child: rocker, at: [1 m, 0, 0], axis: [0, 1, 0], speed: 1 rad/s}
    d: {type: revolute, parent: rocker, child: coupler, at: [0, 0, 1 m], at child: [0, 0, 1 m], axis: [0, 1, 0]}
actions:
  - wait 1 s
"""


def test_a_four_bar_linkage_can_be_written_by_its_joints() -> None:
    (mechanism,) = parse(FOUR_BAR).plan.machines
    s = Simulation(mechanism.system, tolerance=1e-9)
    s.start()
    assert [j.name for j in s.program.graph.loops] == ["d"]
    s.run(1_000_000_000)
    q = s.state[: s.program.nq]
    assert q[0] + q[1] == pytest.approx(1.5707963267948966, abs=1e-6), "the coupler stays level"


TURNED = FOUR_BAR.replace("{type: revolute, child: crank, axis", "{type: revolute, parent: crank, child: world, axis")
TURNED = TURNED.replace("{type: revolute, child: rocker,", "{type: revolute, parent: rocker, child: world,")


def test_a_joint_may_be_written_with_the_world_as_its_child() -> None:
    """Then the axes point the other way, and what turned forwards turns backwards."""
    text = TURNED.replace("at: [1 m, 0, 0], axis", "at child: [1 m, 0, 0], axis")
    (mechanism,) = parse(text.replace("speed: 1 rad/s", "speed: -1 rad/s")).plan.machines
    there, back = (Simulation(x, tolerance=1e-9) for x in (parse(FOUR_BAR).plan.machines[0].system, mechanism.system))
    for s in (there, back):
        s.start()
        s.run(1_000_000_000)
    assert back.state[:3] * [-1.0, 1.0, -1.0] == pytest.approx(there.state[:3], abs=1e-6)


UPSIDE_DOWN = """\
heavylift: 1
name: upside-down
mechanism:
  bodies:
    load: {mass: 1 t, inertia: [1 t m2, 1 t m2, 1 t m2]}
  joints:
    ball: {type: spherical, parent: load, child: world}
actions:
  - wait 1 s
"""


def test_a_joint_written_from_child_to_parent_that_cannot_be_reversed_is_reported_with_its_line() -> None:
    with pytest.raises(SceneError) as e:
        parse(UPSIDE_DOWN)
    assert "scene.yaml:6:3:" in str(e.value)
    assert "swap parent and child" in str(e.value)


DRIVEN = """heavylift: 1
name: shafts
gravity: 9.81 m/s2
mechanism:
  bodies:
    in: {mass: 1 kg, inertia: [0.01 kg m2, 0.01 kg m2, 0.01 kg m2]}
    out: {mass: 1 kg, inertia: [0.01 kg m2, 0.01 kg m2, 0.01 kg m2]}
  joints:
    bearing-in: {type: revolute, child: in, axis: [1, 0, 0]}
    bearing-out: {type: revolute, child: out, rotation: [0, 40 deg, 0], axis: [1, 0, 0]}
    cross: {type: universal, parent: in, child: out, axis: [0, 0, 1], second axis: [0, 1, 0]}
  drives:
    motor: {joint: bearing-in, type: speed, damping: 1 kN m s/rad, ramp: 100 rad/s2}
  forces:
    load: {type: load, body: out, moment: [9 N m, 0, 0]}
end: 1 s
"""


def test_a_drive_holds_a_loop_that_has_no_other_degree_of_freedom() -> None:
    """At rest the drive carries what a universal joint passes on: at 40 degrees, that of the power it would take."""
    scene = parse(DRIVEN)
    (state,) = scene.statics.states
    assert scene.statics.why == ""
    assert state.poses["in"][1][0][0] == pytest.approx(1.0)
