"""Messages of several channels made numbers in one pass through the file, some thousand at a time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np
from heavylift.recordings.format.template import Template
from numpy.typing import NDArray

from .chunks import Table

__all__ = ["Form", "Rows", "decoded"]

BLOCK = 4096  # messages of a channel that are decoded together
Form = tuple[Template, dict[str, slice]]  # of the messages of a channel, and where signals stand in their numbers
Rows = tuple[list[int], dict[str, NDArray[np.float64]]]  # times [ns] and signals


def decoded(tables: Iterable[Table], forms: Mapping[int, Form]) -> Iterator[list[Rows]]:
    """Rows of each of these channels, as many of one as of the others while there are any."""
    waiting: dict[int, list[Table]] = {channel: [] for channel in forms}
    counts = dict.fromkeys(forms, 0)
    for table in tables:
        waiting[table.channel].append(table)
        counts[table.channel] += len(table.times)
        while min(counts.values()) >= BLOCK:
            yield [_rows(waiting[channel], *form) for channel, form in forms.items()]
            counts = {channel: n - BLOCK for channel, n in counts.items()}
    if all(counts.values()):
        yield [_rows(waiting[channel], *form) for channel, form in forms.items()]


def _rows(waiting: list[Table], form: Template, places: dict[str, slice]) -> Rows:
    """The first messages that wait."""
    times, rows = list[int](), list[NDArray[np.uint8]]()
    while waiting and len(times) < BLOCK:
        channel, t, data = waiting.pop(0)
        if len(t) > (left := BLOCK - len(times)):
            waiting.insert(0, Table(channel, t[left:], data[left:]))
        times += t[:left].tolist()
        rows.append(data[:left])
    found = form.decode(np.concatenate(rows), *places.values())  # ValueError if their lengths differ
    return times, dict(zip(places, found, strict=True))
