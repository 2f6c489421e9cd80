"""Reading a finished recording: facts, events in order, signals as arrays.

    rec = Recording("turnover.mcap")
    t, tension, names, unit = rec.signal("rope/tension")     # s, (n, m), ["west.H1", ...], "N"

`pose/<body>` is read back from the frame transforms, every other signal from its own channel.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from .container import Container, Raw
from .drawing import FrameTransforms, Rig
from .samples import POSE, POSE_COLUMNS, samples_head

__all__ = ["RecordedEvent", "Recording", "Signal", "Topic"]


class Topic(NamedTuple):
    """A channel of the file: topic, schema name, message encoding, its metadata, number of messages."""

    name: str
    schema: str
    encoding: str
    metadata: dict[str, str]
    messages: int


class RecordedEvent(msgspec.Struct, frozen=True):
    """An event on a port of a coupled model; `value` is its message as plain data."""

    t_ns: int
    microstep: int
    source: str
    port: str
    index: int
    type: str
    value: Any


class Signal(NamedTuple):
    """Simulation times (n,) [s], values (n, m), the names of the m columns and their unit."""

    t: NDArray[np.float64]
    values: NDArray[np.float64]
    names: list[str]
    unit: str


class Recording:
    """A finished recording; opening one that is missing, cut off, damaged or foreign is a RecordingError."""

    def __init__(self, path: str | Path) -> None:
        self._file = Container(path)
        self.path = self._file.path
        self.size = self._file.size  # [bytes]
        self.library = self._file.library
        metadata = self._file.metadata()
        if "run" not in metadata:
            raise self._file.error("is an MCAP file of another program; give a file made by `heavylift run`")
        self.run = metadata["run"]
        self.result = metadata.get("result", {})
        self.attachments = self._file.attachments()
        with self._file.reading():
            summary = self._file.summary
            self._channels = {channel.topic: channel.id for channel in summary.channels.values()}
            self.topics = {
                channel.topic: Topic(
                    channel.topic,
                    summary.schemas[channel.schema_id].name,
                    channel.message_encoding,
                    dict(channel.metadata),
                    self._file.counts.get(channel.id, 0),
                )
                for channel in summary.channels.values()
            }

    def fact(self, name: str, default: Any = None) -> Any:
        """A fact of `result` or else of `run`, read as JSON where it is JSON, else as text."""
        text = self.result.get(name, self.run.get(name))
        if text is None:
            return default
        try:
            return msgspec.json.decode(text)
        except msgspec.DecodeError:
            return text

    def messages(self, *topics: str) -> Iterator[Raw]:
        """The undecoded messages of these topics in the order of the file."""
        return self._file.messages({self._channels[topic] for topic in topics if topic in self._channels})

    def stream(self, *topics: str) -> Iterator[tuple[str, Raw]]:
        """The same with the topic of each message."""
        names = {number: topic for topic, number in self._channels.items()}
        return ((names[raw.channel], raw) for raw in self.messages(*topics))

    def reading(self) -> AbstractContextManager[None]:
        """Context that turns whatever goes wrong in decoding into a sentence about this file."""
        return self._file.reading()

    def events(self, source: str | None = None, port: str | None = None) -> list[RecordedEvent]:
        """All events in total order, or those of one model or port name."""
        wanted = [
            topic.name
            for topic in self.topics.values()
            if "port" in topic.metadata
            and source in (None, topic.metadata.get("model"))
            and port in (None, topic.metadata["port"])
        ]
        decode = msgspec.json.Decoder(RecordedEvent).decode
        with self._file.reading():
            found = [decode(raw.data) for raw in self.messages(*wanted)]
        return sorted(found, key=lambda e: (e.t_ns, e.microstep, e.source, e.port, e.index))

    def rigs(self) -> list[Rig]:
        """Which rope lines hang from when on."""
        with self._file.reading():
            return [msgspec.json.decode(raw.data, type=Rig) for raw in self.messages("/rig")]

    def signals(self) -> list[str]:
        """The names that `signal` knows."""
        names = [topic.name.removeprefix("/") for topic in self.topics.values() if topic.schema == "heavylift.Samples"]
        bodies = self._names(self.topics["/poses"]) if "/poses" in self.topics else []
        return names + [POSE + body for body in bodies]

    def columns(self, name: str) -> list[str]:
        """Names of the columns of a signal."""
        return list(POSE_COLUMNS) if name.startswith(POSE) else self._names(self.topics["/" + name])

    def signal(self, name: str) -> Signal:
        """A sampled signal such as "rope/tension", over the whole run."""
        if name not in self.signals():
            raise self._file.error(f"has no signal {name}; it has {', '.join(self.signals()) or 'none'}")
        if name.startswith(POSE):
            return self._pose(name.removeprefix(POSE))
        topic = self.topics["/" + name]
        names = self._names(topic)
        head = samples_head(len(names))
        length = len(head) + 8 * len(names)
        found = self._sampled[topic.name]
        if any(len(raw.data) != length or not raw.data.startswith(head) for raw in found):
            raise self._file.error(f"is damaged (a sample of {name} has not {len(names)} values); run the scene again")
        values = np.frombuffer(b"".join(raw.data[len(head) :] for raw in found), "<f8")
        return Signal(_seconds(found), values.reshape(len(found), len(names)), names, topic.metadata.get("unit", ""))

    @cached_property
    def _sampled(self) -> dict[str, list[Raw]]:
        """The messages of all sample channels, read once: they stand in the same chunks."""
        topics = [t.name for t in self.topics.values() if t.schema == "heavylift.Samples" or t.name == "/poses"]
        names = {self._channels[name]: name for name in topics}
        found: dict[str, list[Raw]] = {name: [] for name in topics}
        for raw in self.messages(*topics):
            found[names[raw.channel]].append(raw)
        return found

    def _names(self, topic: Topic) -> list[str]:
        with self._file.reading():
            return msgspec.json.decode(topic.metadata["names"], type=list[str])

    def _pose(self, body: str) -> Signal:
        bodies = self._names(self.topics["/poses"])
        t, poses = self._poses
        return Signal(t, poses[:, bodies.index(body)], list(POSE_COLUMNS), "m, quaternion x y z w")

    @cached_property
    def _poses(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Times (n,) [s] and poses (n, bodies, 7); decoded once, since all bodies stand in one message."""
        found = self._sampled["/poses"]
        values = np.empty((len(found), len(self._names(self.topics["/poses"])), len(POSE_COLUMNS)))
        with self._file.reading():
            for row, raw in zip(values, found, strict=True):
                frames = FrameTransforms.FromString(raw.data).transforms
                places = [(x.translation, x.rotation) for x in frames]
                row[:] = [(p.x, p.y, p.z, q.x, q.y, q.z, q.w) for p, q in places]
        return _seconds(found), values


def _seconds(found: list[Raw]) -> NDArray[np.float64]:
    return np.array([raw.publish_time for raw in found], np.float64) / 1e9
