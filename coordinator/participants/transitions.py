"""Transitions of models in other processes: a node sends them as a data topic, the coordinator puts them in order.

One batch per grant: [node's tag ns, [t, k, path, kind, bag, sent] ...], where bag and sent hold (port, type, bytes).
"""

from collections.abc import Callable

import msgspec
from heavylift.kernel.errors import UNREADABLE, ProtocolError
from heavylift.nodes.devs import Message, Tag, Transition, decode, encode

_Said = tuple[str, str, bytes]  # port, class name, canonical bytes
_Line = tuple[int, int, str, str, list[_Said], list[_Said]]
_DECODER: msgspec.msgpack.Decoder[list[_Line]] = msgspec.msgpack.Decoder(list[_Line])


class Transitions:
    """Hears a node's transitions; `flush` sends what came since the last time."""

    def __init__(self, publish: Callable[[bytes], None]) -> None:
        self._publish = publish
        self._lines: list[_Line] = []

    def __call__(self, line: Transition) -> None:
        self._lines.append((*line.tag, line.path, line.kind, _wire(line.bag), _wire(line.sent)))

    def flush(self) -> None:
        """Send the transitions noted so far."""
        if self._lines:
            self._publish(msgspec.msgpack.encode(self._lines))
            self._lines.clear()


def read(batch: bytes) -> list[Transition]:
    """The transitions of a batch; ProtocolError if it holds none."""
    try:
        told = _DECODER.decode(batch)
    except UNREADABLE as error:
        raise ProtocolError(f"a log of transitions cannot be read ({error})") from None
    return [Transition(Tag(t, k), path, kind, _messages(bag), _messages(sent)) for t, k, path, kind, bag, sent in told]


def _wire(said: tuple[tuple[str, Message], ...]) -> list[_Said]:
    return [(port, type(value).__name__, encode(value)) for port, value in said]


def _messages(said: list[_Said]) -> tuple[tuple[str, Message], ...]:
    return tuple((port, decode(name, payload)) for port, name, payload in said)
