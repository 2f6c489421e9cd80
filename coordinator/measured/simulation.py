"""The scene of a recording, run again in this process with other inputs, as curves of the measured channels."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
from heavylift.coordinator.live.commands import operator_commands
from heavylift.coordinator.record.scene import MERGED, RESOLVED
from heavylift.coordinator.run import run
from heavylift.kernel.errors import UNREADABLE, HeavyliftError, RecordingError
from heavylift.kernel.trust import demand
from heavylift.nodes.plan.plan import decode, functions
from heavylift.nodes.scene import LoadedScene, restored
from heavylift.recordings import Recording
from numpy.typing import NDArray

from .alignment import Curve
from .mapping import Channel
from .parameters import Parameter, varied
from .validation import curves_of

__all__ = ["scene_of", "simulator"]

SAMPLES = (20.0, 100.0)  # [Hz] at least and at most, between which samples are as many as the log's rows
TIGHT = 1e-7  # tolerance at which differences of two runs are those of their inputs
Floats = NDArray[np.float64]


def scene_of(rec: Recording) -> LoadedScene:
    """The scene of a recording; RecordingError if it has none that this version can run."""
    files = rec.attachments
    name = next((name for name in files if name != RESOLVED), "")
    if not name or RESOLVED not in files:
        raise RecordingError(f"{rec.path}: holds no scene to run again; record it with `heavylift run`")
    try:
        plan = decode(files[RESOLVED])
        demand(functions(plan), f"{rec.path}")
        return restored(plan, files[name].decode(), files.get(MERGED, b"").decode(), name)
    except UNREADABLE as error:
        raise RecordingError(f"{rec.path}: this version cannot run its scene ({error}); use {rec.library}") from None


def simulator(
    rec: Recording, scene: LoadedScene, inputs: Sequence[Parameter], channels: list[Channel], rows_hz: float,
    say: Callable[[str], None],
) -> Callable[[Floats], list[Curve]]:  # fmt: skip
    """Curves of the channels for values of the inputs; HeavyliftError names the values that make no run."""
    commands = operator_commands(rec.path)
    rate = min(max(SAMPLES[0], rows_hz, scene.plan.samples_hz), max(SAMPLES[1], scene.plan.samples_hz))

    def simulate(values: Floats) -> list[Curve]:
        told = ", ".join(f"{p.name} {x / p.factor:.6g} {p.unit}".strip() for p, x in zip(inputs, values, strict=True))
        say(told)
        try:
            other = varied(scene, inputs, values.tolist())
            plan = msgspec.structs.replace(other.plan, samples_hz=rate, tolerance=min(other.plan.tolerance, TIGHT))
            with tempfile.TemporaryDirectory(prefix="heavylift-", ignore_cleanup_errors=True) as folder:
                made = Path(folder) / "run.mcap"
                run(replace(other, plan=plan), made, in_process=True, commands=commands)
                return curves_of(Recording(made), channels)
        except HeavyliftError as error:
            raise RecordingError(f"with {told} there is no run: {error}") from None

    return simulate
