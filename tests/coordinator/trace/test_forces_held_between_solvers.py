"""A rope cut between two solvers that exchange held forces every h gains energy: a damping ratio of -w h / 4."""

import pytest
from heavylift.coordinator.trace import CoupledPair, held

PAIR = CoupledPair("rope", 2.5e6, 4.95e5, 2.9e7)  # a crane, what hangs on its hook, 50 m of rope
ORDER = 0.3  # times w h: what the law leaves out


@pytest.mark.parametrize("h", [0.02, 0.01, 0.005])
def test_explicit_coupling_with_step_h_reduces_the_damping_ratio_by_omega_h_over_4(h):
    found = held(PAIR, h, lasts=300.0)
    assert found.law == -PAIR.omega * h / 4.0
    assert found.measured == pytest.approx(found.law, rel=ORDER * PAIR.omega * h)


def test_two_pairs_of_bodies_with_the_same_frequency_have_the_same_error_of_co_simulation():
    alone = CoupledPair("mass on a spring", 1e15, 1.0, PAIR.omega**2)
    assert held(alone, 0.02, 1.0).measured == pytest.approx(held(PAIR, 0.02, 1.0).measured, rel=1e-6)


def test_exchanging_coupling_forces_with_one_percent_error_over_five_minutes_requires_steps_of_microseconds():
    one_percent = held(CoupledPair("load", 1e15, 1.0, 8.4**2), 0.01, lasts=300.0).one_percent
    assert one_percent == pytest.approx(1.9e-6, rel=0.02)
