"""Rotation matrices become SciPy's quaternions, also for half turns and inexact rotations."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
from heavylift.kernel.algebra import quaternions
from scipy.spatial.transform import Rotation

RANDOM = np.random.default_rng(7)
AXES = RANDOM.normal(size=(2000, 3))
UNIT = AXES / np.linalg.norm(AXES, axis=1)[:, None]
SMALL = 10.0 ** RANDOM.uniform(-17, -2, (2000, 1))


def test_quaternions_of_random_rotations_agree_with_independent_code() -> None:
    quarters = [np.eye(3)[list(p)] * signs for p in permutations(range(3)) for signs in product((1.0, -1.0), repeat=3)]
    turns = Rotation.from_rotvec(np.vstack([AXES, UNIT * SMALL, UNIT * (np.pi - SMALL)])).as_matrix()
    rotations = np.array([*(R for R in quarters if np.linalg.det(R) > 0.0), *turns])
    sheared = rotations + RANDOM.normal(size=rotations.shape) * 1e-4
    for R in (rotations, sheared):
        np.testing.assert_allclose(quaternions(R), Rotation.from_matrix(R).as_quat(canonical=True), rtol=0, atol=1e-15)


def test_quaternions_of_inexact_rotations_have_unit_length_and_the_matrices_are_not_changed() -> None:
    for R in (np.diag([1.1, 1.0, 1.0])[None], np.diag([1.1, 1.0, 1.0]) * np.ones((3, 1, 1))):
        before = R.copy()
        np.testing.assert_allclose(quaternions(R), [[0.0, 0.0, 0.0, 1.0]] * len(R), rtol=0, atol=1e-15)
        assert (before == R).all()
