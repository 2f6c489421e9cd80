"""Designs and what they tell: indices of functions with known ones, probabilities with their intervals."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.sweeps import DESIGNS, FEWEST, base_rows, drawn, indices
from heavylift.coordinator.sweeps.page import _around
from heavylift.coordinator.sweeps.summary import _chance
from scipy.stats import binomtest

NAMES = ["a", "b", "c"]


@pytest.mark.parametrize("design", DESIGNS)
def test_sensitivity_indices_of_a_linear_result_follow_from_its_slopes(design: str) -> None:
    quantiles = drawn(design, 2560, 3, seed=3)
    result = quantiles @ [2.0, 1.0, 0.0]
    found = {x.axis: x for x in indices(design, NAMES, quantiles, result, seed=3)}
    assert [found[name].first for name in NAMES] == pytest.approx([0.8, 0.2, 0.0], abs=0.03)
    if design == "sobol":
        assert [found[name].total for name in NAMES] == pytest.approx([0.8, 0.2, 0.0], abs=0.03)


@pytest.mark.parametrize("design", DESIGNS)
def test_sensitivity_indices_are_not_given_for_too_few_samples(design: str) -> None:
    few = drawn(design, FEWEST[design] - 1, 3, seed=1)
    assert indices(design, NAMES, few, few.sum(axis=1), seed=1) == []
    many = drawn(design, 500, 3, seed=1)
    assert indices(design, NAMES, many, np.full(len(many), 4.0), seed=1) == []
    assert indices(design, NAMES, many, np.where(many[:, 0] > 0.9, np.nan, 1.0), seed=1) == []


def test_base_rows_of_a_sobol_design_are_independent_draws_and_other_rows_mix_two_of_them() -> None:
    quantiles = drawn("sobol", 100, 3, seed=1)
    alone = quantiles[base_rows("sobol", len(quantiles), 3)]
    assert len(alone) == 2 * len(quantiles) // 5
    assert len(np.unique(alone, axis=0)) == len(alone)
    mixed = quantiles[~base_rows("sobol", len(quantiles), 3)]
    assert all(any((row == other).sum() == 2 for other in alone) for row in mixed)


@pytest.mark.parametrize(("beyond", "count"), [(0, 40), (3, 40), (40, 40), (1, 1000)])
def test_the_confidence_interval_of_a_fraction_of_variants_is_that_of_clopper_and_pearson(
    beyond: int, count: int
) -> None:
    found = _chance("use/hook", np.array([1.5] * beyond + [0.5] * (count - beyond)))
    known = binomtest(beyond, count).proportion_ci(0.95, "exact")
    assert (found.limit, found.beyond, found.part) == ("hook", beyond, beyond / count)
    assert (found.low, found.high) == (pytest.approx(known.low, abs=1e-12), pytest.approx(known.high, abs=1e-12))


@pytest.mark.parametrize("values", [[0.5] * 3, [0.5, 0.5 + 1e-16, 0.5 - 1e-16], [8e6, 8e6 * (1 + 1e-15)], [1.0, 2.0]])
def test_a_histogram_of_values_that_differ_only_by_rounding_is_drawn(values: list[float]) -> None:
    least, most = _around(np.array(values)) or (0.0, 0.0)
    bins = np.histogram(values, 40, (least, most))[0]
    assert bins.sum() == len(values)
