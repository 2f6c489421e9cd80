"""The full table of extremes with every integrator of the kernel and every peer of SciPy; a million seconds."""

import sys
from math import radians, sin, sqrt
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "extremes"))
sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))

from cells import INTEGRATORS, PEERS, cell
from independent import G, period
from loads_and_swings import bar
from small_scenes import SECOND, column, hand_over, started
from table import EXTREMES

PHASE, ENERGY = 2e-4, 2e-7  # drift in 1e6 s: in periods, and of what swings; measured 9.3e-5 and 9.5e-8


@pytest.mark.parametrize("integrator", [*INTEGRATORS, *PEERS], ids=lambda i: i.name)
@pytest.mark.parametrize("extreme", EXTREMES, ids=lambda x: x.name)
def test_every_extreme_case_of_the_full_table_gives_a_right_result_or_a_warning_or_a_refusal(extreme, integrator):
    found = cell(extreme, integrator)
    assert found.right(integrator.bound), found


def test_a_pendulum_runs_for_a_million_seconds():
    a, L = radians(30.0), 20.0
    T = period(a, L)
    s = started(bar(L, a), method="dop853", tolerance=1e-12, h_max=1.0, sample_ns=10_000 * SECOND)
    hand_over(s, round((round(1e6 / T) + 0.25) * T * SECOND))
    v = 2.0 * sqrt(G / L) * sin(0.5 * a)
    assert abs(float(s.state[0])) / (v * T) < PHASE
    e = column(s, "energy")[1]
    assert np.ptp(e[:, 0] + e[:, 1]) / np.ptp(e[:, 0]) < ENERGY
