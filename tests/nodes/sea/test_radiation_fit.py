"""The passive state space of radiation against memories that are known, and against the data of bundled hulls."""

import numpy as np
import pytest
from heavylift.nodes.scenes import vessels_folder
from heavylift.nodes.sea import StateSpace, fitted, read_hydrodynamics

ROUNDING = 1e-9  # relative: states are written with twelve digits


def known(draws: np.random.Generator, m: int) -> StateSpace:
    """A passive and reciprocal memory of m modes that are all coupled, of 2 m states."""
    D, W, E = draws.uniform(0.2, 0.8, m), np.diag(draws.uniform(0.6, 1.6, m)), draws.uniform(0.0, 0.2, m)
    F = np.block([[-np.diag(D), W], [-W.T, -np.diag(E)]])
    return StateSpace(F, np.concatenate([draws.normal(size=(m, m)) * 10.0 ** draws.uniform(2, 5, m), 0.0 * W]))


@pytest.mark.parametrize("m", [1, 3, pytest.param(12, marks=pytest.mark.large)])
def test_a_radiation_memory_function_is_fitted_equally_well_in_all_pairs_of_directions(m: int) -> None:
    """Every damping and added mass to 2 % of its modes' largest, the lower triangle included."""
    draws, w = np.random.default_rng(m), np.arange(0.1, 3.0, 0.1)
    K = known(draws, m).memory(w)
    A_inf = np.diag(np.abs(K).max(axis=0).diagonal())
    A, B = K.imag / w[:, None, None] + A_inf, K.real
    space, error = fitted(w, A, B, A_inf)
    assert max(error.added_mass, error.damping) < 0.02
    assert np.linalg.eigvalsh(space.F + space.F.T).max() < 1e-12
    found = space.memory(w)
    sizes = np.sqrt(np.abs(B).max(axis=0).diagonal())
    assert np.abs((found.real - B) / np.outer(sizes, sizes)).max() < 0.02
    assert np.abs((found - found.swapaxes(1, 2)) / np.outer(sizes, sizes)).max() < ROUNDING


@pytest.mark.parametrize("path", sorted(vessels_folder().glob("*.json")), ids=lambda path: path.stem)
def test_bundled_hulls_have_passive_radiation_models_and_state_their_fit_errors(path):
    hull = read_hydrodynamics(path.read_bytes(), path.name)
    F = np.array(hull.radiation.F)
    assert np.linalg.eigvalsh(F + F.T).max() < 1e-9
    K = StateSpace(F, np.array(hull.radiation.G)).memory(np.array(hull.loads.frequencies))
    assert np.abs(K - K.swapaxes(1, 2)).max() < ROUNDING * np.abs(K).max(), "waves act alike in both directions"
    assert 0.0 < hull.radiation.error.added_mass < 0.05
    assert 0.0 < hull.radiation.error.damping < 0.05
    assert np.linalg.eigvalsh(np.array(hull.added_mass)).min() > 0.0
