"""Damping of the water between two hulls: against a gap that is an oscillator with damping of its own."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scenes import vessels_folder
from heavylift.nodes.sea import Hydrodynamics, SecondHull, read_hydrodynamics, with_gap_damping

W, OWN, ADDED = 1.1, 0.03, 0.05  # of the gap: frequency [rad/s], damping ratio by waves, and added
CLOSE = 0.02  # of the peak: the conjugate pole, and changes of the frequency by damping
FREQUENCIES = np.linspace(0.4, 1.9, 31)


def oscillator(rate: float) -> np.ndarray:
    """(2, 2) the states of the gap with a rate of decay [1/s] beside that of its waves."""
    w = W * np.sqrt(1.0 - OWN * OWN)
    return np.array([[-OWN * W - rate, w], [-w, -OWN * W - rate]])


def decay(ratio: float) -> float:
    """The rate that gives the gap a damping ratio in all [1/s]."""
    return W * (ratio * np.sqrt((1.0 - OWN * OWN) / (1.0 - ratio * ratio)) - OWN)


def hulls(seed: int, rate: float = 0.0, other: float = 0.0) -> tuple[Hydrodynamics, np.ndarray, np.ndarray]:
    """Two hulls with a gap, their radiation K (n, 12, 12), and their loads (headings, n, 12); `other`: frequency of a
    second gap with as much damping [rad/s]."""
    random, w = np.random.default_rng(seed), FREQUENCIES
    barge = read_hydrodynamics((vessels_folder() / "barge-110.json").read_bytes(), "barge-110")
    decays, spins = random.uniform(0.4, 1.0, 4), random.uniform(0.4, 2.0, 4)
    if other:
        decays[0], spins[0] = OWN * other, other * np.sqrt(1.0 - OWN * OWN)
    F = np.zeros((10, 10))
    for i, (a, b) in enumerate(zip(decays, spins, strict=True)):
        F[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[-a, b], [-b, -a]]
    F[8:, 8:] = oscillator(rate)
    G = random.normal(size=(10, 12)) * 1e3
    G[1::2] = 0.0  # a reciprocal network
    turned = np.zeros((10, 10))  # so that no state is that of the gap alone
    for half in (0, 1):
        turned[half::2, half::2] = np.linalg.qr(random.normal(size=(5, 5)))[0]
    K = G.T @ np.linalg.solve(1j * w[:, None, None] * np.eye(10) - F, G.astype(complex))
    peak = np.linalg.inv(1j * w[:, None, None] * np.eye(2) - oscillator(rate))[:, 0, 0]
    headings = np.linspace(-np.pi, np.pi, 13)
    first, second, gap = (random.normal(size=(13, 1, 12)) + 1j * random.normal(size=(13, 1, 12)) for _ in range(3))
    X = 1e6 * (first * (1.0 - 0.2 * w[:, None]) + 0.1j * second * w[:, None] ** 2 + 0.1 * gap * peak[:, None])
    rows = [tuple(map(tuple, (turned @ A).tolist())) for A in (G[:, :6], G[:, 6:])]
    states = tuple(map(tuple, (turned @ F @ turned.T).tolist()))
    made = []
    for i in (0, 1):
        parts = (X[..., 6 * i : 6 * i + 6].real, X[..., 6 * i : 6 * i + 6].imag)
        tables = [tuple(tuple(map(tuple, x)) for x in part.tolist()) for part in parts]
        loads = msgspec.structs.replace(
            barge.loads, frequencies=tuple(w), headings=tuple(headings), real=tables[0], imaginary=tables[1]
        )
        water = msgspec.structs.replace(barge.radiation, F=states if i == 0 else (), G=rows[i])
        made.append(msgspec.structs.replace(barge, loads=loads, radiation=water, symmetric=False))
    none = ((0.0,) * 6,) * 6
    return msgspec.structs.replace(made[0], beside=SecondHull(made[1], (0.0, 40.0, 0.0), none)), K, X


def coefficients(of: Hydrodynamics) -> tuple[np.ndarray, np.ndarray]:
    """K (n, 12, 12) and X (headings, n, 12) of the data of two hulls."""
    second = of.beside
    assert second
    F, G = np.array(of.radiation.F), np.hstack([of.radiation.G, second.hull.radiation.G])
    K = G.T @ np.linalg.solve(1j * FREQUENCIES[:, None, None] * np.eye(len(F)) - F, G.astype(complex))
    each = [np.array(x.loads.real) + 1j * np.array(x.loads.imaginary) for x in (of, second.hull)]
    return K, np.concatenate(each, axis=2)


@pytest.mark.parametrize("seed", range(4))
def test_damping_of_a_gap_gives_the_coefficients_of_an_oscillator_with_that_damping(seed: int) -> None:
    """Radiation exactly, loads to 2 % of their peak; outside the resonance nothing changes."""
    found = with_gap_damping(hulls(seed)[0], ADDED, "a closed form")
    K, X = coefficients(found)
    _, want_K, want_X = hulls(seed, decay(OWN + ADDED))
    old_X = hulls(seed)[2]
    assert np.abs(K - want_K).max() < 1e-9 * np.abs(want_K).max()
    assert np.abs(X - want_X).max() < CLOSE * np.abs(old_X - old_X[:, :1]).max()
    assert np.abs(old_X - want_X).max() > 5.0 * CLOSE * np.abs(old_X - old_X[:, :1]).max(), "damping is seen"
    F = np.array(found.radiation.F)
    assert np.linalg.eigvalsh(F + F.T).max() < 1e-9 * np.abs(F).max(), "passive"
    assert found.beside
    assert found.beside.damping
    assert found.beside.damping.frequency == pytest.approx(W, rel=1e-9)
    assert (found.beside.damping.ratio, found.beside.damping.source) == (ADDED, "a closed form")


def test_another_resonance_with_less_damping_than_stated_is_named_beside_the_damped_one() -> None:
    for ratio, both in ((ADDED, True), (0.5 * OWN, False)):
        second = with_gap_damping(hulls(1, other=1.5)[0], ratio, "x").beside
        assert second
        assert second.damping
        found = second.damping.frequency, second.damping.other
        assert (sorted(map(float, filter(None, found))) == pytest.approx([W, 1.5])) == both
        assert (second.damping.other is None) != both


def test_gap_damping_of_data_without_a_second_hull_or_a_resonance_is_refused() -> None:
    both = hulls(1)[0]
    with pytest.raises(SceneError, match="damping of a gap needs the data of two hulls"):
        with_gap_damping(msgspec.structs.replace(both, beside=None), 0.05, "x")
    with pytest.raises(SceneError, match="damping of a gap is above 0 and below 1"):
        with_gap_damping(both, 0.0, "x")
    with pytest.raises(SceneError, match=r"cannot have the damping ratio 1.02, its own with 0.99 added; give"):
        with_gap_damping(both, 0.99, "x")
    with pytest.raises(SceneError, match=r"between its hulls there is no resonance from 0.4 to 1.9 rad/s to damp"):
        with_gap_damping(hulls(1, 0.4)[0], 0.05, "x")
