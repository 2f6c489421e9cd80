"""The samples of a recording as one table for other programs: CSV, or Parquet if pyarrow is installed.

The first column is the time in seconds; every other column is named `signal/column [unit]`. Numbers are written with
all digits, so nothing is lost. A DEVS run without samples is exported as a table of its events.

Also the values sent on the ports of a DEVS run, as numbers over time and as a table: `station/left` is a signal with a
column for each number in its messages, such as `number` or `job.born`; for messages without numbers it is the `count`
of messages so far.

Also copies of a recording with additional signals or facts: everything in the old file is copied unchanged. The
additional signals have common times of their own and are in the topic `/measured`, as those of the run are in
`/samples`.
"""

import csv
import heapq
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from math import nan
from pathlib import Path
from typing import Any, BinaryIO

import msgspec
import numpy as np
from heavylift.kernel.errors import RecordingError, SignalError, extra
from heavylift.recordings.format.samples import SampleChannel, sample_fields
from heavylift.recordings.format.schema import RecordedEvent, samples_descriptor, samples_template
from heavylift.recordings.format.text import GENERATOR, cell, meant
from heavylift.recordings.write.outputs import file_path, output_path
from heavylift.recordings.write.partfile import PartFile
from heavylift.recordings.write.sink import RecordingSink
from numpy.typing import NDArray

from .chunks import RawMessage
from .container import Container
from .reader import BESIDE, Recording
from .signal import Signal, chosen, titles

HEAD = ["time [s]", "microstep", "model", "port", "index", "type"]


def silent(rec: Recording) -> bool:
    """Return whether a recording contains only events and no samples."""
    return "model" in rec.run and not rec.signals()


def port_signals(rec: Recording, patterns: Sequence[str] = ()) -> list[Signal]:
    """Return one signal for each port that sent outputs, with the columns that match a pattern (default: all)."""
    found = [_signal(name, events) for name, events in _ports(rec).items()]
    chosen = {id(x): [c for c in x.names if _fits(x.name, c, patterns)] for x in found}
    for pattern in patterns:
        if not any(_fits(x.name, c, [pattern]) for x in found for c in x.names):
            raise SignalError(f"{rec.path}: no port matches '{pattern}'; {meant(pattern, [x.name for x in found])}")
    return [
        Signal(x.t, x.values[:, [x.names.index(c) for c in chosen[id(x)]]], chosen[id(x)], x.unit, x.name)
        for x in found
        if chosen[id(x)]
    ]


def log(rec: Recording, patterns: Sequence[str] = ()) -> tuple[list[str], list[list[object]]]:
    """Return a table of the events on matching ports: header, and rows with a column for each message field."""
    names = {x.name: x.names for x in port_signals(rec, patterns)} if patterns else {}
    fields: dict[str, None] = {}
    kept: list[tuple[RecordedEvent, dict[str, object]]] = []
    for e in rec.events():
        if not patterns or f"{e.source}/{e.port}" in names:
            wanted = [column.partition("[")[0] for column in names.get(f"{e.source}/{e.port}", ())]
            parts = {name: x for name, x in _flat(e.value) if not patterns or name in wanted or wanted == ["count"]}
            parts = {name: msgspec.json.encode(x).decode() if isinstance(x, list) else x for name, x in parts.items()}
            fields |= dict.fromkeys(parts)
            kept.append((e, parts))
    rows = [
        [e.t_ns / 1e9, e.microstep, e.source, e.port, e.index, e.type, *(parts.get(field) for field in fields)]
        for e, parts in kept
    ]
    return [*HEAD, *fields], rows


def _fits(name: str, column: str, patterns: Sequence[str]) -> bool:
    return not patterns or any(name == p or fnmatchcase(f"{name}/{column}", p) for p in patterns)


def _ports(rec: Recording) -> dict[str, list[RecordedEvent]]:
    found: dict[str, list[RecordedEvent]] = {}
    for e in rec.events():
        found.setdefault(f"{e.source}/{e.port}", []).append(e)
    return dict(sorted(found.items()))


def _signal(name: str, events: list[RecordedEvent]) -> Signal:
    rows = [dict(_numbers(e.value)) for e in events]
    columns = list(dict.fromkeys(column for row in rows for column in row))
    values = np.array([[row.get(column, nan) for column in columns] for row in rows])
    if not columns:
        columns, values = ["count"], np.arange(1.0, len(events) + 1.0)[:, None]
    return Signal(np.array([e.t_ns for e in events]) / 1e9, values, columns, "", name)


def _numbers(value: object) -> Iterator[tuple[str, float]]:
    for name, x in _flat(value):
        if isinstance(x, int | float):
            yield name, float(x)
        elif x is None:  # not a number, or nothing
            yield name, nan
        elif isinstance(x, list) and all(isinstance(each, int | float) for each in x):
            yield from ((f"{name}[{i}]", float(each)) for i, each in enumerate(x))


def _flat(value: object, name: str = "") -> Iterator[tuple[str, object]]:
    """Yield the fields of a message; names of nested fields are joined by dots."""
    if value and isinstance(value, list) and all(isinstance(x, list) and len(x) == 2 for x in value):
        value = dict(value) if all(isinstance(name, str) for name, _ in value) else value
    if isinstance(value, dict):
        for key, x in value.items():
            yield from _flat(x, f"{name}.{key}" if name else str(key))
    else:
        yield name, value


Tables = Iterator[list[NDArray[np.float64]]]  # times and columns, a few thousand rows at a time


def export(path: str | Path, out: str | Path, patterns: Sequence[str] = (), force: bool = False) -> Path:
    """Write the signals whose `signal/column` matches one of the patterns (default: all) to a .csv or .parquet file;
    return the path of the file."""
    out = output_path(out, "a table", (".csv", ".parquet"))
    rec = Recording(path)
    if silent(rec):
        with rec.reading():
            heads, rows = log(rec, patterns)
        with PartFile(out, "a table", (".csv", ".parquet"), force) as file, file.writing():
            (_csv_rows if out.suffix.lower() == ".csv" else _parquet_rows)(file.stream, heads, rows)
        return file.path
    wanted = matching(rec, patterns)
    names = list(dict.fromkeys(name for name, _ in wanted))
    places = [(names.index(name), rec.columns(name).index(column)) for name, column in wanted]
    none = np.zeros((0, 1))
    signals = [Signal(none[:, 0], none, [column], rec.unit(name), name) for name, column in wanted]
    heads = ["time [s]", *(f"{signal.name}/{titles(signal)[0]}" for signal in signals)]
    tables = ([np.array(times) / 1e9, *(values[i][:, k] for i, k in places)] for times, values in rec.blocks(names))
    write = _csv if out.suffix.lower() == ".csv" else _parquet
    with rec.reading(), PartFile(out, "a table", (".csv", ".parquet"), force) as file, file.writing():
        write(file.stream, heads, tables)
    return file.path


def _csv(stream: BinaryIO, heads: list[str], tables: Tables) -> None:
    rows = (row for columns in tables for row in zip(*(x.tolist() for x in columns), strict=True))
    _csv_rows(stream, heads, rows)


def _csv_rows(stream: BinaryIO, heads: list[str], rows: Iterable[Sequence[object]]) -> None:
    text = io.TextIOWrapper(stream, "utf-8", newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(cell, heads))
    writer.writerows(map(cell, row) for row in rows)
    text.detach()


def _arrow() -> tuple[Any, Any]:
    missing = RecordingError("Parquet needs pyarrow; install heavylift[parquet] or write a .csv")
    return extra("pyarrow", missing), extra("pyarrow.parquet", missing)


def _parquet_rows(stream: BinaryIO, heads: list[str], rows: list[list[object]]) -> None:
    pyarrow, parquet = _arrow()
    columns = [[row[i] for row in rows] for i in range(len(heads))]
    table = pyarrow.table([pyarrow.array(_alike(x)) for x in columns], names=heads)
    parquet.write_table(table.replace_schema_metadata({"made by": GENERATOR}), stream)


def _alike(column: list[object]) -> list[object]:
    """Return a column with all values converted to one type, since fields with the same name may have different types
    in different messages."""
    kinds = {type(x) for x in column if x is not None}
    return column if len(kinds) < 2 or kinds == {int, float} else [None if x is None else str(x) for x in column]


def _parquet(stream: BinaryIO, heads: list[str], tables: Tables) -> None:
    pyarrow, parquet = _arrow()
    schema = pyarrow.schema([(head, pyarrow.float64()) for head in heads], metadata={"made by": GENERATOR})
    with parquet.ParquetWriter(stream, schema) as writer:
        for columns in tables:
            writer.write_table(pyarrow.table(columns, schema=schema))


def matching(rec: Recording, patterns: Sequence[str]) -> list[tuple[str, str]]:
    """Return the pairs (signal, column) that match a pattern (default: all), in the order of the recording."""
    every = chosen(rec, "*")
    wanted: set[tuple[str, str]] = set()
    for pattern in patterns:
        found = chosen(rec, pattern)
        if not found:
            raise SignalError(f"{rec.path}: no signal matches '{pattern}'; {meant(pattern, rec.signals())}")
        wanted |= set(found)
    return [pair for pair in every if not patterns or pair in wanted]


def extended(
    path: str | Path, out: str | Path, signals: Sequence[Signal], facts: Mapping[str, object],
    files: Mapping[str, bytes], force: bool = False,
) -> Path:  # fmt: skip
    """Write a copy of a recording with these signals, facts and files added; return the path of the copy."""
    out = output_path(out)
    if out.resolve() == file_path(path).resolve():
        raise RecordingError(
            f"{out}: this is the recording itself, which will not be overwritten; choose another name with -o"
        )
    return _copied(path, out, signals, facts, files, force)


def amended(path: str | Path, facts: Mapping[str, object]) -> Path:
    """Add facts to the result of a recording by replacing the file atomically; return the path of the file."""
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
    sink = RecordingSink(out, metadata["run"], {**old.attachments(), **files}, force, old.library)
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
