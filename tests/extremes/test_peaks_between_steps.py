"""The highest tension of a run is found where it is, between the ends of steps, by steps of the method."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from heavylift.kernel.peaks import AT_ONCE
from small_scenes import EA, LENGTH, MASS, SECOND, G, column, hand_over, hung, started

EXACT = 1e-4  # of the peak, where a run is as exact as that itself
SPIKE = 0.02  # [s]

METHODS = {
    "dopri5": {"tolerance": 1e-9},
    "dop853": {"tolerance": 1e-9},
    "radau5": {"tolerance": 1e-7},
    "ros34pw2": {"tolerance": 1e-8},
    "rk4": {"step": 5e-3},
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("stiffer", [1.0, 30.0])
def test_a_load_let_go_on_a_straight_rope_doubles_its_weight(method, stiffer):
    """With dop853 a step is up to two radians long, and its ends may miss a tenth of the swing."""
    scene = hung(LENGTH)
    scene = replace(scene, ropes=(replace(scene.ropes[0], EA=EA * stiffer),))
    s = started(scene, method=method, sample_ns=SECOND // 20, **METHODS[method])
    hand_over(s, SECOND)
    peaks, when = column(s, "rope/peak")[1], column(s, "rope/peak_time")[1]
    k = int(np.argmax(peaks[:, 0]))
    assert peaks[k, 0] == pytest.approx(2.0 * MASS * G, rel=EXACT)
    w = sqrt(EA * stiffer / LENGTH / MASS)
    assert (when[k, 0] * w / pi) % 2.0 == pytest.approx(1.0, abs=0.02), "at the bottom of a swing"


@pytest.mark.parametrize("method", ["dopri5", "dop853", "radau5"])
def test_a_spike_that_begins_and_ends_in_one_step_is_seen(method):
    """At a loose tolerance the rope is taut and slack again within a step, with no tension at both of its ends."""
    m, h = 100.0, 0.2
    w = pi / SPIKE
    scene = hung(LENGTH - h)
    rope = replace(scene.ropes[0], EA=m * w * w * LENGTH)
    scene = replace(scene, bodies=(replace(scene.bodies[0], mass=m),), ropes=(rope,))
    s = started(scene, tolerance=1e-6, sample_ns=SECOND // 2, method=method)
    hand_over(s, SECOND // 2)
    want = m * G + sqrt((m * G) ** 2 + 2.0 * m * w * w * m * G * h)
    assert column(s, "rope/peak")[1].max() == pytest.approx(want, rel=EXACT)


def test_a_search_changes_nothing_but_the_peaks():
    """Bit for bit, however the time is handed over, and where commands discard the step in which the peak was."""
    whole, parts, calm = (started(hung(LENGTH), method="dop853", sample_ns=SECOND // 20) for _ in range(3))
    calm.X[calm._at["top"]] = np.inf  # nothing can be higher
    hand_over(whole, SECOND)
    hand_over(calm, SECOND)
    for t in range(1, 101):
        parts.run(t * SECOND // 100)
    hand_over(parts, SECOND)
    assert whole["searched"] > calm["searched"] == 0.0
    assert all(whole.X[whole._at[n]].tobytes() == parts.X[parts._at[n]].tobytes() for n in ("top", "peak", "ya", "Tb"))
    assert whole.state.tobytes() == calm.state.tobytes()
    assert [row.tobytes() for _, row in whole.rows] == [row.tobytes() for _, row in parts.rows]


def test_a_swing_without_end_is_not_searched_without_end():
    s = started(hung(LENGTH), method="dop853", tolerance=1e-6, sample_ns=SECOND)
    hand_over(s, 200 * SECOND)
    assert s["searched"] <= AT_ONCE + s["accepted"] / 2048.0 + 1.0
