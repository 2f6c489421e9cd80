"""Messages of several channels made numbers in one pass through the file, some thousand at a time; rows of one of
several lifts alone, which show what events have changed in it between the samples of all."""

from collections.abc import Callable, Iterable, Iterator, Mapping

import msgspec
import numpy as np
from heavylift.recordings.format.samples import POSE, Field
from heavylift.recordings.format.schema import Template, field_places, samples_template
from heavylift.recordings.format.viewer_messages import frames_template
from numpy.typing import NDArray

from .chunks import MessageTable
from .container import FileChannel
from .signal import Signal

BLOCK = 4096  # messages of a channel that are decoded together
Form = tuple[Template, dict[str, slice]]  # of the messages of a channel, and where signals stand in their numbers
Rows = tuple[list[int], dict[str, NDArray[np.float64]]]  # times [ns] and signals


def decoded(tables: Iterable[MessageTable], forms: Mapping[int, Form]) -> Iterator[list[Rows]]:
    """Rows of these channels in equal numbers."""
    waiting: dict[int, list[MessageTable]] = {channel: [] for channel in forms}
    counts = dict.fromkeys(forms, 0)
    for table in tables:
        waiting[table.channel].append(table)
        counts[table.channel] += len(table.times)
        while min(counts.values()) >= BLOCK:
            yield [_rows(waiting[channel], *form) for channel, form in forms.items()]
            counts = {channel: n - BLOCK for channel, n in counts.items()}
    if all(counts.values()):
        yield [_rows(waiting[channel], *form) for channel, form in forms.items()]


def _rows(waiting: list[MessageTable], form: Template, places: dict[str, slice]) -> Rows:
    """The first messages that wait."""
    times, rows = list[int](), list[NDArray[np.uint8]]()
    while waiting and len(times) < BLOCK:
        channel, t, data = waiting.pop(0)
        if len(t) > (left := BLOCK - len(times)):
            waiting.insert(0, MessageTable(channel, t[left:], data[left:]))
        times += t[:left].tolist()
        rows.append(data[:left])
    found = form.decode(np.concatenate(rows), *places.values())  # ValueError if their lengths differ
    return times, dict(zip(places, found, strict=True))


def with_own_rows(
    signal: Signal, topics: Iterable[FileChannel], decoded: Callable[[Mapping[str, Form]], Iterator[list[Rows]]]
) -> Signal:
    """Columns of a signal, with additional rows of single lifts merged; these come last at equal times."""
    for topic in topics:
        found = _form(topic.name, topic.metadata, signal)
        if found is None:
            continue
        form, columns = found
        parts = [part for (part,) in decoded({topic.name: form})]
        t = np.array([x for times, _ in parts for x in times], np.float64) / 1e9
        own = np.concatenate([np.zeros((0, len(columns))), *(values[signal.name] for _, values in parts)])
        picked = own[:, [columns.index(name) for name in signal.names]]
        order = np.argsort(np.concatenate([signal.t, t]), kind="stable")
        values = np.concatenate([signal.values, picked])[order]
        return Signal(np.concatenate([signal.t, t])[order], values, signal.names, signal.unit, signal.name)
    return signal


def _form(topic: str, facts: dict[str, str], signal: Signal) -> tuple[Form, list[str]] | None:
    """Format of the rows of a lift, and its columns of the signal, if complete."""
    if topic.startswith("/samples/"):
        fields = msgspec.json.decode(facts["signals"], type=list[Field])
        columns = next((x.columns for x in fields if x.signal == signal.name), [])
        if columns and {*signal.names} <= {*columns}:
            return (samples_template(fields), {signal.name: field_places(fields)[signal.name]}), columns
    if topic.startswith("/poses/") and signal.name.startswith(POSE):
        bodies = msgspec.json.decode(facts["names"], type=list[str])
        if (body := signal.name.removeprefix(POSE)) in bodies:
            at = 7 * bodies.index(body)
            return (frames_template(bodies), {signal.name: slice(at, at + 7)}), ["x", "y", "z", "qx", "qy", "qz", "qw"]
    return None
