"""Every kind of joint, alone and together, against Pinocchio, MuJoCo and closed forms."""

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from heavylift.kernel.description import JOINTS, Body, Joint, JointSpring, System
from heavylift.kernel.model import Program, evaluate
from heavylift.kernel.multibody.kinematics import kinematics
from random_trees import (
    GRAVITY,
    KINDS,
    nested,
    pinocchio_coordinates,
    pinocchio_model,
    random_state,
    random_system,
    rotation,
    turns_of,
)
from small_scenes import SECOND, X, Y, Z, column, hand_over, started

SAME = 1e-9  # relative: the acceptance of every joint against other programs
CLOSES = 1e-8  # of the energy turned over, at a step tolerance of 1e-9
TIGHT = 1e-11  # step tolerance where a closed form is followed
SOLID = Body("a", 300.0, (0.2, -0.1, 0.3), ((90.0, 4.0, -3.0), (4.0, 80.0, 2.0), (-3.0, 2.0, 100.0)))
ASKEW = nested(rotation(np.random.default_rng(8)))
MOVING = [k for k in JOINTS if JOINTS[k].n_v and k != "slider"]  # which needs a flexible beam


def joint(kind, name="j", parent="world", child="a", **more):
    return Joint(name, kind, parent, child, (0.3, 0.1, -0.2), ASKEW, pitch=0.07 if kind == "screw" else 0.0, **more)


def accelerations(program, q, v):
    return np.asarray(evaluate(program, 0.0, [*q, *v], program.parameters.initial).dy[program.nq :], float)


def pinocchio_accelerations(graph, q, v):
    """Of N^T (M N dv + h) = 0 with N the constant map to Pinocchio's velocities."""
    model, N = pinocchio_model(graph), turns_of(graph)
    data, at = model.createData(), pinocchio_coordinates(graph, q)
    M = np.triu(pin.crba(model, data, at))
    M = M + np.triu(M, 1).T
    return np.linalg.solve(N.T @ M @ N, -N.T @ pin.nonLinearEffects(model, data, at, N @ v))


def relative(x, want):
    return np.abs(x - want).max() / np.abs(want).max()


@pytest.mark.parametrize("kind", MOVING)
def test_joints_on_the_ground_and_on_a_moving_body_agree_with_pinocchio(kind):
    alone = System((SOLID,), (joint(kind),), gravity=GRAVITY)
    carrier = Joint("carrier", "free", "world", "b")
    carried = System((Body("b", 900.0, inertia=SOLID.inertia), SOLID), (carrier, joint(kind, parent="b")))
    for system in (alone, carried):
        program = Program(system)
        for seed in range(4):
            q, v = random_state(program.graph, seed)
            want = pinocchio_accelerations(program.graph, q, v)
            assert relative(accelerations(program, q, v), want) < SAME


@pytest.mark.parametrize("seed", range(12))
def test_random_trees_of_all_joint_types_agree_with_pinocchio(seed):
    system = random_system(seed, 8, 2.0, kinds=(*KINDS, "constant-velocity"))
    program = Program(system)
    q, v = random_state(program.graph, seed)
    assert relative(accelerations(program, q, v), pinocchio_accelerations(program.graph, q, v)) < SAME


# ---- MuJoCo: joints as lists of its own ---------------------------------------------------------------------

INTO_MUJOCO = {
    "revolute": lambda e: [("hinge", e[0])],
    "prismatic": lambda e: [("slide", e[0])],
    "cylindrical": lambda e: [("slide", e[0]), ("hinge", e[0])],
    "universal": lambda e: [("hinge", e[0]), ("hinge", e[1])],
    "planar": lambda e: [("slide", e[1]), ("slide", e[2]), ("hinge", e[0])],
    "spherical": lambda e: [("ball", e[0])],
}


def mujoco_model(graph):
    """Bodies nested as the links are, each with the joints of `INTO_MUJOCO`."""
    spec = mujoco.MjSpec()
    spec.option.gravity = [0.0, 0.0, -GRAVITY]
    spec.compiler.degree = False
    made = []
    for link in graph.links:
        j, body = link.joint, link.body
        on = spec.worldbody if link.parent < 0 else made[link.parent]
        b = on.add_body(name=body.name, pos=j.p_PJ)
        b.quat = np.roll(pin.Quaternion(np.array(j.R_PJ)).coeffs(), 1)
        I = np.array(body.inertia)
        b.explicitinertial, b.mass, b.ipos = True, body.mass, body.com
        b.fullinertia = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]
        axes = [np.array(j.axis), np.array(j.second), np.cross(j.axis, j.second)]
        for kind, axis in INTO_MUJOCO[j.kind](axes):
            b.add_joint(type=getattr(mujoco.mjtJoint, f"mjJNT_{kind.upper()}"), axis=axis)
        made.append(b)
    return spec.compile()


@pytest.mark.parametrize("seed", range(8))
def test_random_trees_agree_with_mujoco(seed):
    kinds = (*INTO_MUJOCO,)
    system = random_system(seed, 8, 2.0, kinds=kinds)
    root = next(j for j in system.joints if j.kind == "free")
    system = replace(system, joints=tuple(replace(j, kind="spherical") if j is root else j for j in system.joints))
    program = Program(system)
    model = mujoco_model(program.graph)
    data = mujoco.MjData(model)
    q, v = random_state(program.graph, seed)
    data.qpos[:] = q
    for link in program.graph.links:
        if link.joint.kind == "spherical":  # w x y z there, x y z w here
            data.qpos[link.q] = np.roll(q[link.q], 1)
    data.qvel[:] = v
    mujoco.mj_forward(model, data)
    assert relative(accelerations(program, q, v), data.qacc) < SAME


# ---- closed forms --------------------------------------------------------------------------------------------


def test_a_nut_falls_along_its_screw_with_the_acceleration_of_the_closed_form():
    """q'' = -m g p / (m p^2 + I) about a vertical screw of pitch p."""
    p, m, I = 0.05, 120.0, 3.0
    nut = Body("nut", m, inertia=((5.0, 0.0, 0.0), (0.0, 5.0, 0.0), (0.0, 0.0, I)))
    screw = Joint("screw", "screw", "world", "nut", pitch=p)
    s = started(System((nut,), (screw,), gravity=GRAVITY), tolerance=TIGHT)
    s.interrupt(SECOND)
    s.settle()
    assert column(s, "joint/position")[1][-1, 0] == pytest.approx(-0.5 * m * GRAVITY * p / (m * p * p + I), rel=1e-9)
    assert column(s, "pose/nut")[1][-1, 2] == pytest.approx(-0.5 * m * GRAVITY * p**2 / (m * p * p + I), rel=1e-9)


@pytest.mark.parametrize("bend", [0.0, 0.3, 1.2, 2.5])
@pytest.mark.parametrize("turn", [0.0, 0.7, 2.0, 4.1])
def test_shafts_of_a_constant_velocity_joint_turn_at_equal_rates_at_any_bend(bend, turn):
    """The output shaft keeps its direction in the world; the component of its angular velocity along itself is the
    input's, in every position (a universal joint lets it swing between cos and 1/cos of the bend)."""
    system = System(
        (SOLID, replace(SOLID, name="b")),
        (Joint("in", "revolute", "world", "a", axis=Z), Joint("cv", "constant-velocity", "a", "b", axis=Z, second=X)),
    )
    program = Program(system)
    direction = np.array([np.sin(bend), 0.0, np.cos(bend)])
    inward = np.array([[np.cos(turn), np.sin(turn), 0.0], [-np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]])
    x, y, z = inward @ direction
    half = np.array([x, y, 1.0 + z]) / np.sqrt(2.0 * (1.0 + z))  # the mirror plane's normal: Rx(a) Ry(b) z
    q = np.array([turn, np.arctan2(-half[1], half[2]), np.arcsin(half[0])])

    K = [kinematics(program.instances[0][0], q, unit, 0.0) for unit in np.eye(3)]
    assert K[0].R[1][:, 2].astype(float) == pytest.approx(direction, abs=1e-12)
    w = np.array([k.V[1][:3] for k in K], dtype=float).T  # angular velocity of the output per velocity
    across = np.array([np.cross(w[:, i], direction) for i in range(3)]).T
    rates = np.linalg.lstsq(across[:, 1:], -across[:, 0], rcond=None)[0]
    output = w @ np.array([1.0, *rates])
    assert np.cross(output, direction) == pytest.approx(np.zeros(3), abs=1e-12)
    assert output @ direction == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("kind", MOVING)
def test_every_joint_type_conserves_energy_in_machine_code(kind):
    """The balance closes with a damped spring on every coordinate: columns, bias, places and laws fit each other."""
    v0 = tuple(0.3 + 0.2 * i for i in range(JOINTS[kind].n_v))
    springs = tuple(JointSpring(c, "j", 2e3, 1e2, 0.1, coordinate=c) for c in JOINTS[kind].actable)
    system = System((SOLID,), (joint(kind, v0=v0),), springs=springs, gravity=GRAVITY)
    s = started(system, tolerance=1e-9, sample_ns=SECOND // 10)
    hand_over(s, 2 * SECOND)
    s.settle()
    _, e = column(s, "energy")
    total = e[:, 0] + e[:, 1] + e[:, 2] - e[:, 3] + e[:, 4]
    assert np.ptp(total) < CLOSES * np.ptp(e[:, 0])
    assert bool(springs) == (e[-1, 4] > 1.0), "the damping made heat"


def test_bodies_move_along_and_turn_about_the_axes_of_their_joints():
    """Planar: `second` is x; universal: the first turn carries the second axis; both shown by the child's pose."""

    def pose(kind, q0, **axes):
        system = System((SOLID,), (Joint("j", kind, "world", "a", q0=q0, **axes),))
        s = started(system)
        s.settle()
        return np.round(column(s, "pose/a")[1][0], 12)

    quarter = np.pi / 2
    assert pose("planar", (2.0, 3.0, quarter), axis=Z, second=Y)[:3].tolist() == [-3.0, 2.0, 0.0]
    assert pose("planar", (0.0, 0.0, np.pi), axis=X, second=Y)[3:].tolist() == [1.0, 0.0, 0.0, 0.0]
    half = np.sqrt(0.5)
    assert pose("universal", (quarter, quarter), axis=Z, second=X)[3:] == pytest.approx([0.5, 0.5, 0.5, 0.5])
    assert pose("cylindrical", (2.0, quarter), axis=Y) == pytest.approx([0, 2.0, 0, 0, half, 0, half])
    assert pose("constant-velocity", (0.0, np.pi / 4), axis=Z, second=X)[3:] == pytest.approx([0, half, 0, half])
