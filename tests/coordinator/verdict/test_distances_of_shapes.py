"""Distances of boxes, capsules and balls: closed forms, answers of Coal, SciPy's least squares and convex hulls, bounds
from both sides; shapes that touch exactly, are parallel, or have no thickness."""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.verdict import Placed, bounds, bounds_between, exactly
from numpy.typing import NDArray
from scipy.optimize import lsq_linear, minimize_scalar
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]
KNOWN = json.loads((Path(__file__).parents[2] / "data" / "shape_distances.json").read_text())["rows"]
CLOSE = 1e-7  # [m]: searches of others end there
SEARCHED = 1e-6  # [m]: one by bisection of a curve that is flat at its least
ROUNDING = 1e-9
SLIVER = 1e-7  # [m]: faces of a hull between edges that are parallel but for 1e-8
BARELY = 1e-5  # [m]: so short a way between two points has a direction to few digits only
CASES = 200
CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


def box(centre: list[float] | Floats, half: list[float] | Floats, turn: Rotation | None = None) -> Placed:
    R = (turn or Rotation.identity()).as_matrix()
    return Placed(np.array([centre], float), R[None], np.array([half], float), 0.0)


def capsule(a: Floats, b: Floats, radius: float) -> Placed:
    length = float(np.linalg.norm(b - a))
    R = Rotation.align_vectors([b - a], [[0.0, 0.0, length]])[0].as_matrix()
    return Placed((a + b)[None] / 2, R[None], np.array([[0.0, 0.0, length / 2]]), radius)


def random_shapes(rng: np.random.Generator, turn: Rotation, spread: float) -> Placed:
    """Rounded boxes of all kinds: a half edge may be 0, and a radius."""
    m = len(turn)
    half = rng.uniform(0.1, 5.0, (m, 3)) * (rng.random((m, 3)) < 0.7)
    radius = rng.uniform(0.05, 2.0, m) * (rng.random(m) < 0.5)
    return Placed(rng.normal(0.0, spread, (m, 3)), turn.as_matrix(), half, radius)


def pairs_of_all_kinds() -> list[tuple[str, Placed, Placed]]:
    rng = np.random.default_rng(9)
    turn, cube = Rotation.random(CASES, random_state=rng), Rotation.create_group("O")
    quarter = turn * cube[rng.integers(0, 24, CASES)]
    slight = Rotation.from_rotvec(rng.normal(0.0, 1.0, (CASES, 3)) * 10.0 ** rng.uniform(-13.0, -3.0, (CASES, 1)))
    found = [
        (f"{name}, {spread:g} m away", random_shapes(rng, turn, spread), random_shapes(rng, other, spread))
        for name, other in (("turned", turn.inv()), ("parallel", quarter), ("nearly parallel", quarter * slight))
        for spread in (0.5, 4.0, 300.0)
    ]
    name, a, b = found[1]
    for gap in (-1e-6, 0.0, 1e-6):  # along the way that takes them apart, or together
        near = exactly(a, b)
        there = b.centre + (gap - near.distance)[:, None] * near.normal
        found.append((f"{name}, {gap:g} m apart", a, b._replace(centre=there)))
    for name, size in (("tiny", 1e-4), ("huge", 1e4)):
        alike = (Placed(x.centre * size, x.R, x.half * size, np.asarray(x.radius) * size) for x in (a, b))
        found.append((name, *alike))
    found += [("the same", a, a), ("inside", a, b._replace(centre=a.centre, half=b.half * 0.01))]
    across = a.centre + rng.uniform(-1.0, 1.0, (CASES, 1)) * a.R[:, :, 2] * a.half[:, 2:]
    lines = (x._replace(half=x.half * (0.0, 0.0, 1.0)) for x in (a, b._replace(centre=across)))
    return [*found, ("axes that cross", *lines)]


@pytest.mark.parametrize(("a", "b"), [pytest.param(*x, id=name) for name, *x in pairs_of_all_kinds()])
def test_distances_of_shapes_lie_between_a_separating_gap_and_the_distance_of_two_of_their_points(
    a: Placed, b: Placed
) -> None:
    """A gap along any direction is a bound from below, two points of the shapes are one from above."""
    near, size = exactly(a, b), 1.0 + max(float(np.abs(x).max()) for x in (a.half, b.half, a.centre, b.centre))
    assert np.linalg.norm(near.normal, axis=1) == pytest.approx(1.0)
    below = np.einsum("mi,mi->m", near.normal, b.centre - a.centre)
    for x, point, sign in ((a, near.a, 1.0), (b, near.b, -1.0)):
        below -= np.abs(np.einsum("mij,mi->mj", x.R, near.normal) * x.half).sum(axis=1) + x.radius
        core = np.einsum("mij,mi->mj", x.R, point - sign * np.reshape(x.radius, (-1, 1)) * near.normal - x.centre)
        off = np.linalg.norm(core - np.clip(core, -x.half, x.half), axis=1)
        assert off.max() < SLIVER + ROUNDING * size, "the points are on the shapes"
    apart = near.distance + a.radius + b.radius
    unsure = np.where((apart > 0.0) & (apart < BARELY), ROUNDING / BARELY * size, 0.0)  # of its direction
    assert (np.abs(below - near.distance) < ROUNDING * size + unsure).all()
    along = np.einsum("mi,mi->m", near.b - near.a, near.normal)
    assert along == pytest.approx(near.distance, abs=ROUNDING * size)
    assert (bounds(a, b) <= near.distance + ROUNDING * size).all()


def test_distances_of_shapes_agree_with_the_library_coal() -> None:
    a, b = (Placed(*(np.array([row[i + j] for row in KNOWN]) for j in range(4))) for i in (1, 5))
    a, b = (x._replace(R=Rotation.from_rotvec(x.R).as_matrix()) for x in (a, b))
    assert exactly(a, b).distance == pytest.approx(np.array([row[9] for row in KNOWN]), abs=CLOSE)


def test_distances_of_two_shapes_computed_for_one_pose_and_for_many_poses_are_bit_identical() -> None:
    rng = np.random.default_rng(2)
    a, b = (random_shapes(rng, Rotation.random(CASES, random_state=rng), 3.0) for _ in range(2))
    together = exactly(a, b)
    for i in range(CASES):
        one, two = (Placed(*(np.asarray(x)[[i]] for x in s)) for s in (a, b))
        assert all((x[0] == y[i]).all() for x, y in zip(exactly(one, two), together, strict=True))


def test_the_depth_of_overlapping_boxes_is_the_distance_to_the_nearest_face_of_their_minkowski_difference() -> None:
    rng, deep = np.random.default_rng(10), 0
    for _ in range(CASES):
        turn = Rotation.random(random_state=rng)
        a, b = box([0, 0, 0], rng.uniform(0.1, 5.0, 3)), box(rng.normal(0.0, 3.0, 3), rng.uniform(0.1, 5.0, 3), turn)
        corners = [x.centre + (CORNERS * x.half) @ x.R[0].T for x in (a, b)]
        hull = ConvexHull((corners[1][:, None] - corners[0]).reshape(-1, 3))
        depth = float(hull.equations[:, 3].max())
        found = exactly(a, b).distance[0]
        assert found == pytest.approx(depth, abs=CLOSE) if depth < 0.0 else found > 0.0
        deep += depth < 0.0
    assert 50 < deep < CASES, "of both kinds"


@pytest.mark.parametrize(
    ("a", "b", "distance"),
    [
        (box([0, 0, 0], [1, 2, 3]), box([4, 0, 0], [1, 1, 1]), 2.0),  # face to face
        (box([0, 0, 0], [1, 1, 1]), box([5, 6, 0], [1, 1, 1]), 5.0),  # edge to edge: 3, 4
        (box([0, 0, 0], [1, 1, 1]), box([4, 5, 8], [1, 1, 2]), np.hypot(np.hypot(2, 3), 5)),  # corner to corner
        (box([0, 0, 0], [1, 1, 1]), box([3, 0, 0], [1, 1, 1], Rotation.from_euler("z", 45, degrees=True)), 2 - 2**0.5),
        (box([0, 0, 0], [1, 1, 1]), box([1.5, 0, 0], [1, 1, 1]), -0.5),
        (box([0, 0, 0], [27, 14, 5]), capsule(np.array([0.0, -14.6, 0.0]), np.array([0.0, -14.6, 8.0]), 0.048), 0.552),
        (
            capsule(np.zeros(3), np.array([0.0, 0, 9]), 0.1),
            capsule(np.array([1.0, -2, 4]), np.array([1.0, 2, 4]), 0.2),
            0.7,
        ),
    ],
)  # fmt: skip
def test_distances_of_shapes_agree_with_closed_forms(a: Placed, b: Placed, distance: float) -> None:
    for one, two in ((a, b), (b, a)):
        found = exactly(one, two)
        assert found.distance[0] == pytest.approx(distance, abs=CLOSE)
        assert bounds(one, two)[0] <= distance + ROUNDING


def test_distances_of_random_boxes_agree_with_scipy() -> None:
    rng = np.random.default_rng(3)
    for _ in range(CASES):
        half, other, centre = rng.uniform(0.1, 5.0, 3), rng.uniform(0.1, 5.0, 3), rng.normal(0.0, 6.0, 3)
        turn = Rotation.random(random_state=rng)
        M, both = np.hstack([np.eye(3), -turn.as_matrix()]), np.concatenate([half, other])
        apart = float(np.linalg.norm(M @ lsq_linear(M, centre, (-both, both), method="bvls").x - centre))
        a, b = box([0, 0, 0], half), box(centre, other, turn)
        found = exactly(a, b)
        assert max(found.distance[0], 0.0) == pytest.approx(apart, abs=CLOSE)
        assert bounds(a, b)[0] <= found.distance[0] + ROUNDING
        if found.distance[0] > CLOSE:
            assert np.linalg.norm(found.b - found.a) == pytest.approx(found.distance[0], abs=CLOSE)


def test_distances_of_random_capsules_to_a_box_agree_with_a_search_along_them() -> None:
    rng = np.random.default_rng(4)
    for _ in range(CASES):
        half, a, b = rng.uniform(0.5, 9.0, 3), rng.normal(0.0, 12.0, 3), rng.normal(0.0, 12.0, 3)

        def off(s: float, half: Floats = half, a: Floats = a, b: Floats = b) -> float:
            return float(np.linalg.norm(np.maximum(np.abs(a + s * (b - a)) - half, 0.0)))

        apart = minimize_scalar(off, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-12}).fun
        if apart > 0.05:
            found = exactly(box([0, 0, 0], half), capsule(a, b, 0.05))
            assert found.distance[0] == pytest.approx(apart - 0.05, abs=SEARCHED)


def test_shapes_that_just_touch_have_no_penetration_depth() -> None:
    """Where the search of a library for the depth failed, and told 60 m."""
    sizes = [np.array(s) / 2 for s in ((54, 28, 10), (4, 4, 102), (2, 2, 2), (4, 1.2, 1.2))]
    turns = [Rotation.from_euler(axis, angle, degrees=True) for axis in "xyz" for angle in (0, 1e-7, 90, 180)]
    for half in sizes:
        for other in sizes:
            for turn in turns:
                for gap in (-1e-3, -1e-9, 0.0, 1e-9, 1e-6):
                    x = half[0] + float(np.abs(turn.as_matrix()[0]) @ other) + gap
                    found = exactly(box([0, 0, 0], half), box([x, 0, 0], other, turn))
                    assert found.distance[0] == pytest.approx(gap, abs=CLOSE)


def test_the_lower_bound_along_a_straight_path_is_below_the_distance_at_every_point_of_it() -> None:
    rng = np.random.default_rng(5)
    for _ in range(CASES):
        half, other = rng.uniform(0.1, 5.0, 3), rng.uniform(0.1, 5.0, 3)
        turn, start, end = Rotation.random(random_state=rng), rng.normal(0.0, 9.0, 3), rng.normal(0.0, 9.0, 3)
        fixed = box([0, 0, 0], half)
        distance = [box((1 - s) * start + s * end, other, turn) for s in np.linspace(0.0, 1.0, 21)]
        bound = float(bounds_between((fixed, fixed), (distance[0], distance[-1]))[0])
        assert bound <= min(exactly(fixed, there).distance[0] for there in distance) + CLOSE
