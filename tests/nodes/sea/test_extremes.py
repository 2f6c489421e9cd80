"""Quantiles of the largest values against the distributions that they were drawn from, and SciPy's fits."""

import numpy as np
import pytest
from heavylift.nodes.sea import SURE, extreme, gumbel_fit, part_of
from scipy.stats import gumbel_r, rayleigh

STUDIES = 400
SPREAD = 4.0 * np.sqrt(SURE * (1.0 - SURE) / STUDIES)  # four standard errors of a share of 95 %
PEAKS = 60  # of a run
P90, MPM = 0.9, 1.0 / np.e


def drawn(n: int, seed: int) -> np.ndarray:
    """(STUDIES, n) values of Gumbel's distribution."""
    return gumbel_r.rvs(7.0, 2.0, size=(STUDIES, n), random_state=seed)


def test_the_gumbel_fit_agrees_with_scipy() -> None:
    x = drawn(20, 1)[:20]
    for place, scale, row in zip(*gumbel_fit(x), x, strict=True):
        assert (place, scale) == pytest.approx(gumbel_r.fit(row), rel=1e-5)


@pytest.mark.parametrize("part", [MPM, P90])
@pytest.mark.parametrize("n", [10, 30])
def test_the_confidence_bound_of_a_quantile_exceeds_the_true_quantile_in_95_percent_of_studies(
    n: int, part: float
) -> None:
    want, found = gumbel_r.ppf(part, 7.0, 2.0), [extreme(x, part) for x in drawn(n, n)]
    assert np.mean([x.value + x.above >= want for x in found]) == pytest.approx(SURE, abs=SPREAD)
    assert np.mean([x.value >= want for x in found]) == pytest.approx(0.5, abs=4.0 * 0.5 / np.sqrt(STUDIES))


def test_the_largest_of_rayleigh_distributed_peaks_has_the_quantile_of_its_closed_form() -> None:
    """Peaks of a Gaussian motion: the bound is on the safe side in 95 % of all studies, or in more."""
    peaks = rayleigh.rvs(scale=3.0, size=(STUDIES, 30, PEAKS), random_state=2)
    found = [extreme(x, P90) for x in peaks.max(axis=2)]
    want = rayleigh.ppf(P90 ** (1.0 / PEAKS), scale=3.0)
    assert np.quantile(peaks.max(axis=2), P90) == pytest.approx(want, rel=0.01)  # of 12000 runs
    assert np.mean([x.value + x.above >= want for x in found]) > SURE - SPREAD
    assert np.median([x.value for x in found]) == pytest.approx(want, rel=0.03)  # Gumbel is its limit, of many peaks


def test_the_quantile_bound_holds_for_values_that_no_gumbel_distribution_fits() -> None:
    """One seed in five has a re-hit: the values are not Gumbel's, and the bound still holds."""
    random = np.random.default_rng(3)
    found = []
    for _ in range(STUDIES):
        calm = random.random(30)
        found.append(extreme(np.where(random.random(30) < 0.2, 5.0 + calm, calm), P90))
    assert np.mean([x.value + x.above >= 5.5 for x in found]) > SURE - SPREAD
    assert np.mean([x.how == "order of the values" for x in found]) > 0.9


def test_the_largest_of_29_values_bounds_a_90_percent_quantile_and_that_of_28_does_not() -> None:
    rare = [-np.inf] * 20
    assert extreme([*rare, *range(9)], P90)[:2] == (6.0, 2.0)
    assert extreme([*rare, *range(8)], P90).how == "too few seeds: 29 are needed"


def test_peaks_that_do_not_depend_on_the_sea_have_no_spread_over_seeds() -> None:
    assert extreme([1e6 + 1e-5 * i for i in range(10)], P90)[1:] == (0.0, "equal for all seeds")


def test_the_peak_of_a_long_operation_is_distributed_as_the_maximum_of_its_independent_parts() -> None:
    """The maximum of m Gumbel values is Gumbel's, moved by b log m."""
    part = part_of("MPM", 600.0, 3 * 3600.0)
    assert gumbel_r.ppf(part, 7.0, 2.0) == pytest.approx(7.0 + 2.0 * np.log(18.0), rel=1e-12)
