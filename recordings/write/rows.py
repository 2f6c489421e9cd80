"""Sample rows on their way into the file: a message of numbers and one of all poses per row, ropes where they moved."""

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from google.protobuf.descriptor import Descriptor  # type: ignore[import-untyped]
from google.protobuf.message import Message  # type: ignore[import-untyped]
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format import viewer_messages as viewers
from heavylift.recordings.format.samples import POSE_UNIT, REEVING, Columns, SampleLayout, reeved
from heavylift.recordings.format.schema import samples_descriptor, samples_template
from numpy.typing import NDArray


class Peak(NamedTuple):
    """Largest tension of a rope [N] and when [s]."""

    tension: float
    time: float


class RowBlock(NamedTuple):
    """Rows as in the file: simulation and log times [ns], numbers and poses, messages (n, bytes)."""

    times: list[int]
    log_ns: list[int]
    columns: NDArray[np.float64]
    samples: NDArray[np.uint8]
    frames: NDArray[np.uint8]


class Messages(Protocol):
    """Receives messages of channels, usually a recording."""

    def write(self, channel: int, log_ns: int, publish_ns: int, data: bytes) -> None: ...


class Channels(Protocol):
    """Creates channels, whose messages go to `mcap`."""

    @property
    def mcap(self) -> Messages: ...
    def protobuf(
        self, topic: str, message: type[Message] | Descriptor, facts: Mapping[str, object] | None = None
    ) -> int: ...


class RowWriter:
    """Writes the rows of one layout into the sink and keeps the peak of each rope."""

    def __init__(self, sink: Channels, layout: SampleLayout, lines_every: float, lift: str = "") -> None:
        """For all rows, or those of a single lift in topics with its name."""
        own = f"/{lift}" if lift else ""
        self.layout = layout.check()
        self.peaks: dict[str, Peak] = {}
        self._sink = sink
        self._columns = Columns(layout)
        self.bodies = self._columns.bodies
        self._ropes: viewers.Ropes | None = None
        self._lines_ns, self._lines_due = round(lines_every * 1e9), 0
        fields = self._columns.fields
        descriptor = samples_descriptor([field.field for field in fields])
        self._numbers = sink.protobuf(f"/samples{own}", descriptor, {"signals": fields})
        self._form = samples_template(fields)
        if self.bodies:
            facts = {"names": self.bodies, "unit": POSE_UNIT}
            self._poses = sink.protobuf(f"/poses{own}", viewers.FrameTransforms, facts)
            self._frames = viewers.frames_template(self.bodies)
            self._lines = 0 if lift else sink.protobuf("/ropes", viewers.SceneUpdate)

    def ropes(self, lines: Sequence[viewers.RopeLine]) -> viewers.Ropes:
        """Lines prepared for `hang`; raises RecordingError for one on a body without poses."""
        for line in lines:
            for body in (line.a_body, line.b_body):
                if body != viewers.WORLD and body not in self.bodies:
                    raise RecordingError(f"rope line on {body}: the samples have no pose of it; check the name")
        return viewers.Ropes(lines, self.bodies)

    def hang(self, ropes: viewers.Ropes) -> None:
        """Draw these ropes from the next row on."""
        self._ropes, self._lines_due = ropes, 0

    def encode(self, times: list[int], log_ns: list[int], rows: NDArray[np.float64]) -> RowBlock:
        """Rows (n, width) of these simulation and log times [ns] made ready for `write`."""
        columns = self._columns(rows)
        numbers, poses = np.split(columns, [self._columns.numbers], axis=1)
        samples = self._form.encode(times, numbers)
        frames = self._frames.encode(times, poses) if self.bodies else samples[:, :0]
        return RowBlock(times, log_ns, columns, samples, frames)

    def write(self, block: RowBlock, first: int, end: int) -> None:
        """Write the messages of these rows of a block, one row after the other."""
        drawn, write = self._drawn(block, first, end), self._sink.mcap.write
        for i in range(first, end):
            log_ns, t_ns = block.log_ns[i], block.times[i]
            write(self._numbers, log_ns, t_ns, block.samples[i].tobytes())
            if self.bodies:
                write(self._poses, log_ns, t_ns, block.frames[i].tobytes())
            if i in drawn:
                write(self._lines, log_ns, t_ns, drawn[i])

    def _drawn(self, block: RowBlock, first: int, end: int) -> dict[int, bytes]:
        """Messages of the rows at which ropes are redrawn."""
        if self._ropes is None:
            return {}
        times, poses = block.times, block.columns[:, self._columns.numbers :].reshape(len(block.times), -1, 7)
        drawn, i = [], first
        while (i := bisect_left(times, self._lines_due, i, end)) < end:
            if self._ropes.moved(poses[i]):
                drawn.append(i)
                self._lines_due = times[i] + self._lines_ns
            i += 1
        if not drawn:
            return {}
        messages = self._ropes.messages([times[i] for i in drawn], poses[drawn])
        return {i: message.tobytes() for i, message in zip(drawn, messages, strict=True)}


def note_peaks(peaks: dict[str, Peak], layout: SampleLayout, times: Sequence[int], rows: NDArray[np.float64]) -> None:
    """Update each rope's peak tension, of all accepted steps if rows have it; over sheaves of samples, of its most
    loaded part."""
    found = [x for x in (layout.find("rope/peak") or layout.find("rope/tension"), layout.find(REEVING)) if x]
    when = layout.find("rope/peak_time")
    for tension in found:
        over = tension.topic == REEVING
        values = rows[:, tension.start : tension.stop]
        for i, k in enumerate(values.argmax(axis=0).tolist()):
            name = reeved(tension.names[i]) if over else tension.names[i]
            if name not in peaks or values[k, i] > peaks[name].tension:
                at = rows[k, when.start + i] if when and not over else times[k] / 1e9
                peaks[name] = Peak(float(values[k, i]), float(at))
