"""Two things pass each other faster than samples are taken: the verdict sees what no sample shows."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.verdict.distance import Placed, exactly
from heavylift.coordinator.verdict.moving import Moving
from heavylift.coordinator.verdict.nearest import SHARP, nearest, nearest_of_each, whole
from heavylift.nodes.limits.shapes import Solid, Strand
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

Floats = NDArray[np.float64]
CLOSE = 2e-3  # [m]: what the search leaves, and rounding
FINE = 400  # looks between two samples
TEN = 10


def solid(size: tuple[float, ...], t: Floats, centre: Floats, turn: Floats | None = None) -> Moving:
    still = np.array([[0.0, 0.0, 0.0, 1.0]])
    name = f"a body at {centre[0]}"
    shape = Solid(name, "", "loader", name, (0.0, 0.0, 0.0), (size[0], size[1], size[2]))
    return Moving(shape, t, centre, still if turn is None else turn, np.array(size) / 2, 0.0)


def minimum(a: Moving, b: Moving) -> tuple[float, float]:
    start = whole([a, b], [(0, 1)], np.zeros((len(a.t), 3)))
    found = nearest([a, b], start)
    assert found is not None
    return found.least, found.t


def test_a_box_that_flies_through_another_between_two_samples_is_seen() -> None:
    t = np.arange(10.0)
    way = np.stack([30.0 * t - 135.0, np.zeros(10), np.zeros(10)], axis=1)  # at -15 m and 15 m, never at 0
    post, bullet = solid((2, 2, 2), t, np.zeros((10, 3))), solid((1, 1, 1), t, way)
    samples = [exactly(*(Placed(x.centre[[k]], np.eye(3)[None], x.half[None], 0.0) for x in (post, bullet))).distance
               for k in range(10)]  # fmt: skip
    assert min(samples) == pytest.approx(13.5), "no sample shows it"
    least, when = minimum(post, bullet)
    assert least == pytest.approx(-1.5, abs=CLOSE), "1 m and 0.5 m deep, out by its shortest way"
    assert when == pytest.approx(4.5, abs=0.1)


def test_a_pass_at_a_distance_is_told_with_its_time() -> None:
    t = np.arange(6.0)
    way = np.stack([40.0 * t - 90.0, np.full(6, 2.25), np.zeros(6)], axis=1)
    least, when = minimum(solid((2, 2, 2), t, np.zeros((6, 3))), solid((1, 1, 1), t, way))
    assert least == pytest.approx(0.75, abs=CLOSE)
    assert when == pytest.approx(2.25, abs=0.05)


def test_what_turns_back_between_samples_may_have_been_nearer_than_any_sample() -> None:
    """A swing of period 1.3 s, sampled each 0.1 s: the bound is below the apex, and not far below."""
    t = np.arange(0.0, 4.0, 0.1)
    x = 2.0 - 1.0 * np.cos(2 * np.pi * (t - 0.55) / 1.3)
    way = np.stack([-x, np.zeros(len(t)), np.zeros(len(t))], axis=1)
    least, _ = minimum(solid((1, 1, 1), t, np.zeros((len(t), 3))), solid((1, 1, 1), t, way))
    assert 0.0 - 0.1 < least <= 0.0 + SHARP
    assert least < float(np.min(x)) - 1.0 + SHARP


def test_the_minimum_of_random_turning_ways_is_that_of_a_fine_search() -> None:
    rng = np.random.default_rng(6)
    for _ in range(12):
        t = np.arange(7.0)
        sizes = [tuple(rng.uniform(0.5, 6.0, 3)) for _ in range(2)]
        ways = [np.cumsum(rng.normal(0.0, 3.0, (7, 3)), axis=0) + off for off in (np.zeros(3), rng.normal(0.0, 6.0, 3))]
        turns = [Rotation.from_rotvec(np.cumsum(rng.normal(0.0, 0.2, (7, 3)), axis=0)) for _ in range(2)]
        shapes = [solid(s, t, w, q.as_quat()) for s, w, q in zip(sizes, ways, turns, strict=True)]
        least, _ = minimum(*shapes)
        fine = np.linspace(0.0, 6.0, FINE + 1)
        poses = [
            (np.stack([np.interp(fine, t, w[:, i]) for i in range(3)], axis=1), Slerp(t, q)(fine).as_matrix())
            for w, q in zip(ways, turns, strict=True)
        ]
        seen = min(
            exactly(
                *(Placed(p[[k]], R[[k]], s.half[None], 0.0) for (p, R), s in zip(poses, shapes, strict=True))
            ).distance
            for k in range(FINE + 1)
        )
        strays = sum(float(s.stray.max()) for s in shapes)
        assert least <= seen + CLOSE, "the bound is never above what there is"
        assert least >= seen - strays - 0.05, "and below by no more than shapes may stray between samples"


def test_a_search_of_all_things_at_once_finds_the_smallest_that_searches_one_by_one_find() -> None:
    """Boxes that turn and ropes that hang for a while, over more samples than the longest stretch holds."""
    rng = np.random.default_rng(8)
    for _ in range(3):
        n = int(rng.integers(2, 150))
        t, common = 0.5 * np.arange(n), np.zeros((n, 3))
        shapes = []
        for _ in range(6):
            way = rng.normal(0.0, 12.0, 3) + np.cumsum(rng.normal(0.0, 0.1, (n, 3)), axis=0)
            turn = Rotation.from_rotvec(np.cumsum(rng.normal(0.0, 0.01, (n, 3)), axis=0)).as_quat()
            shapes.append(solid(tuple(rng.uniform(0.5, 6.0, 3)), t, way, turn))
        for i in range(3):
            way = rng.normal(0.0, 12.0, 3) + np.cumsum(rng.normal(0.0, 0.1, (n, 3)), axis=0)
            along = np.array([0.0, 0.0, 9.0]) + np.cumsum(rng.normal(0.0, 0.03, (n, 3)), axis=0)
            half = np.array([0.0, 0.0, np.linalg.norm(along, axis=1).max() / 2])
            rope = Strand(f"rope {i}", "rope", f"rope {i}", 0.1, ())
            shapes.append(Moving(rope, t, way, along, half, 0.1, t < t[-1] * rng.uniform(0.3, 1.2)))
        pairs = [(i, j) for i in range(len(shapes)) for j in range(i)]
        alone = [nearest(shapes, whole(shapes, [pair], common)) for pair in pairs]
        least = np.array([m.least if m is not None else np.inf for m in alone])
        start = whole(shapes, pairs, common, range(len(pairs)))
        limit = float(np.sort(least)[TEN + 2])
        for smallest, most in ((TEN, 0.0), (TEN, limit)):
            found = nearest_of_each(shapes, start, np.full(len(pairs), np.inf), smallest, most)
            told = np.array([m.least if m is not None else np.inf for m in found])
            wanted = least <= max(np.sort(least)[smallest - 1], most - CLOSE)
            assert wanted.sum() >= smallest
            assert told[wanted] == pytest.approx(least[wanted], abs=CLOSE)
            assert (told >= least - CLOSE).all(), "of the others at most what was seen on the way"
