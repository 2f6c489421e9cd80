"""Figures of a run: swings and peaks come from its dense output or say by how much samples may mislead."""

from __future__ import annotations

from math import pi
from random import Random

import numpy as np
import pytest
from heavylift.coordinator.ladder import Span, play, swing
from heavylift.coordinator.ladder.figures import figures
from heavylift.nodes.plan import ASKABLE
from heavylift.nodes.scene import bundled, load

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


def test_samples_too_coarse_for_a_signal_are_reported() -> None:
    rough, fine = (play(load("pendulum", ["end=60 s", f"samples={hz}"]).plan) for hz in ("0.2 Hz", "20 Hz"))
    message, true = ({f.name: f for f in figures(run, ["swing"])} for run in (rough, fine))
    for name, f in message.items():
        if name in true:
            assert abs(f.value - true[name].value) <= max(3.0 * f.misread, 1e-3 * f.scale), name
    assert all(f.misread < 1e-3 * f.scale for f in true.values())


def test_a_peak_utilisation_between_two_samples_is_reported() -> None:
    rough, fine = (play(load("lift", ["end=60 s", f"samples={hz}"]).plan) for hz in ("0.5 Hz", "40 Hz"))
    message, true = ({f.name: f for f in figures(run, ["limits", "clearance"])} for run in (rough, fine))
    assert message.keys() == true.keys()
    for name, f in message.items():
        assert abs(f.value - true[name].value) <= 6.0 * f.misread + 1e-3 * f.scale, name
    assert any(f.misread > 1e-3 * f.scale for f in message.values()), "something is missed"


@pytest.mark.parametrize("scene", ["lift", "hall", "spreader", "snatch", "arm", "floating", "jib"])
def test_every_machine_has_finite_result_figures_without_duplicates(scene: str) -> None:
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
