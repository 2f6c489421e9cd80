"""Rows and runs written by hand, so that what follows from them is known."""

from __future__ import annotations

import numpy as np
from heavylift.coordinator.tradeoff import Row, Shown, Span


def row(how: str, seconds: float, reason: str = "", **errors: float) -> Row:
    """100 s of simulated time in so many CPU seconds; errors by quantity, `_` for a blank."""
    named = {quantity.replace("_", " "): e for quantity, e in errors.items()}
    return Row("rung", "rk4", how, named, reason, position=1e-4, simulated_s=100.0, wall_s=2.0 * seconds, cpu_s=seconds)


def swinging(frequency: float, amplitude: float, peak: float = 2e5, lift_off: float = 10.0) -> Shown:
    """A block that is lifted in 10 s and swings for 40 s."""
    t = np.arange(0.0, 50.01, 0.1)
    since = np.maximum(0.0, t - lift_off)
    y = amplitude * np.sin(2 * np.pi * frequency * since)
    places = np.column_stack([np.zeros_like(t), y, np.zeros_like(t)])
    spans = [Span("lift off", 0.0, lift_off, False, True), Span("swing", lift_off, 50.0, True, False)]
    return Shown(spans, t, ["rope"], np.full((len(t), 1), 1e5), np.array([peak]), places, ["x", "y", "z"])
