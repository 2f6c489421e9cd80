"""SciPy's integrators on the same equations find the results of the kernel's own methods."""

from typing import get_args

import numpy as np
import pytest
from goliath import scene
from heavylift.kernel.description import MethodName
from heavylift.kernel.methods import METHODS
from scipy_peers import PEERS
from small_scenes import SECOND, column, hand_over, hung, started, times

TOLERANCE = 1e-7
TENSION = {"scipy-radau": 1e-6, "scipy-lsoda": 1e-5}  # of the largest tension
INSTANT = 1e-6  # [s] of the fifth event


def tensions(method, **options):
    s = started(scene(), method=method, sample_ns=SECOND // 10, **options)
    hand_over(s, SECOND)
    return column(s, "rope/tension")[1]


@pytest.mark.parametrize("method", TENSION)
def test_the_tensions_of_the_reference_scene_agree_with_scipy(method):
    exact = tensions("dop853", tolerance=1e-11)
    error = np.abs(tensions(method, tolerance=TOLERANCE) - exact).max() / exact.max()
    assert error < TENSION[method]


@pytest.mark.parametrize("method", PEERS)
def test_the_impact_times_of_a_bouncing_load_agree_with_scipy(method):
    both = []
    for name, tolerance in ((method, 1e-9), ("dop853", 1e-11)):
        s = started(hung(59.9), method=name, tolerance=tolerance)
        hand_over(s, 2 * SECOND)
        both.append(sorted(times(s, "rope", "taut") + times(s, "rope", "slack")))
    assert len(both[0]) >= 5
    assert both[0] == pytest.approx(both[1], abs=INSTANT)


def test_scenes_and_the_kernel_offer_the_same_integration_methods():
    assert set(get_args(MethodName)) == METHODS.keys() - PEERS.keys()
