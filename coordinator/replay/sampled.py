"""Samples of a kernel that runs again, against the recorded ones: the first recorded value that differs."""

from __future__ import annotations

import msgspec
import numpy as np
from heavylift.recordings import SampleLayout
from heavylift.recordings.format.columns import Columns
from heavylift.recordings.format.samples import POSE, decode_batch
from numpy.typing import NDArray

from .deviation import Deviation
from .recorded import RecordedRun

Floats = NDArray[np.float64]


def sample_apart(run: RecordedRun, layout: bytes, batches: list[bytes]) -> Deviation | None:
    """The first recorded sample that these batches of the kernel do not hold, of those up to their last one."""
    announced = msgspec.msgpack.decode(layout, type=SampleLayout)
    columns = Columns(announced)
    found = [x for x in (decode_batch(batch, announced) for batch in batches) if not x.lift]
    times = np.array([t for batch in found for t in batch.times], np.int64)
    rows = np.concatenate([np.zeros((0, len(columns))), *(columns(batch.rows) for batch in found)])
    first: Deviation | None = None
    for name, place in columns.signals.items():
        if name not in run.recording.signals() or name.startswith(POSE):
            continue
        signal = run.recording.signal(name)
        recorded = np.round(signal.t * 1e9).astype(np.int64)
        now = rows[:, place]
        for i in range(int(np.searchsorted(recorded, times[-1], "right")) if len(times) else 0):
            t = int(recorded[i])
            if first is not None and t >= first.t_ns:
                break
            at = now[slice(*np.searchsorted(times, (t, t + 1)))]  # one before and one after an event
            if not (at == signal.values[i]).all(axis=1).any():
                first = _apart(f"/{name}/", signal.names, t, signal.values[i], at)
                break
    return first


def _apart(topic: str, names: list[str], t_ns: int, recorded: Floats, now: Floats) -> Deviation:
    """The first column in which a recorded row is not the last one of those at its time."""
    k = int(np.flatnonzero(now[-1] != recorded)[0]) if len(now) else 0
    return Deviation(t_ns, 0, topic + names[k], float(recorded[k]), float(now[-1, k]) if len(now) else None)


def first_of(*found: Deviation | None) -> Deviation | None:
    """The earliest of some deviations."""
    return min((x for x in found if x), key=lambda x: (x.t_ns, x.microstep), default=None)
