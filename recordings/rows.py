"""Sample rows on their way into the file: a message of numbers and one of all poses per row, ropes where they moved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from heavylift.kernel.errors import RecordingError
from numpy.typing import NDArray

from .columns import Columns
from .drawing import WORLD, FrameTransforms, RopeLine, Ropes, SceneUpdate, frames_template
from .samples import POSE_UNIT, SampleLayout, SamplesForm
from .schema import samples_descriptor
from .sink import Sink

__all__ = ["Peak", "Row", "Rows"]


class Peak(NamedTuple):
    """Largest tension of a rope [N] and when [s]."""

    tension: float
    time: float


class Row(NamedTuple):
    """A row as it stands in the file: simulation time [ns], numbers and poses, two messages, poses (bodies, 7)."""

    t_ns: int
    columns: NDArray[np.float64]
    samples: bytes
    frames: bytes
    poses: NDArray[np.float64]


class Rows:
    """Writes the rows of one layout into the sink and keeps the peak of each rope."""

    def __init__(self, sink: Sink, layout: SampleLayout, lines_every: float) -> None:
        self.layout = layout.check()
        self.peaks: dict[str, Peak] = {}
        self._sink = sink
        self._columns = Columns(layout)
        self.bodies = self._columns.bodies
        self._ropes: Ropes | None = None
        self._lines_ns, self._lines_due = round(lines_every * 1e9), 0
        fields = self._columns.fields
        descriptor = samples_descriptor([field.field for field in fields])
        self._numbers = sink.protobuf("/samples", descriptor, {"signals": fields})
        self._form = SamplesForm(fields)
        if self.bodies:
            facts = {"names": self.bodies, "unit": POSE_UNIT}
            self._poses = sink.protobuf("/poses", FrameTransforms, facts)
            self._frames = frames_template(self.bodies)
            self._lines = sink.protobuf("/ropes", SceneUpdate)

    def ropes(self, lines: Sequence[RopeLine]) -> Ropes:
        """These lines, ready for `hang`; RecordingError if one is on a body that has no poses."""
        for line in lines:
            for body in (line.a_body, line.b_body):
                if body != WORLD and body not in self.bodies:
                    raise RecordingError(f"rope line on {body}: the samples have no pose of it; check the name")
        return Ropes(lines, self.bodies)

    def hang(self, ropes: Ropes) -> None:
        """Draw these ropes from the next row on."""
        self._ropes, self._lines_due = ropes, 0

    def encode(self, times: Sequence[int], rows: NDArray[np.float64]) -> list[Row]:
        """Rows (n, width) of these simulation times [ns] made ready for `write`."""
        columns = self._columns(rows)
        numbers, poses = np.split(columns, [self._columns.numbers], axis=1)
        frames = self._frames.encode(times, poses) if self.bodies else [b""] * len(times)
        ready = zip(times, columns, self._form.encode(numbers), frames, poses.reshape(len(times), -1, 7), strict=True)
        return [Row(*row) for row in ready]

    def write(self, log_ns: int, row: Row) -> None:
        """Write the messages of one row."""
        self._sink.write(self._numbers, log_ns, row.t_ns, row.samples, more=bool(self.bodies))
        if self.bodies:
            self._sink.write(self._poses, log_ns, row.t_ns, row.frames)
            if self._ropes is not None and row.t_ns >= self._lines_due and self._ropes.moved(row.poses):
                self._lines_due = row.t_ns + self._lines_ns
                self._sink.write(self._lines, log_ns, row.t_ns, self._ropes.message(row.t_ns, row.poses))

    def note_peaks(self, times: Sequence[int], rows: NDArray[np.float64]) -> None:
        """Keep each rope's largest tension, of all accepted steps if the rows have them."""
        tension = self.layout.find("rope/peak") or self.layout.find("rope/tension")
        when = self.layout.find("rope/peak_time")
        if tension is None:
            return
        values = rows[:, tension.start : tension.stop]
        for i, k in enumerate(values.argmax(axis=0).tolist()):
            name = tension.names[i]
            if name not in self.peaks or values[k, i] > self.peaks[name].tension:
                at = rows[k, when.start + i] if when else times[k] / 1e9
                self.peaks[name] = Peak(float(values[k, i]), float(at))
