"""Distances of boxes and capsules: closed forms, SciPy's bounded least squares, and shapes that touch exactly."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.verdict.distance import Placed, bounds, bounds_between, exactly
from numpy.typing import NDArray
from scipy.optimize import lsq_linear, minimize_scalar
from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]
CLOSE = 1e-5  # [m]: ten times the tolerance of Coal's search
ROUNDING = 1e-9
CASES = 200


def box(centre: list[float] | Floats, half: list[float] | Floats, turn: Rotation | None = None) -> Placed:
    R = (turn or Rotation.identity()).as_matrix()
    return Placed(np.array([centre], float), R[None], np.array([half], float), 0.0)


def capsule(a: Floats, b: Floats, radius: float) -> Placed:
    length = float(np.linalg.norm(b - a))
    R = Rotation.align_vectors([b - a], [[0.0, 0.0, length]])[0].as_matrix()
    return Placed((a + b)[None] / 2, R[None], np.array([[0.0, 0.0, length / 2]]), radius)


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
def test_closed_forms(a: Placed, b: Placed, distance: float) -> None:
    for one, two in ((a, b), (b, a)):
        found = exactly(one, two)
        assert found.distance == pytest.approx(distance, abs=CLOSE)
        assert bounds(one, two)[0] <= distance + ROUNDING


def test_random_boxes_are_as_far_apart_as_scipy_says() -> None:
    rng = np.random.default_rng(3)
    for _ in range(CASES):
        half, other, centre = rng.uniform(0.1, 5.0, 3), rng.uniform(0.1, 5.0, 3), rng.normal(0.0, 6.0, 3)
        turn = Rotation.random(random_state=rng)
        M, both = np.hstack([np.eye(3), -turn.as_matrix()]), np.concatenate([half, other])
        apart = float(np.linalg.norm(M @ lsq_linear(M, centre, (-both, both), method="bvls").x - centre))
        a, b = box([0, 0, 0], half), box(centre, other, turn)
        found = exactly(a, b)
        assert max(found.distance, 0.0) == pytest.approx(apart, abs=CLOSE)
        assert bounds(a, b)[0] <= found.distance + ROUNDING
        if found.distance > CLOSE:
            assert np.linalg.norm(found.b - found.a) == pytest.approx(found.distance, abs=CLOSE)


def test_random_capsules_are_as_far_from_a_box_as_a_search_along_them_says() -> None:
    rng = np.random.default_rng(4)
    for _ in range(CASES):
        half, a, b = rng.uniform(0.5, 9.0, 3), rng.normal(0.0, 12.0, 3), rng.normal(0.0, 12.0, 3)

        def off(s: float, half: Floats = half, a: Floats = a, b: Floats = b) -> float:
            return float(np.linalg.norm(np.maximum(np.abs(a + s * (b - a)) - half, 0.0)))

        apart = minimize_scalar(off, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-12}).fun
        if apart > 0.05:
            found = exactly(box([0, 0, 0], half), capsule(a, b, 0.05))
            assert found.distance == pytest.approx(apart - 0.05, abs=CLOSE)


def test_shapes_that_just_touch_are_not_deep_in_one_another() -> None:
    """Where the library's search for the depth fails, and tells 60 m, the depth is that of the separating axis."""
    sizes = [np.array(s) / 2 for s in ((54, 28, 10), (4, 4, 102), (2, 2, 2), (4, 1.2, 1.2))]
    turns = [Rotation.from_euler(axis, angle, degrees=True) for axis in "xyz" for angle in (0, 1e-7, 90, 180)]
    for half in sizes:
        for other in sizes:
            for turn in turns:
                for gap in (-1e-3, -1e-9, 0.0, 1e-9, 1e-6):
                    x = half[0] + float(np.abs(turn.as_matrix()[0]) @ other) + gap
                    found = exactly(box([0, 0, 0], half), box([x, 0, 0], other, turn))
                    assert found.distance == pytest.approx(gap, abs=CLOSE)


def test_a_bound_of_a_straight_way_is_below_all_that_is_on_it() -> None:
    rng = np.random.default_rng(5)
    for _ in range(CASES):
        half, other = rng.uniform(0.1, 5.0, 3), rng.uniform(0.1, 5.0, 3)
        turn, start, end = Rotation.random(random_state=rng), rng.normal(0.0, 9.0, 3), rng.normal(0.0, 9.0, 3)
        fixed = box([0, 0, 0], half)
        way = [box((1 - s) * start + s * end, other, turn) for s in np.linspace(0.0, 1.0, 21)]
        bound = float(bounds_between((fixed, fixed), (way[0], way[-1]))[0])
        assert bound <= min(exactly(fixed, there).distance for there in way) + CLOSE
