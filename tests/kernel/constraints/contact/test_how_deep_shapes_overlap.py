"""The gap of overlapping shapes is their negative depth, against SciPy's convex hulls."""

from __future__ import annotations

from itertools import product

import numpy as np
from heavylift.kernel.constraints.contact import gap
from heavylift.kernel.description import Ball, Box, Contact, Plane
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

ROUNDING = 1e-9
CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))
CASES = 150


def test_the_overlap_depth_of_boxes_agrees_with_the_convex_hull_of_their_minkowski_difference() -> None:
    """The hull of all differences of corners holds the origin where they overlap, as deep as its nearest face."""
    rng, deep = np.random.default_rng(1), 0
    for _ in range(CASES):
        shapes, poses, corners, columns = [], [], [], []
        for body in "ab":
            own, turn, p = (
                Rotation.random(random_state=rng),
                Rotation.random(random_state=rng),
                rng.normal(0.0, 2.0, 3),
            )
            size, offset = rng.uniform(0.1, 6.0, 3), rng.normal(0.0, 1.0, 3)
            R = own.as_matrix()
            shapes.append(Box(body, tuple(size), tuple(offset), tuple(map(tuple, R))))
            poses.append((p, turn.as_matrix()))
            columns.append(turn.as_matrix() @ R * size)
            corners.append(p + turn.as_matrix() @ offset + CORNERS @ columns[-1].T)
        hull = ConvexHull((corners[0][:, None] - corners[1]).reshape(-1, 3))
        depth, found = float(hull.equations[:, 3].max()), gap(Contact("c", *shapes), *poses)
        if depth < 0.0:
            assert abs(found - depth) < ROUNDING
        else:
            d = corners[1].mean(axis=0) - corners[0].mean(axis=0)
            M = np.hstack([columns[0], -columns[1]])
            apart = float(np.linalg.norm(M @ lsq_linear(M, d, (-0.5, 0.5), method="bvls").x - d))
            assert 0.0 < found <= apart + ROUNDING
        deep += depth < 0.0
    assert 30 < deep < CASES - 30, "of both kinds"


def test_the_overlap_depth_of_balls_and_planes_agrees_with_closed_forms() -> None:
    rng = np.random.default_rng(2)
    for _ in range(CASES):
        p, q, normal = rng.normal(0.0, 2.0, (3, 3))
        r, s = rng.uniform(0.0, 2.0, 2)
        at: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = [(p, np.eye(3)), (q, np.eye(3))]
        apart = float(np.linalg.norm(p - q)) - r
        assert abs(gap(Contact("c", Ball("a", radius=r), Ball("b", radius=s)), *at) - (apart - s)) < ROUNDING
        on_plane = float((p - q) @ normal / np.linalg.norm(normal)) - r
        assert (
            abs(gap(Contact("c", Ball("a", radius=r), Plane("b", (0.0, 0.0, 0.0), tuple(normal))), *at) - on_plane)
            < ROUNDING
        )
        inside = Contact("c", Ball("a", radius=r), Box("b", (4.0, 5.0, 6.0)))
        beyond = np.abs(p - q) - (2.0, 2.5, 3.0)
        found = gap(inside, *at)
        if beyond.max() < 0.0:
            assert abs(found - (beyond.max() - r)) < ROUNDING
        else:
            assert found <= float(np.linalg.norm(np.maximum(beyond, 0.0))) - r + ROUNDING
