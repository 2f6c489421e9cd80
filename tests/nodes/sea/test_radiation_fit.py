"""The passive state space of radiation against memories that are known, and against the data of bundled hulls."""

import numpy as np
import pytest
from heavylift.nodes.scenes import vessels_folder
from heavylift.nodes.sea import StateSpace, fitted, read_hydrodynamics


def known() -> StateSpace:
    """A passive memory of heave, and of surge with pitch."""
    F = np.array(
        [
            [-0.5, 0.9, 0, 0, 0],
            [-0.9, -0.1, 0, 0, 0],
            [0, 0, -0.4, 0.8, 0.1],
            [0, 0, -0.8, -0.3, 0.5],
            [0, 0, -0.1, -0.5, -0.9],
        ]
    )
    G = np.zeros((5, 6))
    G[:2, 2] = 900.0, 100.0
    G[2:, 0], G[2:, 4] = (300.0, -40.0, 20.0), (4000.0, 900.0, -2500.0)
    return StateSpace(F, G)


def test_a_known_radiation_memory_function_is_fitted():
    """Data of a passive memory with uncoupled modes at rest: damping and added mass to 2 %."""
    w = np.arange(0.1, 3.0, 0.1)
    K = known().memory(w)
    rest = np.zeros((6, 6))
    rest[1, 1], rest[3, 3], rest[5, 5] = 1.0, 1.0, 1.0
    small = 1e5 * rest * (1j * w / (1.0 - w * w + 0.8j * w))[:, None, None]  # of the other modes
    A_inf = np.diag([1e6, 2e6, 5e6, 1e8, 3e8, 2e8])
    K = K + small
    A, B = K.imag / w[:, None, None] + A_inf, K.real
    space, error = fitted(w, A, B, A_inf)
    assert max(error.added_mass, error.damping) < 0.02
    assert np.linalg.eigvalsh(space.F + space.F.T).max() < 1e-12
    found = space.memory(w)
    sizes = np.sqrt(np.abs(B).max(axis=0).diagonal())
    assert np.abs((found.real - B) / np.outer(sizes, sizes)).max() < 0.02


@pytest.mark.parametrize("path", sorted(vessels_folder().glob("*.json")), ids=lambda path: path.stem)
def test_bundled_hulls_have_passive_radiation_and_state_its_error(path):
    hull = read_hydrodynamics(path.read_bytes(), path.name)
    F = np.array(hull.radiation.F)
    assert np.linalg.eigvalsh(F + F.T).max() < 1e-9
    assert 0.0 < hull.radiation.error.added_mass < 0.05
    assert 0.0 < hull.radiation.error.damping < 0.05
    assert np.linalg.eigvalsh(np.array(hull.added_mass)).min() > 0.0
