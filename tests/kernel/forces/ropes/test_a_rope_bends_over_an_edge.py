"""A rope meets an edge of a body, bends over it, slides along it and leaves it again (Euler and Eytelwein)."""

from math import acos, atan2, cos, exp, hypot, pi, sqrt

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, Drive, InputSignal, Joint, Point, Reeving, Sheave, System
from heavylift.kernel.forces.reeving import ReevingLaw
from scipy.integrate import solve_ivp
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from small_scenes import SECOND, G, X, Y, Z, column, cube, hand_over, imbalance, started, times

EA, R, MU = 1e6, 0.3, 0.15
FINE = {"tolerance": 1e-10, "sample_ns": SECOND // 50}
CLOSES = 1e-8  # of the energy turned over


def edge(body: str = "world", at=(0.0, 0.0, 0.0), span=(-5.0, 5.0), friction=0.0, axis=Y, name="keel") -> Sheave:
    return Sheave(Point(body, at), axis, R, friction, edge=name, span=span)


def in_plane(a, b) -> tuple[list[float], float]:
    """Lengths of the tangents from a and b to the edge, and the arc's angle, across the edge."""
    far = [hypot(p[0], p[2]) for p in (a, b)]
    theta = atan2(-a[0], a[2]) + atan2(b[0], b[2]) - sum(acos(R / x) for x in far)
    return [sqrt(x * x - R * R) for x in far], theta


def shortest(a, b) -> float:
    """The shortest way from a to b above a cylinder about y, by SciPy: it may touch it wherever it likes."""
    (one, two), theta = in_plane(a, b)

    def along(y: np.ndarray) -> float:
        return hypot(one, y[0] - a[1]) + hypot(R * theta, y[1] - y[0]) + hypot(two, b[1] - y[1])

    return float(minimize(along, [a[1], b[1]], method="BFGS", options={"gtol": 1e-10}).fun)


@pytest.mark.parametrize("seed", range(8))
def test_a_rope_over_an_edge_takes_the_shortest_path_in_any_direction(seed):
    random = np.random.default_rng(seed)
    a = np.array([-random.uniform(1.0, 6.0), random.uniform(-3.0, 3.0), random.uniform(-4.0, 0.2)])
    b = np.array([random.uniform(1.0, 6.0), random.uniform(-3.0, 3.0), random.uniform(-4.0, 0.2)])
    turned, moved = Rotation.random(random_state=seed), random.normal(size=3)
    ends = [tuple((turned.apply(p) + moved).tolist()) for p in (a, b)]
    rope = Reeving("r", Point("world", ends[0]), (edge("block"),), Point("world", ends[1]), EA, InputSignal(9.0))

    def pose(body: str) -> tuple[np.ndarray, np.ndarray]:
        return (turned.as_matrix(), moved) if body == "block" else (np.eye(3), np.zeros(3))

    assert ReevingLaw().start_length(rope, pose) == pytest.approx(shortest(a, b), rel=1e-10)


def drawn(mu: float, lateral: float) -> tuple:
    """The end of a rope drawn down slowly by 0.5 m beside an edge, its other end `aside` along it; all that is
    reported."""
    a, b = (-4.0, 0.0, -1.0), (3.0, lateral, -2.0)
    lift = Joint("lift", "prismatic", "world", "end", a, axis=Z)
    rope = Reeving("r", Point("end"), (edge(friction=mu),), Point("world", b), EA, InputSignal(7.5))
    drive = Drive("z", "lift", "prescribed")
    s = started(System((Body("end", 50.0),), (lift,), forces=(rope,), drives=(drive,), gravity=G), **FINE)
    s.set_profile("z", 0, 0.25, 1e3, -0.5)
    s.settle()
    hand_over(s, 2 * SECOND)
    s.settle()
    _, q = column(s, "joint/position")
    message = [column(s, topic)[1][-1] for topic in ("reeving/tension", "reeving/wrap", "edge/force", "edge/place")]
    return s, np.array([a[0], 0.0, a[2] + q[-1, 0]]), np.array(b), *message


@pytest.mark.parametrize("aside", [0.0, 3.0])
def test_tensions_on_both_sides_of_an_edge_follow_the_capstan_formula(aside):
    """T1/T2 = e^(mu psi), psi by how much a helix turns the rope; the edge bears the vector sum where the unrolled
    rope is straight."""
    s, a, b, T, wrap, force, place = drawn(MU, aside)
    flat, theta = in_plane(a, b)
    F = sum(flat) + R * theta
    slope = aside / F
    turn = theta / sqrt(1.0 + slope * slope)
    assert wrap[0] == pytest.approx(turn, rel=1e-9)
    assert T[0] / T[1] == pytest.approx(exp(MU * turn), rel=1e-8), "it is drawn over the edge and slides"
    between = acos((cos(theta) + slope * slope) / (1.0 + slope * slope))
    assert force[0] == pytest.approx(sqrt(T @ T - 2.0 * T[0] * T[1] * cos(between)), rel=1e-9)
    middle = slope * (flat[0] + R * theta / 2.0)
    assert place[0] == pytest.approx(abs(middle), abs=1e-9)
    assert imbalance(s) < CLOSES


def test_a_frictionless_edge_leaves_equal_tension_on_both_sides_of_the_rope():
    *_, T, _, _, _ = drawn(0.0, 2.0)
    assert T[0] == pytest.approx(T[1], rel=1e-12)
    assert T[0] > 1e4


# ---- a pendulum whose rope meets an edge ------------------------------------------------------------------

MASS, HANG, OFF, L0 = 100.0, (0.0, 6.0), 1.0, 10.0  # its rope hangs from HANG; the edge is 1 m beside it, below


def span(x: float, z: float) -> tuple[float, bool]:
    """Length from HANG to (x, z), and whether it bends over the side of the edge at -x."""
    p, q = (HANG[0] - OFF, HANG[1]), (x - OFF, z)
    between = (atan2(q[1], q[0]) - atan2(p[1], p[0])) % (2.0 * pi)
    turned = between - acos(R / hypot(*p)) - acos(R / hypot(*q))
    if turned <= 0.0:
        return hypot(x - HANG[0], z - HANG[1]), False
    return sum(sqrt(hypot(*e) ** 2 - R * R) for e in (p, q)) + R * turned, True


def test_a_pendulum_rope_touches_and_leaves_an_edge_as_in_a_fine_integration():
    """A point mass under an elastic rope swings round the edge and back; SciPy integrates the energy's gradient."""
    x0, h = (-3.5, -3.0), 1e-6

    def rates(t: float, y: np.ndarray) -> list[float]:
        x, z, u, w = y
        pull = EA * max(0.0, span(x, z)[0] / L0 - 1.0) / MASS
        dx = (span(x + h, z)[0] - span(x - h, z)[0]) / (2.0 * h)
        dz = (span(x, z + h)[0] - span(x, z - h)[0]) / (2.0 * h)
        return [u, w, -pull * dx, -pull * dz - G]

    def touching(t: float, y: np.ndarray) -> float:
        """Of the straight line: its distance from the axis less R, on the side where it can meet."""
        p, q = np.array(HANG), y[:2]
        d = (q - p) / np.linalg.norm(q - p)
        o = np.array([OFF, 0.0]) - p
        return float(d[1] * o[0] - d[0] * o[1]) * -1.0 - R

    end = 4.0
    truth = solve_ivp(
        rates, (0.0, end), [*x0, 0.0, 0.0], rtol=1e-10, atol=1e-10, events=touching, dense_output=True, max_step=0.01
    )
    slides = (
        Joint("x", "prismatic", "world", "cart", axis=X, q0=(x0[0],)),
        Joint("z", "prismatic", "cart", "load", axis=Z, q0=(x0[1],)),
    )
    keel = edge(at=(OFF, 0.0, 0.0), axis=(0.0, -1.0, 0.0))
    rope = Reeving("r", Point("world", (HANG[0], 0.0, HANG[1])), (keel,), Point("load"), EA, InputSignal(L0))
    s = started(System((Body("cart", 0.0), Body("load", MASS)), slides, forces=(rope,), gravity=G), **FINE)
    hand_over(s, round(end * SECOND))
    s.settle()
    met = sorted(times(s, "r", "found") + times(s, "r", "left"))
    assert len(met) >= 2
    assert met == pytest.approx(truth.t_events[0], abs=2e-6)
    t, q = column(s, "joint/position")
    assert q == pytest.approx(truth.sol(t)[:2].T, abs=1e-5)
    force = column(s, "edge/force")[1][:, 0]
    off = np.array([not span(*p)[1] for p in q])
    assert (force[off] == 0.0).all()
    assert (force[~off] > 0.0).any()
    assert imbalance(s) < CLOSES


# ---- a block that turns in its slings ----------------------------------------------------------------------


def turning_block(seed: int) -> System:
    """A free block that spins, with slings from its lower side over its edges; friction, fleet angles and slack."""
    random = np.random.default_rng(seed)
    half, mass = 1.5, 800.0
    spin = tuple(random.normal(size=3) * 0.5)
    float_ = Joint("float", "free", "world", "block", q0=(0.0,) * 6 + (1.0,), v0=(0.3, 0.0, 0.0, *spin))
    ropes = []
    for i, (side, y) in enumerate(((-1.0, -2.0), (-1.0, 2.0), (1.0, -2.0), (1.0, 2.0))):
        axis, ends = (0.0, -side, 0.0), (-8.0, 0.0) if side > 0.0 else (0.0, 8.0)
        over = edge("block", (side * half, -4.0, -half), ends, float(random.choice([0.0, 0.2])), axis)
        lug, hook = (side * 0.3, y, -half - R), (side * 2.5, y + random.uniform(-1.0, 1.0), 7.0)
        ropes.append(Reeving(f"r{i}", Point("world", hook), (over,), Point("block", lug), 3e6, InputSignal(9.8), 2e3))
    return System((Body("block", mass, inertia=cube(mass, 3.0)),), (float_,), forces=tuple(ropes), gravity=G)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.large(beyond=1)
def test_a_block_turned_over_edges_of_its_slings_conserves_the_energy_balance(seed):
    s = started(turning_block(seed), **FINE | {"tolerance": 1e-9})
    hand_over(s, 4 * SECOND)
    s.settle()
    assert imbalance(s) < CLOSES
    assert column(s, "edge/force")[1].max() > 1e3


def test_a_rope_that_runs_off_the_end_of_its_edge_ends_the_run():
    slide = Joint("slide", "prismatic", "world", "end", (-4.0, 0.0, -1.0), axis=Y)
    rope = Reeving("r", Point("end"), (edge(span=(-1.0, 1.0)),), Point("world", (4.0, 0.0, -1.0)), EA, InputSignal(8.0))
    drives = (Drive("y", "slide", "prescribed"),)
    s = started(System((Body("end", 1.0),), (slide,), forces=(rope,), drives=drives, gravity=G), **FINE)
    s.set_profile("y", 0, 1.0, 1e3, 4.0)
    s.settle()
    flat, theta = in_plane((-4.0, 0.0, -1.0), (4.0, 0.0, -1.0))
    off = (2.0 * flat[0] + R * theta) / (flat[0] + R * theta)  # where it comes to the edge 1 m from the middle
    with pytest.raises(KernelError, match=rf"^reeving 'r' at {off:.3f} s: runs off the end of edge 'keel'"):
        hand_over(s, 4 * SECOND)
