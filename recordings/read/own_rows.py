"""Rows of one of several lifts alone, which show what events have changed in it between the samples of all."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

import msgspec
import numpy as np
from heavylift.recordings.format.samples import POSE, Field
from heavylift.recordings.format.schema import field_places, samples_template
from heavylift.recordings.format.viewer_messages import frames_template

from .container import Topic
from .decoding import Form, Rows
from .signal import Signal

__all__ = ["with_own_rows"]


def with_own_rows(
    signal: Signal, topics: Iterable[Topic], decoded: Callable[[Mapping[str, Form]], Iterator[list[Rows]]]
) -> Signal:
    """Columns of a signal, those of one lift with its own rows among those of all; at one time these come last."""
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
    """How the rows of a lift are read, and the columns of the signal there, if it has all that are asked for."""
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
