"""A recording with more signals or facts beside its own: whatever stood in the old file is copied as it is.

The signals, which have times of their own in common, stand in the topic `/measured` as those of the run in `/samples`.
"""

import heapq
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.samples import SampleChannel, sample_fields
from heavylift.recordings.format.schema import samples_descriptor, samples_template
from heavylift.recordings.write.outputs import file_path, output_path
from heavylift.recordings.write.sink import Sink

from .chunks import RawMessage
from .container import Container
from .reader import BESIDE
from .signal import Signal


def extended(
    path: str | Path, out: str | Path, signals: Sequence[Signal], facts: Mapping[str, object],
    files: Mapping[str, bytes], force: bool = False,
) -> Path:  # fmt: skip
    """Write the recording `path` with these signals, further facts of its result and further files; the new path."""
    out = output_path(out)
    if out.resolve() == file_path(path).resolve():
        raise RecordingError(f"{out}: is the recording itself, which stays as it is; choose another name with -o")
    return _copied(path, out, signals, facts, files, force)


def amended(path: str | Path, facts: Mapping[str, object]) -> Path:
    """Add facts to the result of a recording; the file is replaced atomically."""
    return _copied(path, file_path(path), (), facts, {}, force=True)


def _copied(
    path: str | Path, out: Path, signals: Sequence[Signal], facts: Mapping[str, object], files: Mapping[str, bytes],
    force: bool,
) -> Path:  # fmt: skip
    old = Container(path)
    metadata, numbers = old.metadata(), dict[int, int]()
    more: Iterator[RawMessage] = iter(())
    if signals:
        fields = sample_fields([SampleChannel(s.name, s.names, s.unit, 0, len(s.names)) for s in signals])
        times = np.round(signals[0].t * 1e9).astype(np.int64).tolist()
        rows = samples_template(fields).encode(times, np.hstack([s.values for s in signals]))
        more = (RawMessage(-1, 0, t, t, row.tobytes()) for t, row in zip(times, rows, strict=True))
    sink = Sink(out, metadata["run"], {**old.attachments(), **files}, force, old.library)
    try:
        kept = [c for c in old.summary.channels.values() if not (signals and c.topic == BESIDE)]  # of an earlier log
        for channel in kept:
            schema = old.summary.schemas[channel.schema_id]
            numbers[channel.id] = sink.channel(
                channel.topic, channel.message_encoding, schema.name, schema.encoding, schema.data, channel.metadata
            )
        if signals:
            descriptor = samples_descriptor([field.field for field in fields], "Measured")
            numbers[-1] = sink.protobuf(BESIDE, descriptor, {"signals": fields})
        with sink.writing():
            for raw in heapq.merge(old.messages({c.id for c in kept}), more, key=lambda raw: raw.log_time):
                sink.mcap.write(numbers[raw.channel], raw.log_time, raw.publish_time, raw.data)
        return sink.finish({**metadata.get("result", {}), **facts})
    finally:
        sink.abandon(keep=False)
