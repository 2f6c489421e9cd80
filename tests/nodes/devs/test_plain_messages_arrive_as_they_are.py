"""Checks of message fields by type, without encoding, agree with checks of the encoded bytes for any values."""

from enum import Enum, Flag, IntEnum
from random import Random
from typing import Any

import msgspec
import pytest
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Message, messages, travelling


class Side(Enum):
    WEST = "west"
    EAST = "east"


class Level(IntEnum):
    LOW = 1
    HIGH = 2


class Marks(Flag):
    RED = 1
    BLUE = 2


class Part(Message):
    n: int
    text: str = ""


class Finer(Part):
    more: int = 0


VALUES: list[Any] = [
    *(0, 1, True, False, 2**63, 2**64 - 1, 2**64, -(2**63), -(2**63) - 1, 0.5, 1.0, -0.0, float("inf"), float("nan")),
    *("", "a", "\u00e9", "\ud800", b"", b"a", None, (), (1,), (1, "a"), ("a", "b"), (1, 2, 3), ((1,), (2,)), (True,)),
    *(Side.WEST, Level.LOW, Marks.RED, Marks.RED | Marks.BLUE, "west", Part(1), Part(2**64), Part(1, 5), Finer(1)),  # type: ignore[arg-type]
    *((Part(1),), (Part(1, "a"), Part("x")), (Finer(1),), (0.5, 1), (1.0, 2.0), (None, 1), (Side.EAST, 1), 10**400),  # type: ignore[arg-type]
]
SIMPLE: list[Any] = [bool, int, float, str, bytes, type(None), Side, Level, Marks, Part]


def hint(r: Random, depth: int = 2) -> Any:
    kind = r.randrange(6) if depth else 0
    if kind < 3:
        return r.choice(SIMPLE)
    if kind == 3:
        return tuple[hint(r, depth - 1), ...]  # type: ignore[misc]
    if kind == 4:
        return tuple[tuple(hint(r, depth - 1) for _ in range(r.randint(1, 3)))]  # type: ignore[misc]
    return r.choice(SIMPLE) | None


def exactly(x: Any) -> Any:
    """A value with the types of all that is in it."""
    inner = msgspec.structs.astuple(x) if isinstance(x, msgspec.Struct) else x
    return type(x), tuple(map(exactly, inner)) if isinstance(inner, tuple) else repr(inner)


def compared(seed: int) -> tuple[int, int]:
    """Messages of a random class that call themselves plain, and those of them that do not arrive so."""
    r, plain, wrong = Random(seed), 0, 0
    hints = {name: hint(r) for name in "xyz"[: r.randint(1, 2)]}
    cls: Any = type(Message)("Random", (Message,), {"__annotations__": hints, "__module__": __name__})
    messages._REGISTRY.pop("Random")
    for _ in range(300):
        try:
            message = cls(*(r.choice(VALUES) for _ in cls.__struct_fields__))
        except ModelError:
            continue
        if not message.__plain__():
            continue
        plain += 1
        try:
            arrived = msgspec.msgpack.decode(msgspec.msgpack.encode(message), type=cls)
        except (TypeError, ValueError, OverflowError, msgspec.MsgspecError):
            arrived = None
        wrong += exactly(arrived) != exactly(message)
        assert travelling(message, "port") is message
    return plain, wrong


@pytest.mark.parametrize("seeds", [range(k, k + 40) for k in range(0, 400, 40)], ids=str)
@pytest.mark.large(beyond=2)
def test_messages_of_plain_data_arrive_as_they_were_sent(seeds: range) -> None:
    found = [compared(seed) for seed in seeds]
    assert sum(wrong for _, wrong in found) == 0
    assert sum(plain for plain, _ in found) > 150


@pytest.mark.parametrize("careless", [int, str, float])
def test_the_test_of_message_checks_detects_a_check_that_is_too_weak(
    careless: type, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        messages,
        "_check",
        lambda x, hint, names, before=messages._check: (
            f"isinstance({x}, (int, str, bool))" if hint is careless else before(x, hint, names)
        ),
    )
    assert sum(wrong for _, wrong in map(compared, range(40))) > 0
