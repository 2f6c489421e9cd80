"""One rope over edges of several bodies: edges that stay parallel work, others are refused."""

from math import hypot, pi

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import (
    Body,
    InputSignal,
    Joint,
    JointSpring,
    Line,
    Point,
    Reeving,
    Rope,
    Sheave,
    System,
)
from heavylift.kernel.forces.reeving import ReevingLaw
from scipy.spatial import ConvexHull
from small_scenes import SECOND, G, X, Y, Z, column, cube, hand_over, imbalance, started

EA, R = 1e6, 0.3
FINE = {"tolerance": 1e-10, "sample_ns": SECOND // 50}
CLOSES = 1e-8  # of the energy turned over


def edge(body: str, at, name: str, friction: float = 0.0, axis=Y) -> Sheave:
    return Sheave(Point(body, at), axis, R, friction, edge=name, span=(-9.0, 9.0))


def shortest(a, b, first, second) -> float:
    """The shortest way from a to b above two cylinders about y: across them along SciPy's convex hull of both ends and
    of many points of the circles; unrolled it is straight."""
    angles = np.linspace(0.0, 2.0 * pi, 20_001)
    rings = [np.stack([c[0] + R * np.cos(angles), c[2] + R * np.sin(angles)], axis=1) for c in (first, second)]
    points = np.concatenate([[[a[0], a[2]], [b[0], b[2]]], *rings])
    around = list(ConvexHull(points).vertices)  # counter-clockwise
    upper = np.roll(around, -around.index(1))
    chain = points[upper[: list(upper).index(0) + 1]]  # from b over the top to a
    return float(hypot(np.linalg.norm(np.diff(chain, axis=0), axis=1).sum(), b[1] - a[1]))


def gantries(friction: float) -> System:
    """Two gantries beside one another, one on rails along the edges, the other on springs across them and on a hinge
    along them; their rope carries a load on one side and is held on the other."""
    joints = (
        Joint("along", "prismatic", "world", "west", axis=Y, v0=(0.8,)),
        Joint("across", "prismatic", "world", "cart", axis=X),
        Joint("rocks", "revolute", "cart", "east", axis=Y, p_CJ=(0.0, 0.0, -2.0)),
        Joint("hangs", "free", "world", "load", q0=(7.0, 1.0, -4.0, 0.0, 0.0, 0.0, 1.0), v0=(0.2, 0.4, *[0.0] * 4)),
    )
    springs = (JointSpring("s", "across", 4e4), JointSpring("u", "rocks", 2e5), JointSpring("t", "along", 3e3))
    over = edge("west", (-2.0, 0.0, 1.0), "one", friction), edge("east", (2.0, 0.0, -0.5), "two", friction)
    rope = Reeving("r", Point("world", (-6.0, -1.0, -1.0)), over, Point("load"), EA, InputSignal(16.4), 2e3)
    bodies = [Body(n, m, inertia=cube(m, 1.0)) for n, m in (("west", 300.0), ("east", 150.0), ("load", 90.0))]
    return System((Body("cart", 200.0), *bodies), joints, springs=springs, forces=(rope,), gravity=G)


@pytest.mark.parametrize("seed", range(6))
def test_a_rope_over_edges_of_two_bodies_takes_the_shortest_path(seed):
    random = np.random.default_rng(seed)
    a = (-random.uniform(4.0, 7.0), random.uniform(-3.0, 3.0), random.uniform(-5.0, -2.0))
    b = (random.uniform(4.0, 7.0), random.uniform(-3.0, 3.0), random.uniform(-5.0, -2.0))
    first, second = (-2.0, 0.0, random.uniform(-0.5, 0.5)), (2.0, 0.0, random.uniform(-0.5, 0.5))
    moved = {"world": (0.0, 0.0, 0.0), "pier": tuple(random.normal(size=3))}
    own = tuple(np.subtract(second, moved["pier"]).tolist())
    over = edge("world", first, "one"), edge("pier", own, "two")
    rope = Reeving("r", Point("world", a), over, Point("world", b), EA, InputSignal(9.0))
    length = ReevingLaw().start_length(rope, lambda body: (np.eye(3), np.array(moved[body])))
    assert length == pytest.approx(shortest(a, b, first, second), rel=1e-8)


@pytest.mark.parametrize("friction", [0.0, 0.15])
def test_bodies_that_slide_and_turn_along_their_edges_conserve_the_energy_balance(friction):
    s = started(gantries(friction), **FINE)
    hand_over(s, 3 * SECOND)
    s.settle()
    assert imbalance(s) < CLOSES
    assert column(s, "edge/force")[1].min(axis=0).max() >= 0.0
    assert (column(s, "edge/force")[1].max(axis=0) > 500.0).all(), "both bear the rope"
    _, q = column(s, "joint/position")
    assert (np.ptp(q[:, :3], axis=0) > 0.01).all(), "all three joints move"


def loose(kind: str, **more) -> System:
    """A rope over an edge of the ground and one of a body on a joint of a kind."""
    joint = Joint("j", kind, "world", "pier", (2.0, 0.0, 0.0), **more)
    over = edge("world", (-2.0, 0.0, 0.0), "one"), edge("pier", (0.0, 0.0, 0.0), "two")
    rope = Reeving(
        "r", Point("world", (-6.0, 0.0, -3.0)), over, Point("world", (6.0, 0.0, -3.0)), EA, InputSignal(14.0)
    )
    holds = Rope("h", (Line(Point("world", (2.0, 0.0, 5.0)), Point("pier")),), EA, 5.0)
    return System((Body("pier", 9.0, inertia=cube(9.0, 1.0)),), (joint,), ropes=(holds,), forces=(rope,), gravity=G)


@pytest.mark.parametrize(
    ("kind", "more"),
    [
        ("free", {}),
        ("spherical", {}),
        ("revolute", {"axis": Z}),
        ("cylindrical", {"axis": X}),
        ("universal", {"axis": Y, "second": X}),
    ],
)
def test_edges_on_bodies_that_can_rotate_out_of_parallel_are_refused(kind, more):
    message = (
        "reeving 'r': its edges are on several bodies, and the joint 'j' can turn the one on 'pier' out of parallel"
    )
    with pytest.raises(KernelError, match=message):
        started(loose(kind, **more))


@pytest.mark.parametrize(("kind", "more"), [("prismatic", {"axis": X}), ("revolute", {"axis": Y})])
def test_edges_on_bodies_that_stay_parallel_are_accepted(kind, more):
    started(loose(kind, **more))
