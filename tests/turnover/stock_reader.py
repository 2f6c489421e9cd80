"""Reads a recording with the stock `mcap` and `protobuf` libraries and nothing of heavylift.

Whatever it needs to know stands in the file: schemas with the channels, column names in the channels' metadata, the
scene in the attachment `resolved.json`.  SI units; times in seconds of the simulation; one row per sample.
"""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from mcap.reader import make_reader

Array = np.ndarray
SAMPLES, FRAMES = "heavylift.Samples", "foxglove.FrameTransforms"


class Reading:
    """`t` (n,), `values[signal]` (n, m) with `names[signal]`, `pose[body]` (n, 7), `events` in total order, `scene`."""

    def __init__(self, path: Path) -> None:
        with path.open("rb") as stream:
            reader = make_reader(stream)
            summary = reader.get_summary()
            assert summary is not None
            channels, schemas = summary.channels, summary.schemas
            topics = [
                c.topic for c in channels.values() if not c.topic.startswith("/protocol/") and c.topic != "/ropes"
            ]
            decode = {i: _decoder(s.name, s.data) for i, s in schemas.items() if s.encoding == "protobuf"}
            rows: dict[str, list[Any]] = defaultdict(list)
            times: dict[str, list[int]] = defaultdict(list)
            events = []
            for schema, channel, message in reader.iter_messages(topics=topics, log_time_order=False):
                assert schema is not None
                if "port" in channel.metadata:
                    events.append(json.loads(message.data))
                    assert message.log_time == events[-1]["t_ns"]
                elif schema.name in (SAMPLES, FRAMES):
                    rows[channel.topic].append(decode[schema.id](message.data))
                    times[channel.topic].append(message.log_time)
            self.metadata = {m.name: dict(m.metadata) for m in reader.iter_metadata()}
            self.attachments = {a.name: a.data for a in reader.iter_attachments()}
        self.scene: dict[str, Any] = json.loads(self.attachments["resolved.json"])
        self.events = sorted(events, key=lambda e: (e["t_ns"], e["microstep"], e["source"], e["port"], e["index"]))
        facts = {c.topic: c.metadata for c in channels.values()}
        signals = json.loads(facts["/samples"]["signals"])
        names = {"/poses": json.loads(facts["/poses"]["names"])}
        names |= {"/" + signal["signal"]: signal["columns"] for signal in signals}
        self.t_ns: list[int] = times["/poses"]
        assert all(other == self.t_ns for other in times.values()), "all topics hold the same samples"
        self.t = np.array(self.t_ns) * 1e-9
        self.values: dict[str, Array] = {
            "/" + s["signal"]: np.array([list(getattr(m, s["field"])) for m in rows["/samples"]]) for s in signals
        }
        self.names: dict[str, list[str]] = names
        poses = np.array([[_seven(x) for x in m.transforms] for m in rows["/poses"]]).reshape(
            -1, len(names["/poses"]), 7
        )
        self.pose: dict[str, Array] = {body: poses[:, i] for i, body in enumerate(names["/poses"])}

    def column(self, signal: str, name: str) -> Array:
        """(n,) the column of this name."""
        return self.values[signal][:, self.names[signal].index(name)]

    def said(self, source: str, port: str, kind: str | None = None) -> list[dict[str, Any]]:
        """Events of a port, perhaps of one type only."""
        found = [e for e in self.events if e["source"] == source and e["port"] == port]
        return [e for e in found if kind in (None, e["type"])]


def _decoder(name: str, descriptor: bytes) -> Any:
    """The parser of a message type, made from the descriptor that stands in the file."""
    pool = DescriptorPool()
    for file in FileDescriptorSet.FromString(descriptor).file:
        pool.Add(file)
    return GetMessageClass(pool.FindMessageTypeByName(name)).FromString


def _seven(x: Any) -> tuple[float, ...]:
    p, q = x.translation, x.rotation
    return p.x, p.y, p.z, q.x, q.y, q.z, q.w
