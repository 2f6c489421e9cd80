"""Whatever number of a message is made negative, too large or no number, the message is refused, not obeyed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest
from heavylift.coordinator.live import RunOrder
from heavylift.coordinator.protocol import messages as m
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import Event, Tag

EVENT = Event(5, 1, "crane", "out", 2, "Done", b"")
MESSAGES: list[m.AnyMessage] = [
    m.Hello(Tag(1, 2), [EVENT], Tag(3, 4), {"out": 10}),
    m.Welcome(7, b""),
    m.Grant(3, Tag(9, 8), (4, 6), True, [EVENT]),
    m.GrantDone(3, Tag(9, 8), [EVENT], Tag(11, 1), [EVENT], Tag(12, 3), b""),
    m.Checkpoint(4),
    m.Fail(Tag(1, 1), "crane", "no", ""),
    m.StopRun(Tag(6, 2)),
    m.Bye("", 0.5),
]


def spoiled(value: Any) -> Iterator[Any]:
    """Copies of plain data in each of which one number is nonsense."""
    if isinstance(value, list | tuple):
        for i, part in enumerate(value):
            yield from ([*value[:i], bad, *value[i + 1 :]] for bad in spoiled(part))
    elif isinstance(value, dict):
        for name, part in value.items():
            yield from ({**value, name: bad} for bad in spoiled(part))
    elif isinstance(value, float):
        yield from (-value, -math.inf)
    elif isinstance(value, int) and not isinstance(value, bool):
        yield from (-1, -(2**63), value + 0.5, str(value))


@pytest.mark.parametrize("message", MESSAGES, ids=lambda message: type(message).__name__)
def test_invalid_numbers_in_messages_of_the_time_protocol_are_refused(message: m.AnyMessage) -> None:
    wire = m.encode(message)
    assert m.decode(wire) == message
    found = list(spoiled(msgspec.msgpack.decode(wire)))
    assert found
    for bad in found:
        with pytest.raises(ProtocolError, match="not a message of the time protocol"):
            m.decode(msgspec.msgpack.encode(bad))


@pytest.mark.parametrize(
    "order",
    [{"do": "step", "by_ns": by} for by in (-5, 0, 2**63, 2**64 - 1, 0.5)]
    + [{"do": "rate", "factor": by} for by in (-1.0, 0.0, math.nan)],
)
def test_invalid_numbers_in_operator_commands_are_refused(order: dict[str, object]) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.msgpack.decode(msgspec.msgpack.encode(order), type=RunOrder)
