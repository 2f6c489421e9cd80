"""No receiver can change what another one sees: messages are immutable, and copied between nodes."""

from enum import Enum
from typing import Any, Literal, NamedTuple

import msgspec
import pytest
from devs_stories import Item, Relay, Sink, coupled
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Delivery, Event, Message, Simulator, Tag, decode, encode, message_type


class Kind(Enum):
    TAUT = "taut"


class Place(NamedTuple):
    x: float
    y: float


class Point(msgspec.Struct, frozen=True):
    x: float


class Rich(Message):
    kind: Kind
    at: Place
    point: Point
    parts: tuple[Item, ...] = ()
    way: Literal["up", "down"] = "up"
    length: float | None = None
    tag: Tag = Tag(0)
    inner: "Rich | None" = None


class Loose(msgspec.Struct):
    x: float


define: Any = type(Message)


def test_canonical_bytes_and_back() -> None:
    rich = Rich(Kind.TAUT, Place(1.0, 2.0), Point(3.0), (Item(1), Item(2)), "down", 0.5, Tag(7, 1))
    assert decode("Rich", encode(rich)) == rich
    assert encode(Item(5)) == b"\x81\xa1n\x05"
    assert message_type("Item") is Item


@pytest.mark.parametrize(
    ("field", "shown"),
    [
        (list[int], "list[int]"),
        (dict[str, int], "dict[str, int]"),
        (set[int], "set[int]"),
        (frozenset[str], "frozenset[str]"),
        (bytearray, "bytearray"),
        (Any, "Any"),
        (tuple[list[int], ...], "tuple[list[int], ...]"),
        (Loose, "Loose"),
        (list[int] | None, "list[int] | None"),
    ],
)
def test_a_field_that_a_receiver_could_change_is_refused(field: Any, shown: str) -> None:
    with pytest.raises(ModelError) as caught:
        define("Mutable", (Message,), {"__annotations__": {"load": field}})
    assert str(caught.value) == (
        f"message Mutable, field load: {shown} can be changed by a receiver, "
        f"use numbers, str, bytes, tuple[...], enums or other messages"
    )


def test_a_message_that_is_not_frozen_is_refused() -> None:
    with pytest.raises(ModelError, match=r"^message Thawed is not frozen: a receiver could change it"):
        define("Thawed", (Message,), {"__annotations__": {"n": int}}, frozen=False)


def test_two_messages_of_one_name_are_refused() -> None:
    with pytest.raises(ModelError, match=r"^message Item is defined in devs_stories and again in else"):
        define("Item", (Message,), {"__annotations__": {"n": int}, "__module__": "elsewhere"})


def test_a_receiver_cannot_change_a_message() -> None:
    with pytest.raises(AttributeError):
        Item(1).n = 2


def test_bags_and_decoded_copies_are_the_receivers_own() -> None:
    a, b, seed = Relay("a"), Relay("b"), Relay("seed", first=1)
    simulator = Simulator(coupled("r", [seed, a, b], (seed.out, a.into), (seed.out, b.into)))
    simulator.start()
    simulator.advance(Tag(0))
    a.held.clear()
    assert b.held == [Item(1)]

    event = Event(0, 0, "x", "o", 0, "Item", encode(Item(4)))
    assert event.value == event.value
    assert event.value is not event.value


@pytest.mark.parametrize(
    ("type_", "payload", "sentence"),
    [
        (
            "Ghost",
            b"",
            "s.into at (1 s, 0): unknown message type 'Ghost': import the module that defines it (from x.o)",
        ),
        (
            "Item",
            b"\x81\xa1n\xa1x",
            "s.into at (1 s, 0): message Item cannot be decoded: Expected `int`, got `str` - at `$.n` (from x.o)",
        ),
    ],
)
def test_bad_bytes_and_unknown_types_are_named(type_: str, payload: bytes, sentence: str) -> None:
    simulator = Simulator(Sink("s"))
    simulator.start()
    with pytest.raises(ModelError) as caught:
        simulator.advance(Tag(10**9), [Delivery(Event(10**9, 0, "x", "o", 0, type_, payload), "into")])
    assert str(caught.value) == sentence
