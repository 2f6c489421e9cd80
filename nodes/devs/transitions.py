"""What a simulator did: the raw trace, and the log of transitions made from it.

A trace is called after each transition with what lies at hand, so that it costs little; a log builds one `Transition`
of each, which can be compared and kept.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from .messages import Message
from .ports import InPort, OutPort
from .tags import Tag

__all__ = ["Trace", "Transition", "logged"]

# tag, path, "internal", "external" or "confluent", its bag (None if empty), all that was said at this tag
Trace = Callable[[Tag, str, str, dict[InPort[Any], list[Any]] | None, list[tuple[OutPort[Any], Any]]], None]


class Transition(NamedTuple):
    """One line of the log: what an atomic did at a tag, received and said, as (port, message)."""

    tag: Tag
    path: str
    kind: str  # "internal", "external" or "confluent"
    bag: tuple[tuple[str, Message], ...]
    sent: tuple[tuple[str, Message], ...]


def logged(log: Callable[[Transition], None]) -> Trace:
    """The trace that hands transitions to a log."""
    said: list[tuple[OutPort[Any], Any]] = []
    words: dict[str, list[tuple[str, Message]]] = {}  # what each atomic said at the present tag

    def trace(
        tag: Tag, path: str, kind: str, x: dict[InPort[Any], list[Any]] | None, now: list[tuple[OutPort[Any], Any]]
    ) -> None:
        nonlocal said
        if now is not said:
            said = now
            words.clear()
            for port, value in now:
                words.setdefault(port.owner.path, []).append((port.name, value))
        bag = tuple((port.name, value) for port, values in (x or {}).items() for value in values)
        log(Transition(tag, path, kind, bag, tuple(words.get(path, ()))))

    return trace
