"""Inputs that made a log come back within their uncertainty; those that it cannot tell are named and not fitted."""

from __future__ import annotations

import numpy as np
from heavylift.coordinator.measured import Alignment, Identifiable, InputEstimates, estimate
from heavylift.nodes.scene import Input
from small_lift import TIMES, tension

NAMES = ["weight", "share", "twin", "paint"]
START = np.array([1e6, 0.6, 1.0, 1.0])
INPUTS = [Input(*given) for given in zip(NAMES, START.tolist(), [1e6, 0.5, 1.0, 1.0], strict=True)]


def model(p: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Two ropes under `weight` times `twin`, `share` of it on the first; `paint` does nothing."""
    T = tension(TIMES, p[0] * p[2], p[1])
    return [(TIMES, T[:, 0]), (TIMES, T[:, 1])]


def told(rng: np.random.Generator, true: np.ndarray, offset: float, u: float = 0.0) -> Identifiable:
    """A log at 5 Hz with noise of 3 kN, and cells that are each wrong by something of `u`."""
    t = np.arange(1.0, 38.0, 0.2)
    noise = 3e3 * rng.standard_normal((2, len(t)))
    wrong = u * rng.standard_normal(2)
    D = [np.interp(t, T, S) + n + w for (T, S), n, w in zip(model(true), noise, wrong, strict=True)]
    return Identifiable(t - offset, D, [np.full(len(t), u)] * 2, [3e3, 3e3])


def fitted(rng: np.random.Generator, true: np.ndarray, names: list[int], u: float = 0.0) -> InputEstimates:
    offset = rng.uniform(-50.0, 50.0)

    def simulate(p: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        every = START.copy()
        every[names] = p
        return model(every)

    at = Alignment(offset + rng.normal(0.0, 0.05), 0.05, 1.0, True)
    given = told(rng, true, offset, u)
    return estimate(simulate, [INPUTS[i] for i in names], given, at)


def test_estimated_inputs_are_within_their_uncertainty_on_random_logs() -> None:
    for u, seed in ((0.0, 3), (4e3, 4)):  # noise alone; and cells that are wrong as stated
        rng, off = np.random.default_rng(seed), list[float]()
        for _ in range(25):
            true = np.array([rng.uniform(0.8e6, 1.2e6), rng.uniform(0.5, 0.7), 1.0, 1.0])
            found = fitted(rng, true, [0, 1], u)
            off += [(found.values[i] - true[i]) / found.sigma[i] for i in (0, 1)]
        missed = np.mean(np.abs(off) > 2.0)
        assert missed <= 0.12  # of 50; 0.05 are expected
        assert 0.7 < np.std(off) < 1.3  # and the uncertainty is no larger than it need be


def test_uncertain_inputs_that_do_not_affect_a_measured_log_are_reported_by_name() -> None:
    found = fitted(np.random.default_rng(1), np.array([1.1e6, 0.6, 1.0, 1.0]), [0, 3])
    assert set(found.values) == {0}
    assert "hardly depends on it" in found.unknown[1]


def test_uncertain_inputs_whose_effects_on_a_log_cannot_be_distinguished_are_named_together() -> None:
    found = fitted(np.random.default_rng(1), np.array([1.1e6, 0.62, 1.0, 1.0]), [0, 1, 2])
    assert set(found.values) == {1}  # the share alone
    assert "cannot distinguish it from twin (correlation 1.0000)" in found.unknown[0]
    assert "cannot distinguish it from weight" in found.unknown[2]


def test_a_kink_in_the_response_to_an_uncertain_input_is_not_mistaken_for_numerical_noise() -> None:
    """Where the load takes over depends on how far from the middle it hangs, to whichever side."""
    rng = np.random.default_rng(7)

    def kinked(p: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        T = tension(TIMES, 1e6, 0.5 + p[0], 8.0 + 40.0 * abs(p[0]))
        return [(TIMES, T[:, 0]), (TIMES, T[:, 1])]

    t = np.arange(1.0, 38.0, 0.2)
    D = [np.interp(t, T, S) + 3e3 * rng.standard_normal(len(t)) for T, S in kinked(np.array([0.06]))]
    given = Identifiable(t, D, [np.zeros(len(t))] * 2, [3e3, 3e3])
    found = estimate(kinked, [Input("off", 0.0, 1.0)], given, Alignment(0.0))
    assert abs(found.values[0] - 0.06) < 3.0 * found.sigma[0] < 3e-3


def test_numerical_noise_of_a_simulation_is_not_mistaken_for_the_effect_of_an_input() -> None:
    rng = np.random.default_rng(8)
    jitter = lambda p: model(np.array([1e6 + 1e4 * rng.standard_normal(), 0.6, 1.0, 1.0]))  # noqa: E731
    given = told(rng, START, 0.0)
    found = estimate(jitter, [Input("off", 0.0, 1.0)], given, Alignment(0.0))
    assert found.unknown == {0: "its effect is smaller than the numerical noise of the run"}


def test_a_clock_offset_given_by_the_user_is_not_estimated() -> None:
    rng = np.random.default_rng(2)
    true = np.array([1.05e6, 0.6, 1.0, 1.0])
    given = told(rng, true, 7.0)
    found = estimate(lambda p: model(np.array([p[0], 0.6, 1.0, 1.0])), INPUTS[:1], given, Alignment(7.0))
    assert found.at == Alignment(7.0)
    assert abs(found.values[0] - 1.05e6) < 3.0 * found.sigma[0] < 3e3
