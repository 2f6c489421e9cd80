"""Messages of several topics made numbers in one pass through the file, some thousand at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from heavylift.recordings.format.template import Template
from numpy.typing import NDArray

from .container import Raw

__all__ = ["Form", "Rows", "decoded"]

BLOCK = 4096  # messages of a topic that are decoded together
Form = tuple[Template, dict[str, slice]]  # of the messages of a topic, and where signals stand in their numbers
Rows = tuple[list[int], dict[str, NDArray[np.float64]]]  # times [ns] and signals


def decoded(stream: Callable[..., Iterator[tuple[str, Raw]]], forms: Mapping[str, Form]) -> Iterator[list[Rows]]:
    """Rows of each of these topics, as many of one as of the others while there are any."""
    waiting: dict[str, list[Raw]] = {topic: [] for topic in forms}
    for topic, raw in stream(*forms):
        waiting[topic].append(raw)
        if len(waiting[topic]) >= BLOCK and all(len(some) >= BLOCK for some in waiting.values()):
            yield [_rows(waiting[topic], *form) for topic, form in forms.items()]
    if all(waiting.values()):
        yield [_rows(waiting[topic], *form) for topic, form in forms.items()]


def _rows(raws: list[Raw], form: Template, places: dict[str, slice]) -> Rows:
    """The first messages that wait."""
    block = raws[:BLOCK]
    del raws[:BLOCK]
    rows = form.decode([raw.data for raw in block])
    return [raw.publish_time for raw in block], {name: rows[:, x].copy() for name, x in places.items()}
