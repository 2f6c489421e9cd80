"""When slip ends, the tangential spring of a contact continues with the friction force of the slip."""

import numpy as np
import pytest
from heavylift.kernel.forces import friction
from scipy.optimize import brentq

CONTINUOUS = 1e-4  # of the limit that the force may jump; rests are exact to 1e-6 of the loads
STICKS, SLIPS = 1.0, -1.0


@pytest.mark.parametrize("seed", range(20))
def test_the_friction_force_does_not_jump_when_slip_ends(seed):
    random = np.random.default_rng(seed)
    k, limit = 10.0 ** random.uniform(3.0, 9.0), 10.0 ** random.uniform(1.0, 7.0)
    along = np.array([np.cos(seed), np.sin(seed)])
    still = np.zeros(2)

    def at(part, stick):
        return friction(along * part * limit / k, still, limit, k, 0.0, stick, along, at_rest=True)

    assert at(1.1, SLIPS).guard > 0.0, "beyond its limit it goes on slipping"
    ends = brentq(lambda part: float(at(part, SLIPS).guard), 0.5, 1.1, xtol=1e-12)
    jump = np.abs(at(ends, SLIPS).force - at(ends, STICKS).force).max()
    assert ends < 1.0, "a spring that holds its limit would slip at once"
    assert jump < CONTINUOUS * limit
