"""Figures of a run: swings and peaks come from its dense output or say by how much samples may mislead."""

from __future__ import annotations

from math import pi
from random import Random

import numpy as np
import pytest
from heavylift.coordinator.ladder import Measuring, Span, as_it_is, swing
from heavylift.coordinator.ladder.figures import figures
from heavylift.coordinator.record import play
from heavylift.nodes.plan import ASKABLE
from heavylift.nodes.scene import bundled, load, parse
from scipy.special import ellipk

START = 3.0  # [deg]
PENDULUM = """heavylift: 1
name: pendulum
samples: HZ Hz
method: METHOD
tolerance: 1e-4
end: 200 s
mechanism:
  bodies: {load: {mass: 4 t, com: [0, 0, -LENGTH m]}}
  joints: {pivot: {type: revolute, child: load, axis: [0, 1, 0], start: START deg}}
actions: [wait 200 s]
"""
FIT = 1e-5  # of a period: a swing of 3 degrees is nearly a sinusoid
READ = 0.25 * 0.01  # of an amplitude, between samples: a quarter of the accuracy
WHOLE = Span("still", 2.0, 40.0, True, False)


@pytest.mark.parametrize("seed", range(12))
def test_a_sinusoid_in_any_horizontal_direction_is_measured_with_its_amplitude_and_period(seed: int) -> None:
    r = Random(seed)
    amplitude, period, turned, phase = r.uniform(0.01, 2.0), r.uniform(2.0, 18.0), r.uniform(0, pi), r.uniform(0, 6.3)
    t = np.arange(0.0, 42.0, r.uniform(0.05, period / 20.0))
    y = amplitude * np.sin(2.0 * pi * t / period + phase)
    x = np.column_stack([3.0 + y * np.cos(turned), y * np.sin(turned) - 7.0, np.full_like(t, 5.0)])
    found = swing(t, x, WHOLE)
    assert found is not None
    assert found.period == pytest.approx(period, rel=1e-6)
    assert found.amplitude == pytest.approx(amplitude, rel=2e-3)


def test_the_reading_error_of_a_swing_bounds_the_error_due_to_coarse_samples() -> None:
    rough, fine = (play(load("pendulum", ["end=60 s", f"samples={hz}"]).plan) for hz in ("0.2 Hz", "20 Hz"))
    message, true = ({f.name: f for f in figures(run, ["swing"])} for run in (rough, fine))
    for name, f in message.items():
        if name in true:
            assert abs(f.value - true[name].value) <= max(3.0 * f.misread, 1e-3 * f.scale), name
    assert all(f.misread < 1e-3 * f.scale for f in true.values())


@pytest.mark.parametrize("seed", range(8))
def test_a_swing_faster_than_the_sample_rate_is_measured_with_the_period_and_amplitude_of_its_closed_form(
    seed: int,
) -> None:
    """Every second sample shows the same slow swing, which there is not."""
    r = Random(seed)
    length, hz, method = round(r.uniform(0.5, 40.0), 3), r.choice([0.1, 0.2, 0.5]), r.choice(["radau5", "dopri5"])
    text = PENDULUM.replace("HZ", repr(hz)).replace("METHOD", method).replace("START", repr(START))
    plan = parse(text.replace("LENGTH", repr(length)), passing=True, followed=False).plan
    look = as_it_is(plan, 0.01, measuring := Measuring(("swing",)))
    amplitude, period = measuring.figures(look.candidate).values()
    exact = 4.0 * ellipk(np.sin(0.5 * np.radians(START)) ** 2) * np.sqrt(length / plan.gravity)
    assert period.value == pytest.approx(exact, rel=look.error[period.name] + FIT)
    assert amplitude.value == pytest.approx(np.radians(START), rel=READ)
    assert max(look.error.values()) < 0.01


def test_the_stated_reading_error_of_a_utilisation_bounds_the_error_due_to_coarse_samples() -> None:
    rough, fine = (play(load("lift", ["end=60 s", f"samples={hz}"]).plan) for hz in ("0.5 Hz", "40 Hz"))
    message, true = ({f.name: f for f in figures(run, ["limits", "clearance"])} for run in (rough, fine))
    assert message.keys() == true.keys()
    for name, f in message.items():
        assert abs(f.value - true[name].value) <= 6.0 * f.misread + 1e-3 * f.scale, name
    assert any(f.misread > 1e-3 * f.scale for f in message.values()), "something is missed"


@pytest.mark.parametrize("scene", ["lift", "hall", "spreader", "snatch", "arm", "floating", "jib"])
def test_the_result_figures_of_every_crane_are_finite_and_have_distinct_names(scene: str) -> None:
    assert scene in bundled()
    found = figures(play(load(scene, ["end=12 s"]).plan), ASKABLE)
    names = [f.name for f in found]
    assert found
    assert len(set(names)) == len(names)
    assert all(np.isfinite(f.value) and f.scale > 0.0 for f in found)


def test_slings_have_result_figures_of_their_own_and_peaks_equal_those_of_the_run() -> None:
    run = play(load("lift", ["end=40 s"]).plan)
    found = {f.name.removeprefix("peak tension "): f for f in figures(run, ["rope tension", "sling tension"])}
    assert {name for name, f in found.items() if f.quantity == "rope tension"} == {f"crane.H{i}" for i in (1, 2, 3)}
    assert sum(f.quantity == "sling tension" for f in found.values()) == 6
    assert all(f.value == run.peaks[name].tension for name, f in found.items())
