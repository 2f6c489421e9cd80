"""Two things pass each other faster than samples are taken: the verdict sees what no sample shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.coordinator.verdict import (
    SHARP,
    BodyTrack,
    Coarse,
    Minimum,
    Moving,
    NearestSoFar,
    Placed,
    Stretches,
    exactly,
    history_of,
    search,
    strays,
    twists,
    whole,
)
from heavylift.kernel.description import Vector
from heavylift.nodes.models import system
from heavylift.nodes.plan import Solid, Strand
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

Floats = NDArray[np.float64]
CLOSE = 2e-3  # [m]: what the search leaves, and rounding
FINE = 400  # looks between two samples
TEN = 10
ORIGIN = (0.0, 0.0, 0.0)


def solid(size: tuple[float, ...], t: Floats, centre: Floats, turn: Floats | None = None) -> Moving:
    name = f"a body at {centre[0]}"
    shape = Solid(name, "", "loader", name, ORIGIN, (size[0], size[1], size[2]))
    return Moving(shape, (fixed(t, centre, turn),))


def fixed(t: Floats, centre: Floats, turn: Floats | None = None) -> tuple[BodyTrack, Vector]:
    still = np.tile([0.0, 0.0, 0.0, 1.0], (len(t), 1))
    return BodyTrack(t, np.hstack([centre, still if turn is None else turn])), ORIGIN


def stretches(shapes: list[Moving], pairs: list[tuple[int, int]], groups: range | None = None) -> Stretches:
    n = len(shapes[0].t)
    return whole(Coarse(shapes, np.zeros((n, 2)), (0, n - 1)), pairs, groups)


def nearest(shapes: list[Moving], start: Stretches, most: float = np.inf) -> Minimum | None:
    """The minimum over stretches of one group; None if they stay farther apart than `most` [m]."""
    known = NearestSoFar(0, 0.0)
    known.groups(np.array([most]))
    search(shapes, start, known)
    (found,) = known.take()
    return found if found is not None and found.least < most else None


def minimum(a: Moving, b: Moving) -> tuple[float, float]:
    found = nearest([a, b], stretches([a, b], [(0, 1)]))
    assert found is not None
    return found.least, found.t


def test_the_collision_of_a_box_that_passes_through_another_between_two_samples_is_found() -> None:
    t = np.arange(10.0)
    distance = np.stack([30.0 * t - 135.0, np.zeros(10), np.zeros(10)], axis=1)  # at -15 m and 15 m, never at 0
    post, bullet = solid((2, 2, 2), t, np.zeros((10, 3))), solid((1, 1, 1), t, distance)
    samples = [exactly(*(Placed(x.centre[[k]], np.eye(3)[None], x.half[None], 0.0) for x in (post, bullet))).distance[0]
               for k in range(10)]  # fmt: skip
    assert min(samples) == pytest.approx(13.5), "no sample shows it"
    least, when = minimum(post, bullet)
    assert least == pytest.approx(-1.5, abs=CLOSE), "1 m and 0.5 m deep, out by its shortest way"
    assert when == pytest.approx(4.5, abs=0.1)


def test_the_smallest_distance_of_boxes_that_pass_each_other_is_found_with_its_time() -> None:
    t = np.arange(6.0)
    distance = np.stack([40.0 * t - 90.0, np.full(6, 2.25), np.zeros(6)], axis=1)
    least, when = minimum(solid((2, 2, 2), t, np.zeros((6, 3))), solid((1, 1, 1), t, distance))
    assert least == pytest.approx(0.75, abs=CLOSE)
    assert when == pytest.approx(2.25, abs=0.05)


def test_the_smallest_distance_at_a_reversal_of_motion_between_samples_is_found() -> None:
    """A swing of period 1.3 s, sampled each 0.1 s: the bound is below the apex, and not far below."""
    t = np.arange(0.0, 4.0, 0.1)
    x = 2.0 - 1.0 * np.cos(2 * np.pi * (t - 0.55) / 1.3)
    distance = np.stack([-x, np.zeros(len(t)), np.zeros(len(t))], axis=1)
    least, _ = minimum(solid((1, 1, 1), t, np.zeros((len(t), 3))), solid((1, 1, 1), t, distance))
    assert 0.0 - 0.1 < least <= 0.0 + SHARP
    assert least < float(np.min(x)) - 1.0 + SHARP


def test_the_smallest_distance_along_random_rotating_paths_agrees_with_a_fine_search() -> None:
    rng = np.random.default_rng(6)
    for _ in range(12):
        t = np.arange(7.0)
        sizes = [tuple(rng.uniform(0.5, 6.0, 3)) for _ in range(2)]
        distances = [
            np.cumsum(rng.normal(0.0, 3.0, (7, 3)), axis=0) + off for off in (np.zeros(3), rng.normal(0.0, 6.0, 3))
        ]
        turns = [Rotation.from_rotvec(np.cumsum(rng.normal(0.0, 0.2, (7, 3)), axis=0)) for _ in range(2)]
        shapes = [solid(s, t, w, q.as_quat()) for s, w, q in zip(sizes, distances, turns, strict=True)]
        least, _ = minimum(*shapes)
        fine = np.linspace(0.0, 6.0, FINE + 1)
        poses = [
            (np.stack([np.interp(fine, t, w[:, i]) for i in range(3)], axis=1), Slerp(t, q)(fine).as_matrix())
            for w, q in zip(distances, turns, strict=True)
        ]
        placed = (Placed(p, R, np.broadcast_to(s.half, p.shape), 0.0) for (p, R), s in zip(poses, shapes, strict=True))
        seen = exactly(*placed).distance.min()
        strays = sum(float(s.stray.max()) for s in shapes)
        assert least <= seen + CLOSE, "the bound is never above what there is"
        assert least >= seen - strays - 0.05, "and below by no more than shapes may stray between samples"


def test_one_search_over_all_pairs_of_shapes_finds_the_minima_of_separate_searches() -> None:
    """Boxes that turn and ropes that hang for a while, over more samples than the longest stretch holds."""
    rng = np.random.default_rng(8)
    for _ in range(3):
        n = int(rng.integers(2, 150))
        t = 0.5 * np.arange(n)
        shapes = []
        for _ in range(6):
            distance = rng.normal(0.0, 12.0, 3) + np.cumsum(rng.normal(0.0, 0.1, (n, 3)), axis=0)
            turn = Rotation.from_rotvec(np.cumsum(rng.normal(0.0, 0.01, (n, 3)), axis=0)).as_quat()
            shapes.append(solid(tuple(rng.uniform(0.5, 6.0, 3)), t, distance, turn))
        for i in range(3):
            distance = rng.normal(0.0, 12.0, 3) + np.cumsum(rng.normal(0.0, 0.1, (n, 3)), axis=0)
            along = np.array([0.0, 0.0, 9.0]) + np.cumsum(rng.normal(0.0, 0.03, (n, 3)), axis=0)
            rope = Strand(f"rope {i}", "rope", f"rope {i}", 0.1, ())
            ends = fixed(t, distance - along / 2), fixed(t, distance + along / 2)
            shapes.append(Moving(rope, ends, t < t[-1] * rng.uniform(0.3, 1.2)))
        pairs = [(i, j) for i in range(len(shapes)) for j in range(i)]
        alone = [nearest(shapes, stretches(shapes, [pair])) for pair in pairs]
        least = np.array([m.least if m is not None else np.inf for m in alone])
        start = stretches(shapes, pairs, range(len(pairs)))
        limit = float(np.sort(least)[TEN + 2])
        for smallest, most in ((TEN, 0.0), (TEN, limit)):
            known = NearestSoFar(smallest, most)
            known.groups(np.full(len(pairs), np.inf))
            search(shapes, start, known)
            message = np.array([m.least if m is not None else np.inf for m in known.take()])
            wanted = least <= max(np.sort(least)[smallest - 1], most - CLOSE)
            assert wanted.sum() >= smallest
            assert message[wanted] == pytest.approx(least[wanted], abs=CLOSE)
            assert (message >= least - CLOSE).all(), "of the others at most what was seen on the way"


def test_the_motion_by_a_vibration_faster_than_the_sample_rate_is_bounded_from_the_joint_speeds() -> None:
    """At 9.7 Hz, seen twice in a second: hardly a way from sample to sample."""
    t, w, size = np.arange(0.0, 20.0, 0.5), 2 * np.pi * 9.7, 0.05
    still, phase = np.zeros(len(t)), w * t
    pose = np.zeros((len(t), 7))
    pose[:, 0] = size * np.sin(phase)
    pose[:, 3:] = Rotation.from_rotvec(np.outer(size * np.sin(phase), (0, 0, 1))).as_quat()
    speed = size * w * np.cos(phase)
    v, turning = np.stack([speed, still, still], axis=1), np.stack([still, still, speed], axis=1)
    origin, each_metre = strays(t, pose, (v, turning))
    assert np.mean(origin > size) > 0.9
    assert np.mean(each_metre > size) > 0.9
    calm = strays(t, pose, (0.0 * v, 0.0 * turning))[1]
    assert calm.max() < 3 * size, "the ways between samples alone"


def test_slow_motion_between_samples_deviates_from_a_straight_line_by_at_most_the_bound_from_accelerations() -> None:
    """Of a constant acceleration, straight and turning: twice h^2 / 8 times it."""
    t, a = np.arange(0.0, 5.0, 0.5), 0.3
    pose = np.zeros((len(t), 7))
    pose[:, 1] = a * t**2 / 2
    pose[:, 3:] = Rotation.from_rotvec(np.outer(a * t**2 / 2, (1, 0, 0))).as_quat()
    pose[::2, 3:] *= -1.0
    speed = np.zeros((2, len(t), 3))
    speed[0, :, 1] = speed[1, :, 0] = a * t
    for found in strays(t, pose, (speed[0], speed[1])):
        assert found == pytest.approx(np.full(len(t) - 1, a * 0.25 / 4))


def test_speeds_of_bodies_computed_from_joints_agree_with_differences_of_their_positions(tmp_path: Path) -> None:
    scene = load("lift", ["samples=50 Hz", "end=4 s"])
    run(scene, tmp_path / "run.mcap", in_process=True)
    past = history_of(Recording(tmp_path / "run.mcap")).part(0, 200)
    past = past.of(np.flatnonzero(np.diff(past.t, prepend=-1.0) > 0.01))
    frames = {name: BodyTrack(past.t, pose) for name, pose in past.poses.items()}
    frames["world"] = fixed(past.t, np.zeros((len(past.t), 3)))[0]
    found, h = twists(system(scene.plan).joints, frames, past.speeds), np.diff(past.t)[:, None]
    assert set(found) >= set(past.poses)
    for body, pose in past.poses.items():
        v, w = found[body]
        turned = (Rotation.from_quat(pose[1:, 3:]) * Rotation.from_quat(pose[:-1, 3:]).inv()).as_rotvec()
        for one, mean in ((v, np.diff(pose[:, :3], axis=0) / h), (w, turned / h)):
            assert np.abs((one[1:] + one[:-1]) / 2 - mean).max() < 1e-4 + 0.05 * np.abs(one).max(), body
