"""Contacts in machine code and in interpreted Python have the same events and states for any time grants."""

from math import atan

import numpy as np
import pytest
from contact_scenes import bouncing, on_slope
from small_scenes import SECOND, hand_over, started

SAME = 1e-13
SCENES = {
    "a block stops": (on_slope(0.5 * atan(0.4), 0.4, 0.01), 0.01),
    "a ball bounces": (bouncing(0.1, 0.5), 0.3),
}


@pytest.mark.parametrize("name", list(SCENES))
def test_contacts_take_the_same_steps_in_machine_code_and_interpreted_python(name):
    scene, end = SCENES[name]
    native, oracle = (started(scene, tolerance=1e-6, native=n) for n in (True, False))
    for s in (native, oracle):
        s.run(int(end * SECOND))
    assert native.log == oracle.log
    assert native.log
    assert np.abs(native.state - oracle.state).max() < SAME


def test_a_predicted_bounce_of_a_load_does_not_depend_on_the_time_grants_of_the_run():
    whole, granted = (started(bouncing(0.1, 0.5), subscribed=frozenset({"floor"} if s else ())) for s in (False, True))
    hand_over(whole, SECOND // 2)
    required = []
    for t in range(0, SECOND // 2, SECOND // 500):
        granted.run(t)
        while granted.event and granted.next_ns <= t:
            required += granted.preview()
            granted.fire()
            granted.settle()
            granted.run(t)
    hand_over(granted, SECOND // 2)
    assert required == [e for _, e in granted.log]
    assert granted.log == whole.log
    assert granted.state.tobytes() == whole.state.tobytes()
