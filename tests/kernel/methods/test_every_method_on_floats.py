"""Every method takes the same steps in machine code and in interpreted Python."""

from typing import get_args

import numpy as np
import pytest
from heavylift.kernel.description import MethodName
from small_scenes import SECOND, events, hand_over, hung, started

SAME = 1e-12
FIXED = {"semi-implicit-euler": 0.01, "rk4": 0.01}


@pytest.mark.parametrize("method", get_args(MethodName))
@pytest.mark.large(beyond=4)
def test_every_integration_method_in_interpreted_python_simulates_a_load_caught_by_its_rope(method):
    native, floats = (
        started(hung(59.9), method=method, tolerance=1e-6, step=FIXED.get(method), native=n) for n in (True, False)
    )
    for s in (native, floats):
        hand_over(s, SECOND // 5)
    assert native.state == pytest.approx(floats.state, rel=SAME, abs=SAME)
    assert (native["accepted"], native.log) == (floats["accepted"], floats.log)
    assert events(native) == [("rope", "taut")]
    assert np.isfinite(native.state).all()
