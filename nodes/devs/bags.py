"""How what is said comes to lie in the bags of its receivers, in the order of the ranks that flattening gave.

Until its receiver takes it, a message lies in the port itself, where one message needs no container: containers that
live through a whole instant would keep the garbage collector busy.
"""

from bisect import bisect_right
from collections.abc import Sequence
from typing import Any

from heavylift.kernel.errors import ModelError

from .messages import Message
from .models import Atomic
from .ports import InPort, M, Port

EMPTY = -1  # rank of a port in which nothing lies


def deliver(said: Sequence[tuple[Port[Any], Any]], received: list[int]) -> None:
    """Put messages into their receivers' ports, in order of rank; note who got something."""
    for source, value in said:
        for port, m, rank in source.routes:
            if port.rank == EMPTY:
                port.rank, port.value = rank, value
                if m._into is None:
                    m._into = port
                    received.append(m._index)
                else:
                    m._more = (*m._more, port)
            else:
                if port.ranks is None:
                    port.ranks, port.value = [port.rank], [port.value]
                at = bisect_right(port.ranks, rank)
                port.ranks.insert(at, rank)
                port.value.insert(at, value)


def taken(m: Atomic) -> dict[InPort[Any], list[Any]]:
    """The bag of an atomic that got something: ports by name, values by rank; nothing lies there any more."""
    port, more = m._into, m._more
    assert port is not None
    m._into = None
    if more:
        m._more = ()
        return {port: _values(port) for port in sorted((port, *more), key=_name)}
    return {port: _values(port)}


def _values(port: InPort[Any]) -> list[Any]:
    port.rank = EMPTY
    if port.ranks is None:
        return [port.value]
    port.ranks = None
    return port.value  # type: ignore[no-any-return]


def _name(port: InPort[Any]) -> str:
    return port.name


def fitting(port: InPort[M], value: Message) -> M:
    """The message, if the port carries its type."""
    if not isinstance(value, port.type):
        raise ModelError(f"{port!r} carries {port.type.__name__}, not {type(value).__name__}")
    return value
