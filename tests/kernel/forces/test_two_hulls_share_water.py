"""Two bodies whose added mass couples them, against equations by SciPy and NumPy and with joints, ropes and locks."""

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import modes
from heavylift.kernel.constraints import RigidAt
from heavylift.kernel.description import Body, Bushing, Joint, Line, Lock, Point, RigidRope, SharedWater, System
from heavylift.kernel.islands import islands_of
from heavylift.kernel.model import Program, evaluate
from heavylift.kernel.multibody import composites, joint_space_inertia
from heavylift.kernel.multibody.kinematics import kinematics
from scipy.integrate import solve_ivp
from small_scenes import SECOND, X, cube, hand_over, started

OWN = np.diag([3.0, 8.0, 12.0, 5.0, 7.0, 2.0]) + 0.5
CROSS = np.random.default_rng(7).uniform(-1.2, 1.2, (6, 6))  # rows of b, columns of a
CENTRE, INERTIA = (0.1, 0.0, -0.2), ((3.0, 0.1, 0.0), (0.1, 4.0, 0.0), (0.0, 0.0, 5.0))
SPEEDS = (0.5, -0.2, 0.1, 0.3, 0.7, -0.4), (-0.1, 0.4, 0.2, -0.5, 0.2, 0.6)


def _rows(A: np.ndarray) -> tuple:
    return tuple(map(tuple, np.asarray(A).tolist()))


def hulls(cross: np.ndarray | None, mass: float = 4.0) -> tuple[Body, Body]:
    a = Body("a", mass, CENTRE, INERTIA, added=_rows(OWN))
    b = replace(a, name="b", mass=1.5 * mass)
    return a, replace(b, shared=None if cross is None else SharedWater("a", _rows(cross)))


def free(name: str, x: float, v0: tuple[float, ...] = (0.0,) * 6) -> Joint:
    return Joint(f"{name}.free", "free", "world", name, q0=(x, 0.3 * x, 0.0, 0.0, 0.0, 0.0, 1.0), v0=v0)


def pair(cross: np.ndarray | None) -> System:
    joints = tuple(free(n, x, v) for n, x, v in zip("ab", (-3.0, 5.0), SPEEDS, strict=True))
    return System(hulls(cross), joints, gravity=0.0)


def rigid(body: Body) -> np.ndarray:
    """(6, 6) rigid-body inertia about the origin, linear before angular."""
    c = np.array([[0, -body.com[2], body.com[1]], [body.com[2], 0, -body.com[0]], [-body.com[1], body.com[0], 0]])
    m = body.mass
    return np.block([[m * np.eye(3), -m * c], [m * c, np.array(body.inertia) - m * c @ c]])


def whole(bodies: tuple[Body, Body]) -> np.ndarray:
    """(12, 12) inertia of both."""
    M = np.zeros((12, 12))
    M[:6, :6], M[6:, 6:] = (rigid(b) + OWN for b in bodies)
    M[6:, :6], M[:6, 6:] = CROSS, CROSS.T
    return M


def test_two_bodies_coupled_by_added_mass_exchange_momentum_as_scipy_computes():
    """Twists after 3 s of two tumbling bodies, each with dh/dt + v x* h = 0, where h = M (v_a, v_b)."""
    s = started(pair(CROSS), tolerance=1e-11)
    energy = float(s.row().kinetic)
    hand_over(s, 3 * SECOND)
    M = whole(hulls(CROSS))

    def turned(v, h):
        return np.concatenate([np.cross(v[3:], h[:3]), np.cross(v[3:], h[3:]) + np.cross(v[:3], h[:3])])

    def rate(t, v):
        h = M @ v
        return np.linalg.solve(M, -np.concatenate([turned(v[:6], h[:6]), turned(v[6:], h[6:])]))

    v0 = np.concatenate(SPEEDS)
    there = solve_ivp(rate, (0.0, 3.0), v0, rtol=1e-12, atol=1e-13).y[:, -1]
    assert np.asarray(s.row().v) == pytest.approx(there, abs=1e-8)
    assert energy == pytest.approx(0.5 * v0 @ M @ v0, rel=1e-12)
    assert float(s.row().kinetic) == pytest.approx(energy, rel=1e-9)


def test_zero_coupling_of_added_mass_leaves_the_motion_of_two_hulls_unchanged():
    apart, together = (started(pair(x), tolerance=1e-9) for x in (None, np.zeros((6, 6))))
    for s in (apart, together):
        hand_over(s, 3 * SECOND)
    assert np.asarray(together.row().v) == pytest.approx(np.asarray(apart.row().v), abs=1e-12)


TIE, FALL = Point("arm a", (0.0, 0.5, 0.5)), Point("arm b", (0.0, 0.5, 0.5))


def inertia(tree, q):
    """(n_v, n_v) the joint-space inertia matrix."""
    K = kinematics(tree, q, np.zeros(tree.v.stop - tree.v.start), 0.0, [0.0] * len(tree.prescribed_dofs))
    I, _ = composites(tree, K, [np.zeros(6)] * len(tree.bodies))
    H = np.zeros((tree.v.stop - tree.v.start,) * 2)
    for (k, l), x in joint_space_inertia(tree, K, I).items():
        H[k, l] = H[l, k] = x
    return H


def place(program: Program, y: np.ndarray, at: Point) -> tuple[np.ndarray, np.ndarray]:
    """Place and velocity of a point of a body."""
    x = evaluate(program, 0.0, y, program.parameters.initial)
    end = np.array(x.ends[program.graph.number(at.body)], float)
    r = end[12:15] + end[:9].reshape(3, 3) @ at.p
    return end[9:12] + r, end[18:21] + np.cross(end[15:18], r)


def loaded(cross: np.ndarray | None, ropes: tuple[RigidRope, ...], locked: bool) -> System:
    """Both bodies carry a hinged arm each, perhaps one of them locked."""
    (a, b), of = hulls(cross), "ab"
    arms = [Body(f"arm {n}", 2.0, (0.0, 0.4, 0.3), cube(2.0)) for n in of]
    hinges = [Joint(f"hinge {n}", "revolute", n, f"arm {n}", (0.2, 0.1, 1.0), axis=X, q0=(0.2,)) for n in of]
    locks = (Lock("lock", "hinge b", engaged=True),) if locked else ()
    springs = tuple(Bushing(f"{n} spring", Point(f"{n}a"), Point(f"{n}b"), _rows(np.eye(6)), _rows(np.eye(6)))
                    for n in ("", "arm "))  # fmt: skip
    return System((a, b, *arms), (free("a", -3.0), free("b", 5.0), *hinges), rigid_ropes=ropes, locks=locks,
                  forces=springs)  # fmt: skip


@pytest.mark.parametrize("locked", [False, True])
def test_coupled_hulls_with_arms_on_rigid_ropes_accelerate_as_numpy_solves_their_equations(locked: bool) -> None:
    """dv of [H J^T; J 0] at rest by NumPy: H is that of separate bodies with the cross terms added at the free joints;
    b hangs on a rigid rope, and another one connects the arms."""
    loose = Program(loaded(None, (), locked))
    y, nq, n = loose.initial_state(), loose.nq, loose.nv
    p, q = (place(loose, y, at)[0] for at in (TIE, FALL))
    top = (5.0, 1.5, 9.0)
    ropes = (RigidRope("fall", (Line(Point("world", top), Point("b")),), 9.0),
             RigidRope("tie", (Line(TIE, FALL),), float(np.linalg.norm(q - p))))  # fmt: skip
    program = Program(loaded(CROSS, ropes, locked))
    P = program.parameters.initial.copy()
    for rope in ropes:
        P[np.arange(len(P))[program.parameters.at["rigid", rope.name]][RigidAt.TAUT]] = 1.0
    x = evaluate(program, 0.0, program.initial_state(), P)

    H, at = np.zeros((n, n)), {k.joint.name: k.v for k in loose.graph.links}
    for tree in loose.trees:
        H[tree.v, tree.v] = inertia(tree, y[tree.q])
    force = H @ np.array(evaluate(loose, 0.0, y, loose.parameters.initial).dv, float)
    H[at["b.free"], at["a.free"]], H[at["a.free"], at["b.free"]] = CROSS, CROSS.T
    J = np.zeros((2, n))
    for k in range(n):
        moving = y.copy()
        moving[nq + k] = 1.0
        (_, v), (_, w) = (place(loose, moving, e) for e in (TIE, FALL))
        J[:, k] = place(loose, moving, Point("b"))[1][2], (q - p) @ (w - v)
    moves = [k for k in range(n) if not (locked and k == at["hinge b"].start)]
    m = len(moves)
    K = np.block([[H[np.ix_(moves, moves)], J[:, moves].T], [J[:, moves], np.zeros((2, 2))]])
    want = np.linalg.solve(K, np.concatenate([force[moves], np.zeros(2)]))[:m]
    order = [k for name in (k.joint.name for k in program.graph.links) for k in range(n)[at[name]]]
    found = np.empty(n)
    found[order] = np.array(x.dv, float)
    assert found[moves] == pytest.approx(want, abs=1e-9)


def carried() -> System:
    """The pair with a third body below b."""
    system = pair(CROSS)
    joints = (system.joints[0], Joint("b.fixed", "revolute", "a", "b"))
    return replace(system, joints=joints)


@pytest.mark.parametrize(
    ("system", "formulation", "words"),
    [
        (pair(CROSS), "articulated", "'b' shares water, but formulation 'articulated' keeps bodies apart"),
        (pair(20.0 * CROSS), "recursive", "its added mass with 'a' beside it would drive some motion"),
        (carried(), "recursive", "body 'b': only two bodies that no other body carries can share water"),
    ],
)
def test_impossible_pairs_of_hulls_in_shared_water_are_refused(system: System, formulation: str, words: str) -> None:
    with pytest.raises(KernelError, match=words):
        Program(system, formulation)


def test_bodies_coupled_by_added_mass_form_one_island() -> None:
    assert [len(islands_of(pair(x))) for x in (None, CROSS)] == [2, 1]


def test_normal_modes_of_two_coupled_hulls_agree_with_their_dense_equations() -> None:
    """Frequencies of both on springs to the ground, by NumPy."""
    k = np.diag([50.0, 60.0, 70.0, 80.0, 90.0, 100.0])
    at = {"a": (-3.0, -0.9, 0.0), "b": (5.0, 1.5, 0.0)}
    springs = tuple(
        Bushing(f"{n}.spring", Point("world", p), Point(n), _rows(k), _rows(0.0 * k)) for n, p in at.items()
    )
    system = replace(pair(CROSS), joints=(free("a", -3.0), free("b", 5.0)), forces=springs)
    oscillations = modes(started(system)).oscillations
    found = [m.frequency for m in oscillations]
    M = whole(hulls(CROSS))
    for mode in oscillations:
        energy = (mode.shape.conj() * (M @ mode.shape)).real  # of which each body has its own momentum's
        shares = energy.reshape(2, 6).sum(axis=1) / energy.sum()
        assert [dict(mode.bodies)[name] for name in "ab"] == pytest.approx(shares, abs=1e-5)
    want = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, np.kron(np.eye(2), k))).real) / (2.0 * np.pi)
    assert found == pytest.approx(sorted(want), rel=1e-5)
