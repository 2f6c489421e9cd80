"""What the ports of a DEVS run said, as numbers over time and as a table: such a recording has events and no samples.

`station/left` is a signal with a column for each number in its messages, such as `number` or `job.born`; of messages
without any it is their `count` so far.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
from math import nan

import msgspec
import numpy as np
from heavylift.kernel.errors import SignalError
from heavylift.recordings.format.schema import RecordedEvent
from heavylift.recordings.format.text import meant

from .reader import Recording
from .signal import Signal

HEAD = ["time [s]", "microstep", "model", "port", "index", "type"]


def silent(rec: Recording) -> bool:
    """Whether it has no samples, only what was said."""
    return "model" in rec.run and not rec.signals()


def said(rec: Recording, patterns: Sequence[str] = ()) -> list[Signal]:
    """A signal for each port that has spoken, with the columns that match one of the patterns (all without one)."""
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
    """Heads and rows of a table of all events in total order, a column for each field; those of ports that match."""
    names = {x.name: x.names for x in said(rec, patterns)} if patterns else {}
    fields: dict[str, None] = {}
    kept: list[tuple[RecordedEvent, dict[str, object]]] = []
    for e in rec.events():
        if not patterns or f"{e.source}/{e.port}" in names:
            wanted = names.get(f"{e.source}/{e.port}", ())
            parts = {name: x for name, x in _flat(e.value) if not patterns or name in wanted or wanted == ["count"]}
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


def _flat(value: object, name: str = "") -> Iterator[tuple[str, object]]:
    """The fields of a message; those of messages in it, and values by their names, with a dot; other tuples as JSON."""
    if value and isinstance(value, list) and all(isinstance(x, list) and len(x) == 2 for x in value):
        value = dict(value) if all(isinstance(name, str) for name, _ in value) else value
    if isinstance(value, dict):
        for key, x in value.items():
            yield from _flat(x, f"{name}.{key}" if name else str(key))
    else:
        yield name, msgspec.json.encode(value).decode() if isinstance(value, list) else value
