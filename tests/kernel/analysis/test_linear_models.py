"""Linear models against closed forms, finite differences of the compiled equations, and responses to small inputs."""

from dataclasses import replace
from math import sqrt

import control
import numpy as np
import pytest
from every_law import yard
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import Poses, equilibrium, linear_model, modes
from heavylift.kernel.description import (
    WORLD,
    Body,
    Characteristic,
    Drive,
    InputSignal,
    Joint,
    Line,
    Point,
    RigidRope,
    System,
)
from heavylift.kernel.multibody import build_graph
from heavylift.kernel.simulation.native import channels, published
from linkages import windows
from random_trees import random_state, random_system
from scipy.linalg import expm
from small_scenes import G, X, Y, started
from test_loops_rest_and_swing import LINK, L as LENGTH, M, swing

EXACT = 1e-12


def rod(name: str, length: float, mass: float) -> Body:
    i = mass * length**2 / 12.0
    return Body(name, mass, (0.0, 0.0, -length / 2.0), ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, 0.0)))


def crane(kind: str = "prescribed", m: float = 3.0, load: float = 2.0, l: float = 5.0) -> System:
    """A trolley whose load hangs as a point on a massless link."""
    bodies = Body("trolley", m), Body("load", load, (0.0, 0.0, -l))
    joints = Joint("rail", "prismatic", WORLD, "trolley", axis=X), Joint("hook", "revolute", "trolley", "load", axis=Y)
    if kind == "force":
        push = Characteristic("push", "rail", "position", (-1.0, 1.0), (1.0, 1.0), InputSignal(0.0))
        return System(bodies, joints, forces=(push,), gravity=G)
    return System(bodies, joints, drives=(Drive("travel", "rail", kind, 4.0, 7.0),), gravity=G)


def test_a_trolley_with_a_pendulum_load_has_the_linear_model_found_in_textbooks():
    m, load, l = 3.0, 2.0, 5.0
    found = linear_model(started(crane("force", m, load, l)), ["push"], ["joint/position/*", "pose/load/x"])
    system = control.ss(*found)
    w = sqrt((m + load) * G / (m * l))
    assert sorted(abs(system.poles())) == pytest.approx([0.0, 0.0, w, w], abs=1e-7)
    assert sorted(abs(control.zeros(system[0, 0]))) == pytest.approx([sqrt(G / l)] * 2, rel=1e-9)
    at = 0.3j * w
    assert complex(system(at)[0, 0]) == pytest.approx((at**2 + G / l) / (m * at**2 * (at**2 + w**2)), rel=1e-9)
    assert [(x.name, x.unit) for x in found.states] == [
        ("joint/position/rail.travel", "m"), ("joint/position/hook.angle", "rad"),
        ("joint/velocity/rail.speed", "m/s"), ("joint/velocity/hook.rate", "rad/s"),
    ]  # fmt: skip


def test_the_linear_model_of_a_prescribed_trolley_has_its_acceleration_as_input():
    l, outputs = 5.0, ["joint/position/rail.*", "pose/trolley/x", "joint/position/hook.angle"]
    found = linear_model(started(crane("prescribed", l=l)), ["travel"], outputs)
    assert [(x.name, x.unit) for x in found.states[2:]] == [("reference/travel", "m"), ("reference/travel rate", "m/s")]
    assert [(x.name, x.unit) for x in found.inputs] == [("travel", "m/s2")]
    system = control.ss(*found)
    s = 0.7j
    assert complex(system(s)[1, 0]) == pytest.approx(1.0 / s**2, rel=1e-9)
    assert abs(complex(system(s)[2, 0])) == pytest.approx(abs(1.0 / (l * s**2 + G)), rel=1e-9)


@pytest.mark.parametrize("kind", ["servo", "speed"])
def test_the_linear_model_of_a_servo_or_speed_drive_has_the_speed_of_the_drive_as_input(kind):
    m, load, l, kp, kv = 3.0, 2.0, 5.0, 4.0, 7.0
    found = linear_model(started(crane(kind, m, load, l)), ["travel"], ["joint/position/rail.travel"])
    assert [(x.name, x.unit) for x in found.inputs] == [("travel", "m/s")]
    assert len(found.states) == 5 - (kind == "speed")
    s = 0.4j
    stiff = kp if kind == "servo" else 0.0
    plant = (s**2 + G / l) / (m * s**2 * (s**2 + (m + load) * G / (m * l)))
    law = kv + stiff / s
    assert complex(control.ss(*found)(s)) == pytest.approx(plant * law / (1.0 + plant * law * s), rel=1e-9)


def test_the_linear_model_of_a_double_pendulum_has_its_exact_frequencies():
    bodies = Body("upper", 1.0, (0.0, 0.0, -1.0)), Body("lower", 1.0, (0.0, 0.0, -1.0))
    joints = (
        Joint("shoulder", "revolute", WORLD, "upper", axis=Y),
        Joint("elbow", "revolute", "upper", "lower", (0.0, 0.0, -1.0), axis=Y),
    )
    found = linear_model(started(System(bodies, joints, gravity=G)), [], ["joint/position/*"])
    w = np.sort(np.abs(np.linalg.eigvals(found.A)))[::2]
    assert w == pytest.approx(np.sqrt(G * (2.0 + np.array([-1.0, 1.0]) * sqrt(2.0))), rel=1e-12)


@pytest.mark.parametrize("seed", range(12))
def test_linear_models_of_moving_systems_agree_with_finite_differences_of_the_equations(seed):
    """About any state: also coordinates that are quaternions, and bodies that turn while they are disturbed."""
    system = random_system(seed, 5, 2.0)
    q, v = random_state(build_graph(system), seed)
    graph = build_graph(system)
    placed = {k.joint.name: replace(k.joint, q0=tuple(q[k.q]), v0=tuple(v[k.v])) for k in graph.links}
    simulation = started(replace(system, joints=tuple(placed[j.name] for j in system.joints)))
    found = linear_model(simulation, [], ["joint/velocity/*", "pose/*"])
    poses = Poses(simulation)
    n, h = simulation.program.nv, 1e-5

    def moved(q, step):
        return poses.unit(poses.moved(q, step))

    def rates(x):
        """Accelerations, and samples, of the state off by x."""
        at = moved(q, x[:n])
        return poses.accelerations(at, v + x[n:])

    q = simulation.state[: len(q)].copy()
    J = np.array([(rates(h * e) - rates(-h * e)) / (2.0 * h) for e in np.eye(2 * n)]).T
    scale = 1.0 + np.abs(J).max()
    assert found.A[n:] == pytest.approx(J, abs=1e-6 * scale)
    assert found.C[:n] == pytest.approx(np.eye(2 * n)[n:], abs=EXACT)

    def apart(x, dt):
        """How far apart (n,) two motions are after dt that start a displacement x apart."""
        one, other = moved(q, dt * v), moved(moved(q, x[:n]), dt * (v + x[n:]))
        N = np.array([moved(one, h * e) - moved(one, -h * e) for e in np.eye(n)]).T / (2.0 * h)
        return np.linalg.pinv(N) @ (other - one)

    def drift(x):
        return (apart(h * x, h) - apart(h * x, -h) - apart(-h * x, h) + apart(-h * x, -h)) / (4.0 * h * h)

    drifts = np.array([drift(e) for e in np.eye(2 * n)]).T
    assert found.A[:n] == pytest.approx(drifts, abs=1e-4 * (1.0 + np.abs(v).max()))


@pytest.mark.parametrize("links", [2, 3])
def test_the_linear_model_of_a_closed_linkage_has_the_two_states_of_one_link(links):
    found = linear_model(_at_rest(swing(links)), [], ["joint/position/*", "pose/platform/x"])
    n = links * LINK
    want = sqrt((M + n / 2.0) * G / ((M + n / 3.0) * LENGTH))
    assert len(found.states) == 2
    assert np.abs(np.linalg.eigvals(found.A)) == pytest.approx([want] * 2, rel=1e-8)
    names = [x.name for x in found.outputs]
    tops, low = [i for i, x in enumerate(names) if "/top" in x], names.index("joint/position/low0.angle")
    assert found.C[tops, 0] == pytest.approx(found.C[tops[0], 0] * np.ones(links))
    assert found.C[low, 0] == pytest.approx(-found.C[tops[0], 0])


def hung_rigidly(l: float = 5.0) -> System:
    """A load on a rigid rope with a winch below a trolley that is moved as one wants."""
    ball = ((0.4, 0.0, 0.0), (0.0, 0.4, 0.0), (0.0, 0.0, 0.4))
    bodies = Body("trolley", 3.0), Body("load", 2.0, (0.0, 0.0, -0.5), ball)
    joints = (
        Joint("rail", "prismatic", WORLD, "trolley", axis=X),
        Joint("float", "free", WORLD, "load", q0=(0.0, 0.0, -l, 0.0, 0.0, 0.0, 1.0)),
    )
    rope = RigidRope("hoist", (Line(Point("trolley"), Point("load")),), l, winch=True)
    return System(bodies, joints, drives=(Drive("travel", "rail", "prescribed"),), rigid_ropes=(rope,), gravity=G)


def test_a_rigid_rope_removes_a_state_from_the_linear_model_and_its_winch_is_an_input():
    found = linear_model(_at_rest(hung_rigidly()), ["travel", "hoist"], ["pose/load/[xyz]"])
    assert len(found.states) == 2 * 5 + 4
    assert [x.unit for x in found.inputs] == ["m/s2", "m/s2"]
    s = 3.1j
    H = np.array(control.ss(*found)(s))
    assert H[2] == pytest.approx([0.0, -1.0 / s**2], abs=1e-9)
    assert H[:2, 1] == pytest.approx(0.0, abs=1e-9)
    m, l, c, I = 2.0, 5.0, 0.5, 0.4  # rope and load, angles a and b to the vertical: a double pendulum on the trolley
    K = np.array([[m * l * l, m * l * c], [m * l * c, I + m * c * c]]) * s**2 + np.diag([m * G * l, m * G * c])
    a, _ = np.linalg.solve(K, [-m * l, -m * c])  # by an acceleration of 1
    assert H[0, 0] == pytest.approx(1.0 / s**2 + l * a, rel=1e-8)


SCENES = {
    "every law": (yard, ["hoist", "travel", "traverse"], 1e-3),
    "rigid rope": (hung_rigidly, ["travel", "hoist"], 1e-3),
    "servo": (lambda: crane("servo"), ["travel"], 1e-3),
}


@pytest.mark.parametrize("scene", SCENES)
def test_small_motions_of_drives_move_a_scene_as_its_linear_model_predicts(scene):
    build, names, a = SCENES[scene]
    T, ns = 0.25, 250_000_000

    def sampled(name):
        """Outputs after T with the reference of `name` accelerated at a, and without."""
        simulation = _at_rest(build(), tolerance=1e-10)
        now = linear_model(simulation, names, outputs)
        if name:
            simulation.set_profile(name, simulation.epoch, 1.0, a, None)
        simulation.settle()
        simulation.interrupt(simulation.epoch + ns)
        simulation.settle()
        method = simulation.method
        values = published(method, np.array(method.row_layout.pack(simulation.row()))[None])[0]
        known = {f"{c.topic}/{n}": values[c.start + i] for c in channels(method) for i, n in enumerate(c.names)}
        return now, np.array([known[x.name] for x in now.outputs])

    outputs = ["joint/position/*", "pose/*/[xyz]"]
    model, still = sampled("")
    n, m = len(model.states), len(model.inputs)
    for i, name in enumerate(names):
        ramps = np.zeros((n + 2 * m, n + 2 * m))  # state, input, its rate
        ramps[:n, :n], ramps[:n, n : n + m], ramps[n : n + m, n + m :] = model.A, model.B, np.eye(m)
        start = np.zeros(n + 2 * m)
        start[(n if model.inputs[i].unit.endswith("s2") else n + m) + i] = a
        x = expm(ramps * T) @ start
        want = model.C @ x[:n] + model.D @ x[n : n + m]
        found = sampled(name)[1] - still
        assert np.abs(want).max() > 1e-6 or (scene, name) == ("every law", "hoist"), "whose rope is slack"
        assert found == pytest.approx(want, abs=2e-3 * np.abs(want).max() + 1e-12), name


def test_linearising_a_system_without_a_linear_model_is_refused_in_one_sentence():
    simulation = started(crane())
    with pytest.raises(KernelError, match=r"there is no input 'hoist'; known: travel$"):
        linear_model(simulation, ["hoist"], ["joint/position/*"])
    with pytest.raises(KernelError, match=r"there is no output 'rope/tension/\*'; write signal/name, such as"):
        linear_model(simulation, ["travel"], ["rope/tension/*"])
    with pytest.raises(
        KernelError, match=r"are moving; a scene with loops or rigid ropes can be linearised only at rest$"
    ):
        linear_model(started(windows(1)), [], ["joint/position/*"])


def test_natural_modes_are_the_eigenvalues_of_the_linear_model():
    simulation = _at_rest(replace(yard(), brakes=()))  # which would rest at the limit of its friction
    found = linear_model(simulation, [], ["joint/position/*"])
    s = np.linalg.eigvals(found.A)
    oscillations = sorted(abs(x) / (2.0 * np.pi) for x in s if x.imag > 1e-9 * abs(x) and abs(x) > 1e-2)
    want = sorted(m.frequency for m in modes(simulation).oscillations)
    assert oscillations == pytest.approx(want, rel=1e-5)


def _at_rest(system: System, **options):
    simulation = started(system, **options)
    equilibrium(simulation)
    return simulation
