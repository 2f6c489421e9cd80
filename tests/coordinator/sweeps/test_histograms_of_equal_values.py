"""The page of a study draws results that are equal but for rounding, and results that no variant has."""

import numpy as np
import pytest
from heavylift.coordinator.sweeps import Summary
from heavylift.coordinator.sweeps.page import _histograms

NEAR = np.nextafter(88.7, 90.0)


@pytest.mark.parametrize("values", [[88.7, NEAR], [88.7, 88.7], [0.0, 0.0], [np.nan, np.nan], [1.0, 2.0, np.nan]])
def test_a_histogram_of_equal_results_is_drawn_without_an_error(values: list[float]) -> None:
    found = object.__new__(Summary)
    object.__setattr__(found, "results", {"use": np.array(values)})
    assert _histograms(found)
