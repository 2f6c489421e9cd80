"""Sample rows on their way into the file: one message per channel, all poses in one, ropes that follow their
bodies.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from heavylift.kernel.errors import RecordingError
from numpy.typing import NDArray

from .drawing import WORLD, FrameTransforms, RopeLine, Ropes, SceneUpdate, frames_template
from .samples import POSE, SampleLayout, samples_head
from .schema import Samples
from .sink import Sink

__all__ = ["Peak", "Rows"]


class Peak(NamedTuple):
    """Largest tension of a rope [N] and when [s]."""

    tension: float
    time: float


class Rows:
    """Writes the rows of one layout into the sink and keeps the peak of each rope."""

    def __init__(self, sink: Sink, layout: SampleLayout, lines_every: float) -> None:
        self.layout = layout.check()
        self.peaks: dict[str, Peak] = {}
        self._sink = sink
        self._parts: list[tuple[int, int, int, bytes]] = []  # channel, first byte, last byte, head
        for channel in layout.channels:
            if not channel.topic.startswith(POSE):
                facts = {"names": channel.names, "unit": channel.unit}
                number = sink.protobuf("/" + channel.topic, Samples, facts)
                head = samples_head(channel.stop - channel.start)
                self._parts.append((number, 8 * channel.start, 8 * channel.stop, head))
        poses = [channel for channel in layout.channels if channel.topic.startswith(POSE)]
        self.bodies = [channel.topic.removeprefix(POSE) for channel in poses]
        self._columns = np.array([np.arange(c.start, c.stop) for c in poses], np.intp).reshape(-1)
        self._ropes: Ropes | None = None
        self._lines_ns, self._lines_due = round(lines_every * 1e9), 0
        if poses:
            facts = {"names": self.bodies, "unit": "m, quaternion x y z w"}
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

    def write(self, log_ns: int, t_ns: int, row: bytes) -> None:
        """Write the messages of one row (float64 bytes)."""
        for channel, start, stop, head in self._parts:
            self._sink.write(channel, log_ns, t_ns, head + row[start:stop])
        if self.bodies:
            poses = np.frombuffer(row, "<f8")[self._columns]
            self._sink.write(self._poses, log_ns, t_ns, self._frames.encode(t_ns, poses))
            if self._ropes is not None and t_ns >= self._lines_due:
                self._lines_due = t_ns + self._lines_ns
                lines = self._ropes.message(t_ns, poses.reshape(-1, 7))
                self._sink.write(self._lines, log_ns, t_ns, lines)

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
