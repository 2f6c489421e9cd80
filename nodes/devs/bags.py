"""How what is said comes to lie in the bags of its receivers, in the order of the ranks that flattening gave.

A bag is made when the first message arrives; as long as one message lies in a port its rank is a number, from the
second on they are a list.  A port with one message needs no list, which is most of them.
"""

from bisect import bisect_right
from collections.abc import Sequence
from typing import Any

from heavylift.kernel.errors import ModelError

from .messages import Message
from .ports import InPort, M, OutPort, Port


def words(said: list[tuple[OutPort[Any], Any]]) -> dict[int, tuple[tuple[str, Message], ...]]:
    """Who says what, for the log."""
    words: dict[int, tuple[tuple[str, Message], ...]] = {}
    for port, value in said:
        i = port.owner._index  # type: ignore[attr-defined]  # only atomics speak
        words[i] = (*words[i], (port.name, value)) if i in words else ((port.name, value),)
    return words


def deliver(said: Sequence[tuple[Port[Any], Any]], received: list[int]) -> None:
    """Put messages into their receivers' bags, in order of rank; note who got something."""
    for source, value in said:
        for port, m, rank in source.routes:
            bag = m._bag
            if not bag:
                received.append(m._index)
                m._bag, port.rank = {port: [value]}, rank
                continue
            values = bag.get(port)
            if values is None:
                bag[port], port.rank = [value], rank
                continue
            ranks = port.ranks = [port.rank] if len(values) == 1 else port.ranks
            at = bisect_right(ranks, rank)
            ranks.insert(at, rank)
            values.insert(at, value)


def fitting(port: InPort[M], value: Message) -> M:
    """The message, if the port carries its type."""
    if not isinstance(value, port.type):
        raise ModelError(f"{port!r} carries {port.type.__name__}, not {type(value).__name__}")
    return value
