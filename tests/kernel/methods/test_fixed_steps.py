"""Fixed steps: frequency errors and stability limits against theory; unstable steps are refused."""

import json
from math import acos, pi
from pathlib import Path

import numpy as np
import pytest
from goliath import scene
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, Joint, JointSpring, System
from small_scenes import SECOND, X, column, hand_over, hung, slider, started

FORMS = json.loads((Path(__file__).parents[2] / "data" / "closed_forms.json").read_text())
C21 = next(x for x in FORMS if x["id"] == "C21")
W, H = C21["given"]["w"], C21["given"]["h"]
MASS = 1.0e3
AT_LIMIT = 0.002  # how close below and above the limit of stability steps are tried
FREQUENCY = 1e-9  # of the frequency error, read from 1000 steps


def oscillator(q0: float = 1.0) -> System:
    guide = Joint("guide", "prismatic", "world", "load", axis=X, q0=(q0,))
    return System((Body("load", MASS),), (guide,), springs=(JointSpring("spring", "guide", MASS * W * W),), gravity=0.0)


def put_aside(s, x: float = 1.0) -> None:
    """Behind the back of the guard that asks, before the run, whether steps follow what moves."""
    s.state[0] = x
    s.native.call("refresh")
    s.recorder.energy.begin(s.native.raw())


@pytest.mark.parametrize(("method", "name"), [("semi-implicit-euler", "h_max_leapfrog"), ("rk4", "h_max_rk4")])
def test_the_stability_limit_of_fixed_steps_is_that_of_theory(method, name):
    limit = C21["expected"][name]
    started(oscillator(0.0), method=method, step=limit * (1.0 - AT_LIMIT))
    with pytest.raises(KernelError, match=r"since .load. on .spring. swings at 1.32 Hz; choose at most 0.\d+ s") as e:
        started(oscillator(0.0), method=method, step=limit * (1.0 + AT_LIMIT))
    advised = float(str(e.value).split("at most ")[1].split(" s")[0])
    started(oscillator(0.0), method=method, step=advised)


def test_implicit_methods_are_stable_at_any_fixed_step():
    s = started(oscillator(0.0), method="radau5", step=2.0)
    put_aside(s)
    hand_over(s, 100 * SECOND)
    assert abs(s.state[0]) < 1e-9  # L-stable: what a step cannot follow dies out


def test_the_frequency_error_of_semi_implicit_euler_is_that_of_the_leapfrog_formula():
    """Three samples h apart give the frequency of any sampled oscillation: x+ + x- = 2 cos(w h) x."""
    s = started(oscillator(), method="semi-implicit-euler", step=H, sample_ns=round(H * 1e9))
    hand_over(s, 10 * SECOND)
    x = column(s, "joint/position")[1][:, 0]
    cosine = np.dot(x[2:] + x[:-2], x[1:-1]) / (2.0 * np.dot(x[1:-1], x[1:-1]))
    assert acos(cosine) / (W * H) - 1.0 == pytest.approx(C21["expected"]["leapfrog"], abs=FREQUENCY)


def test_the_energy_error_of_semi_implicit_euler_stays_bounded():
    """The modified energy H - (w h)/2 p q of Hairer, Lubich, Wanner, IX.1."""
    s = started(oscillator(), method="semi-implicit-euler", step=H, sample_ns=SECOND // 10)
    hand_over(s, 200 * SECOND)
    energy = column(s, "energy")[1][:, :3].sum(axis=1)
    early, late = np.ptp(energy[:1000]), np.ptp(energy[1000:])
    assert late == pytest.approx(early, rel=0.05)
    assert late < 1.01 * W * H * energy[0]


def test_the_stability_of_a_fixed_step_is_checked_again_when_a_rope_tightens():
    """A load on a slack rope has no mode at all; when the rope catches it the step is too long."""
    s = started(hung(59.9), method="rk4", step=0.5)
    with pytest.raises(KernelError, match=r"step 0.5 s at 0.143 s is too long for method 'rk4'"):
        hand_over(s, SECOND)


def test_a_gain_of_energy_by_too_long_fixed_steps_ends_the_run():
    s = started(oscillator(0.0), method="rk4", step=0.3, sample_ns=SECOND // 10)
    put_aside(s)
    at = s.program.parameters.at["spring", "spring"]
    s.P[at.start] *= 4.0  # behind the back of the guard that looks before the run
    with pytest.raises(KernelError, match=r"J were created from nothing, more than 50 %"):
        hand_over(s, 60 * SECOND)


def test_a_motion_that_is_not_finite_is_reported_at_fixed_steps():
    s = started(slider(), method="rk4", step=0.01)
    s.P[s.program.parameters.at["gravity", ""]] = np.nan
    with pytest.raises(KernelError, match=r"body 'load' at \d.\d+ s: its motion is not finite"):
        hand_over(s, SECOND)


@pytest.mark.parametrize(("method", "step", "error"), [("semi-implicit-euler", 1e-3, 2e-3), ("rk4", 0.01, 1e-6)])
@pytest.mark.large(beyond=1)
def test_the_reference_scene_runs_at_fixed_steps(method, step, error):
    """As exact as their order allows, at steps that do not depend on how time is handed over."""
    whole, parts = (started(scene(), method=method, step=step, sample_ns=SECOND // 10) for _ in range(2))
    hand_over(whole, 2 * SECOND)
    for t in range(1, 201):
        parts.run(t * SECOND // 100)
    hand_over(parts, 2 * SECOND)
    assert np.array_equal(whole.state, parts.state)
    exact = started(scene(), method="dop853", tolerance=1e-11)
    hand_over(exact, 2 * SECOND)
    n = exact.program.nq
    assert np.abs(whole.state - exact.state)[:n].max() < error
    assert whole["accepted"] == pytest.approx(2.0 / step, abs=2)


def test_an_oscillator_integrated_with_fixed_steps_is_back_at_its_start_after_one_period():
    s = started(oscillator(), method="rk4", step=2.0 * pi / W / 200.0)
    hand_over(s, round(2.0 * pi / W * SECOND))
    assert s.state[0] == pytest.approx(1.0, abs=1e-6)
