"""The scene of a recording, run again in this process with other inputs, as curves of the measured channels."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
from heavylift.coordinator.run import run
from heavylift.coordinator.run.resume import Beginning
from heavylift.kernel.errors import HeavyliftError, RecordingError
from heavylift.recordings import Recording
from numpy.typing import NDArray

from .alignment import Curve
from .mapping import Channel
from .parameters import Parameter, varied
from .validation import curves_of

__all__ = ["simulator", "spread"]

SAMPLES = (20.0, 100.0)  # [Hz] at least and at most, between which samples are as many as the log's rows
TIGHT = 1e-7  # tolerance at which differences of two runs are those of their inputs
Floats = NDArray[np.float64]
Simulate = Callable[[Floats], list[Curve]]


def simulator(
    begun: Beginning, inputs: Sequence[Parameter], channels: list[Channel], rows_hz: float, say: Callable[[str], None]
) -> Simulate:
    """Curves of the channels for values of the inputs; HeavyliftError names the values that make no run."""
    hz = begun.scene.plan.samples_hz
    rate = min(max(SAMPLES[0], rows_hz, hz), max(SAMPLES[1], hz))

    def simulate(values: Floats) -> list[Curve]:
        given = ", ".join(f"{p.name} {x / p.factor:.6g} {p.unit}".strip() for p, x in zip(inputs, values, strict=True))
        say(given)
        try:
            other = varied(begun.scene, inputs, values.tolist())
            plan = msgspec.structs.replace(other.plan, samples_hz=rate, tolerance=min(other.plan.tolerance, TIGHT))
            with tempfile.TemporaryDirectory(prefix="heavylift-", ignore_cleanup_errors=True) as folder:
                made = Path(folder) / "run.mcap"
                run(replace(other, plan=plan), made, in_process=True, commands=begun.commands)
                return curves_of(Recording(made), channels)
        except HeavyliftError as error:
            raise RecordingError(f"with {given} there is no run: {error}") from None

    return simulate


def spread(simulate: Simulate, values: Floats, sigma: Floats, own: Sequence[Curve]) -> list[Floats]:
    """Standard uncertainty of each curve, at the times of the run's own, from that of the inputs."""
    squares = [np.zeros(len(T)) for T, _ in own]
    for step in np.diag(sigma):
        pairs = zip(simulate(values + step), simulate(values - step), strict=True)
        for square, (T, _), (up, down) in zip(squares, own, pairs, strict=True):
            square += (0.5 * (np.interp(T, *up) - np.interp(T, *down))) ** 2
    return [np.sqrt(square) for square in squares]
