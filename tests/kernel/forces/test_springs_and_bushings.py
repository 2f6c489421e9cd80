"""Springs along a line, about an axis and in six directions: MuJoCo, periods, and gradients of energies by SciPy."""

from dataclasses import replace
from math import pi, sqrt

import mujoco
import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, Bushing, Joint, Point, Spring, System, Torsion
from heavylift.kernel.simulation import Simulation
from scipy.spatial.transform import Rotation
from small_scenes import SECOND, X, Z, column, cube, imbalance, slider, started

SAME = 1e-9  # relative to the largest acceleration
GRADIENT = 1e-7  # of central differences with steps of 1e-6
CLOSES = 1e-9  # of the energy turned over; integrated at 1e-11
FINE = {"tolerance": 1e-11, "sample_ns": 20_000_000, "h_max": 0.02}
ALMOST_HALF_A_TURN = 3.0  # [rad]


def pair(attitude_a, attitude_b, **joints) -> System:
    """Two free bodies, askew, with eccentric masses."""
    inertia = ((3.0, 0.2, -0.1), (0.2, 4.0, 0.3), (-0.1, 0.3, 5.0))
    bodies = (Body("a", 7.0, (0.1, 0.2, -0.1), inertia), Body("b", 5.0, (-0.2, 0.1, 0.3), inertia))
    q_a, q_b = (tuple(Rotation.from_rotvec(r).as_quat()) for r in (attitude_a, attitude_b))
    v = joints.get("v", ((0.0,) * 6, (0.0,) * 6))
    return System(
        bodies,
        (
            Joint("fa", "free", "world", "a", q0=(0.0, 0.0, 1.0, *q_a), v0=v[0]),
            Joint("fb", "free", "world", "b", q0=(2.0, 0.5, 1.5, *q_b), v0=v[1]),
        ),
        gravity=0.0,
    )


SPIN = ((0.3, -0.2, 0.5, 0.4, 0.1, -0.6), (-0.1, 0.4, 0.2, -0.3, 0.5, 0.2))


def accelerations(system: System) -> np.ndarray:
    """(n_v,) dv/dt at the start."""
    s = started(system)
    nq, nv = s.program.nq, s.program.nv
    return s.X[s.native.at["f"]][nq : nq + nv].copy()


def test_a_spring_between_two_bodies_acts_like_a_tendon_in_mujoco():
    A, B = (0.4, -0.3, 0.2), (-0.5, 0.1, 0.6)
    system = pair((0.3, -0.2, 0.7), (-0.4, 0.9, 0.1), v=SPIN)
    ours = accelerations(replace(system, forces=(Spring("s", Point("a", A), Point("b", B), 1.2, 340.0, 25.0),)))

    def numbers(x):
        return " ".join(repr(float(e)) for e in x)

    def body(b, j, site):
        I = b.inertia
        full = numbers((I[0][0], I[1][1], I[2][2], I[0][1], I[0][2], I[1][2]))
        return (
            f'<body name="{b.name}"><freejoint/><inertial pos="{numbers(b.com)}" mass="{b.mass}" '
            f'fullinertia="{full}"/><site name="{b.name}" pos="{numbers(site)}"/></body>'
        )

    bodies = "".join(body(b, j, site) for b, j, site in zip(system.bodies, system.joints, (A, B), strict=True))
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 0"/><worldbody>{bodies}</worldbody><tendon>'
        '<spatial stiffness="340" damping="25" springlength="1.2"><site site="a"/><site site="b"/></spatial>'
        "</tendon></mujoco>"
    )
    data = mujoco.MjData(model)
    for i, j in enumerate(system.joints):
        x, y, z, w = j.q0[3:]
        data.qpos[7 * i : 7 * i + 7] = [*j.q0[:3], w, x, y, z]
        R = Rotation.from_quat(j.q0[3:]).as_matrix()
        data.qvel[6 * i : 6 * i + 6] = [*(R @ j.v0[:3]), *j.v0[3:]]
    mujoco.mj_forward(model, data)
    theirs = data.qacc.copy()
    for i, j in enumerate(system.joints):  # theirs: of the origin in world axes; ours: rates of velocities in body axes
        R = Rotation.from_quat(j.q0[3:]).as_matrix()
        theirs[6 * i : 6 * i + 3] = R.T @ theirs[6 * i : 6 * i + 3] - np.cross(j.v0[3:], j.v0[:3])
    assert ours == pytest.approx(theirs, abs=SAME * np.abs(theirs).max())


def test_a_spring_pulls_and_pushes_with_its_natural_period():
    k, m, rest = 50.0, 2.0, 3.0
    spring = Spring("s", Point("world", (0.0, 0.0, 5.0)), Point("load"), rest, k)
    s = started(replace(slider(mass=m, q0=1.9), gravity=0.0, forces=(spring,)), **FINE)
    s.interrupt(round(2 * pi * sqrt(m / k) * 1e9))
    assert s.row().q[0] == pytest.approx(1.9, abs=1e-9)
    assert column(s, "spring/tension")[1][:, 0].max() == pytest.approx(5.0, rel=1e-3)
    assert column(s, "spring/tension")[1][:, 0].min() == pytest.approx(-5.0, rel=1e-3)
    assert imbalance(s) < CLOSES


def test_a_load_on_a_spring_of_zero_rest_length_swings_through_the_other_end_of_the_spring():
    spring = Spring("s", Point("world"), Point("load"), 0.0, 8.0)
    s = started(replace(slider(mass=2.0, q0=0.5), gravity=0.0, forces=(spring,)), **FINE)
    s.interrupt(round(pi * 1e9 / 2))
    assert s.row().q[0] == pytest.approx(-0.5, abs=1e-9)


def energy_gradient(system: System, energy) -> np.ndarray:
    """(12,) generalised force -dV/d(displacements and turns in body axes) by central differences."""
    places = [(np.array(j.q0[:3]), Rotation.from_quat(j.q0[3:])) for j in system.joints]
    out = []
    for i in range(2):
        for c in range(6):
            value = []
            for h in (1e-6, -1e-6):
                moved = list(places)
                p, R = places[i]
                e = h * np.eye(3)[c % 3]
                moved[i] = (p + R.apply(e), R) if c < 3 else (p, R * Rotation.from_rotvec(e))
                value.append(energy(*moved))
            out.append(-(value[0] - value[1]) / 2e-6)
    return np.array(out)


def generalised_force(system: System, a: np.ndarray) -> np.ndarray:
    """(12,) mass matrix of the two free bodies, in body axes about their origins, times accelerations from rest."""
    out = []
    for i, b in enumerate(system.bodies):
        c = np.array([[0, -b.com[2], b.com[1]], [b.com[2], 0, -b.com[0]], [-b.com[1], b.com[0], 0]])
        I = np.array(b.inertia) - b.mass * c @ c
        M = np.block([[b.mass * np.eye(3), -b.mass * c], [b.mass * c, I]])
        out.append(M @ a[6 * i : 6 * i + 6])
    return np.concatenate(out)


def stiffness(seed: int) -> tuple:
    A = np.random.default_rng(seed).normal(size=(6, 6))
    return tuple(map(tuple, (A @ A.T * 30.0).tolist()))


K, D = stiffness(1), tuple(tuple(0.05 * x for x in row) for row in stiffness(2))
R_A = tuple(map(tuple, Rotation.from_rotvec((0.5, 0.1, -0.3)).as_matrix().tolist()))
R_B = tuple(map(tuple, Rotation.from_rotvec((-0.2, 0.6, 0.4)).as_matrix().tolist()))
P_A, P_B = Point("a", (0.4, -0.3, 0.2)), Point("b", (-0.5, 0.1, 0.6))


@pytest.mark.parametrize("turn", [(-0.4, 0.9, 0.1), (0.0, 0.0, 0.0), (1.5, -1.2, 1.0)])
def test_the_force_of_a_bushing_is_the_gradient_of_its_energy(turn):
    system = pair((0.3, -0.2, 0.7), turn)
    bushing = Bushing("m", P_A, P_B, K, D, R_A, R_B)
    ours = generalised_force(system, accelerations(replace(system, forces=(bushing,))))

    def energy(a, b):
        (p_a, Ra), (p_b, Rb) = a, b
        frame_a, frame_b = Ra * Rotation.from_matrix(R_A), Rb * Rotation.from_matrix(R_B)
        s = frame_a.inv().apply(p_b + Rb.apply(P_B.p) - p_a - Ra.apply(P_A.p))
        x = np.concatenate([s, (frame_a.inv() * frame_b).as_rotvec()])
        return 0.5 * x @ np.array(K) @ x

    theirs = energy_gradient(system, energy)
    assert ours == pytest.approx(theirs, abs=GRADIENT * np.abs(theirs).max())


def test_a_torsion_spring_acts_about_its_axis_only():
    """The gradient of k/2 twist^2, twist by SciPy's swing-twist: 2 atan2(quaternion along the axis, w)."""
    axis = (0.6, 0.0, 0.8)
    system = pair((0.3, -0.2, 0.7), (-0.4, 0.9, 0.1))
    ours = generalised_force(
        system, accelerations(replace(system, forces=(Torsion("t", "a", "b", axis, 70.0, rest=0.4),)))
    )

    def energy(a, b):
        q = (a[1].inv() * b[1]).as_quat(canonical=True)
        return 35.0 * (2 * np.arctan2(q[:3] @ axis, q[3]) - 0.4) ** 2

    theirs = energy_gradient(system, energy)
    assert ours == pytest.approx(theirs, abs=GRADIENT * np.abs(theirs).max())


def test_a_torsional_pendulum_keeps_its_period_at_amplitudes_up_to_half_a_turn():
    k, I = 12.0, 3.0
    disc = Body("disc", 1.0, inertia=((I, 0.0, 0.0), (0.0, I, 0.0), (0.0, 0.0, I)))
    joint = Joint("pin", "revolute", "world", "disc", axis=Z, q0=(ALMOST_HALF_A_TURN,))
    s = started(System((disc,), (joint,), forces=(Torsion("t", "world", "disc", Z, k),), gravity=0.0), **FINE)
    s.interrupt(round(2 * pi * sqrt(I / k) * 1e9))
    assert s.row().q[0] == pytest.approx(ALMOST_HALF_A_TURN, abs=1e-8)
    assert imbalance(s) < CLOSES


@pytest.mark.parametrize(
    "force",
    [
        Spring("s", P_A, P_B, 1.0, 200.0, 3.0),
        Torsion("s", "a", "b", X, 30.0, 0.5),
        Bushing("s", P_A, P_B, K, D, R_A, R_B),
    ],
)
def test_springs_on_tumbling_bodies_conserve_the_energy_balance(force):
    s = started(replace(pair((0.3, -0.2, 0.7), (-0.4, 0.9, 0.1), v=SPIN), forces=(force,)), **FINE)
    s.run(5 * SECOND)
    assert imbalance(s) < CLOSES
    assert column(s, "account")[1][-1, 0] > 1.0, "dampers are warm"


def test_equal_bushings_share_one_compiled_function():
    other = Bushing("n", Point("a"), Point("world"), D, K)
    program = Simulation(replace(pair(X, Z), forces=(Bushing("m", P_A, P_B, K, D, R_A, R_B), other))).program
    assert program.laws[0].function is program.laws[1].function


def unsymmetric(A):
    return ((A[0][0], A[0][1] + 1.0, *A[0][2:]), *A[1:])


@pytest.mark.parametrize(
    ("force", "told"),
    [
        (Spring("s", Point("world"), Point("world"), 1.0, 1.0), "spring 's': b is the same point as a"),
        (Spring("s", Point("world"), Point("load"), 1.0, -1.0), "spring 's': k is -1; it cannot be negative"),
        (Torsion("s", "load", "load", Z, 1.0), "torsion 's': b is the same body as a, 'load'"),
        (Torsion("s", "world", "load", (0.0, 0.0, 2.0), 1.0), "axis has length 2; it must be a unit vector"),
        (Bushing("s", Point("world"), Point("load"), unsymmetric(K), D), "K must be a symmetric matrix"),
        (Bushing("s", Point("world"), Point("load"), K, tuple(tuple(-x for x in r) for r in D)), "cannot be negative"),
        (Bushing("s", Point("world"), Point("load"), K, D, ((2.0, 0.0, 0.0), Z, X)), "R_a is not a rotation"),
    ],
)
def test_invalid_springs_in_a_scene_are_refused(force, told):
    with pytest.raises(KernelError) as e:
        Simulation(replace(slider(), forces=(force,)))
    assert told in str(e.value)


def test_a_frame_on_a_bushing_rests_at_its_static_deflection():
    """Weight over stiffness, at rest."""
    k = 5.0e4
    stiff = tuple(tuple(k if i == j else 0.0 for j in range(6)) for i in range(6))
    joint = Joint("free", "free", "world", "box", q0=(0.0, 0.0, -100.0 * 9.80665 / k, 0.0, 0.0, 0.0, 1.0))
    box = System((Body("box", 100.0, inertia=cube(100.0)),), (joint,))
    s = started(replace(box, forces=(Bushing("m", Point("world"), Point("box"), stiff, stiff),)))
    s.interrupt(SECOND)
    assert s.row().q[:3] == pytest.approx(joint.q0[:3], abs=1e-12)
