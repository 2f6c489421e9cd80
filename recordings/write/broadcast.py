"""Data topics of a recording in progress for programs that draw them: thinned, and sent only if somebody listens.

`/samples`, `/poses`, `/ropes`, `/scene` and `/log` have the same bytes as in the recording. Shapes and lines are sent
again every second, for programs that connect later.

Also the interface for observers of a run in progress, whose base class ignores everything.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Protocol

import msgspec
import numpy as np
from google.protobuf.descriptor import Descriptor  # type: ignore[import-untyped]
from google.protobuf.message import Message  # type: ignore[import-untyped]
from heavylift.recordings.format.samples import SampleLayout
from heavylift.recordings.format.viewer_messages import DrawnBox, Log, RopeLine, SceneUpdate, boxes_message, log_message
from numpy.typing import NDArray

from .sink import RowWriter


class Spectator:
    """Base class for observers of recorded data, which receive `begin`, then `event`, `ropes` and `samples`, then
    `end`; this class ignores all data."""

    def begin(
        self, run: Mapping[str, object], layout: SampleLayout, boxes: Sequence[DrawnBox], lines: Sequence[RopeLine]
    ) -> None:
        """Receive the data known at the start: facts of the run, sample columns, drawn shapes, and rope lines."""

    def event(self, t_ns: int, source: str, port: str, type: str, payload: bytes) -> None:
        """Receive an event on a port of a coupled model."""

    def ropes(self, t_ns: int, lines: Sequence[RopeLine]) -> None:
        """Receive the rope lines that are valid from now on."""

    def samples(self, times: Sequence[int], rows: NDArray[np.float64]) -> None:
        """Receive rows of samples with their simulation times [ns]."""

    def end(self, status: str, message: Mapping[str, str], peaks: Sequence[Mapping[str, object]], where: str) -> None:
        """Receive the end of the run: status, remarks, peak tensions of the ropes, path of the recording."""


class Spectators(Spectator):
    """An observer that passes all data on to several observers, in order."""

    def __init__(self, *those: Spectator) -> None:
        for method in ("begin", "event", "ropes", "samples", "end"):
            setattr(self, method, partial(_each, [getattr(one, method) for one in those]))


def _each(receivers: Sequence[Callable[..., None]], *what: object) -> None:
    for receive in receivers:
        receive(*what)


AGAIN_s = 1.0  # of the clock, after which what stands still is sent once more


class Listener(Protocol):
    """Interface of a receiver of protobuf messages that must never block the caller."""

    def announce(self, topic: str, descriptor: Descriptor) -> None:
        """Announce a topic and the type of its messages."""

    def listens(self) -> bool:
        """Return whether anyone has subscribed to a topic."""

    def put(self, topic: str, t_ns: int, data: bytes) -> None:
        """Publish a message with a simulation time [ns] on a topic."""


class Broadcast(Spectator):
    """An observer that passes at most `hz` samples per second of simulation time on to a listener."""

    def __init__(self, listener: Listener, hz: float) -> None:
        self._listener, self._every_ns, self._due = listener, round(1e9 / hz), 0
        self._rows: RowWriter | None = None
        self._boxes: bytes = b""
        self._lines: Sequence[RopeLine] = ()
        self._again = 0.0
        self._topics: list[str] = []
        self.mcap = self
        """Receiver of the messages of `RowWriter`: this object."""

    def protobuf(
        self, topic: str, message: type[Message] | Descriptor, facts: Mapping[str, object] | None = None
    ) -> int:
        """Announce a topic and its message type to the listener; return the number of the channel."""
        self._topics.append(topic)
        self._listener.announce(topic, getattr(message, "DESCRIPTOR", message))
        return len(self._topics) - 1

    def write(self, channel: int, log_ns: int, publish_ns: int, data: bytes) -> None:
        """Pass a message to the listener with the bytes that a recording would contain."""
        self._listener.put(self._topics[channel], publish_ns, data)

    def begin(
        self, run: Mapping[str, object], layout: SampleLayout, boxes: Sequence[DrawnBox], lines: Sequence[RopeLine]
    ) -> None:
        self._rows, self._lines, self._boxes = RowWriter(self, layout, 0.0), lines, boxes_message(boxes)
        self._scene, self._log = self.protobuf("/scene", SceneUpdate), self.protobuf("/log", Log)

    def event(self, t_ns: int, source: str, port: str, type: str, payload: bytes) -> None:
        if self._rows is not None and self._listener.listens():
            text = msgspec.json.encode(msgspec.msgpack.decode(payload)).decode()
            self.write(self._log, t_ns, t_ns, log_message(t_ns, "info", f"{source}.{port}", f"{type} {text}"))

    def ropes(self, t_ns: int, lines: Sequence[RopeLine]) -> None:
        self._lines, self._again = lines, 0.0

    def samples(self, times: Sequence[int], rows: NDArray[np.float64]) -> None:
        if self._rows is None or not self._listener.listens():
            return
        wanted = []
        for i, t_ns in enumerate(times):
            if t_ns >= self._due:
                self._due = t_ns + self._every_ns
                wanted.append(i)
        if not wanted:
            return
        at = [times[i] for i in wanted]
        if time.monotonic() >= self._again:
            self._again = time.monotonic() + AGAIN_s
            self.write(self._scene, at[0], at[0], self._boxes)
            if self._rows.bodies:
                self._rows.hang(self._rows.ropes(self._lines))
        self._rows.write(self._rows.encode(at, at, rows[wanted]), 0, len(at))
