"""A small recorded run of two ropes that take a load over, and logs as a yard's logger would write them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec
import numpy as np
from heavylift.recordings import Recorder, SampleChannel, SampleLayout

ROPES = ["west.H1", "west.H2"]
TIMES = np.arange(0.0, 40.0, 0.05)


def tension(t: np.ndarray, weight: float, share: float, start: float = 8.0) -> np.ndarray:
    """(n, 2) [N]: a ramp of four seconds, and a swing that fades."""
    load = weight * np.clip((t - start) / 4.0, 0.0, 1.0)
    swing = np.where(t > start + 4.0, np.exp(-0.1 * (t - start - 4.0)) * np.sin(1.3 * (t - start - 4.0)), 0.0)
    load = load + 0.02 * weight * swing
    return np.column_stack([share * load, (1.0 - share) * load])


def recorded(path: Path, t: np.ndarray = TIMES) -> Path:
    """A recording of a load of 1 MN, more of it on the first rope."""
    layout = SampleLayout([SampleChannel("rope/tension", ROPES, "N", 0, 2)])
    rows = tension(t, 1e6, 0.6)
    with Recorder(path, {"scene": "small", "tolerance": "1e-06"}) as recorder:
        recorder.layout(layout)
        times = [round(x * 1e9) for x in t]
        recorder.samples(msgspec.msgpack.encode([0, times, rows.astype("<f8").tobytes()]))
        recorder.settle(times[-1])
    return path


def log(path: Path, columns: Mapping[str, Sequence[object]]) -> Path:
    """A CSV file with these columns."""
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(map(str, row)) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path
