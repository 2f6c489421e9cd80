"""No receiver can change the message of another: messages are immutable, and copied between nodes."""

from enum import Enum
from typing import Any, Literal, NamedTuple

import msgspec
import numpy as np
import pytest
from devs_stories import Item, Relay, Sink, coupled
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Bag, Event, Message, Simulator, Tag, Trace, decode, encode, message_type


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


def test_every_message_type_can_be_encoded_canonically_and_decoded() -> None:
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
def test_a_message_class_with_a_mutable_field_is_refused(field: Any, shown: str) -> None:
    with pytest.raises(ModelError) as caught:
        define("Mutable", (Message,), {"__annotations__": {"load": field}})
    assert str(caught.value) == (
        f"message Mutable, field load: {shown} can be changed by a receiver; "
        f"use numbers, str, bytes, tuple[...], enums or other messages"
    )


def test_a_message_class_that_is_not_frozen_is_refused() -> None:
    with pytest.raises(ModelError, match=r"^message Thawed is not frozen: a receiver could change it"):
        define("Thawed", (Message,), {"__annotations__": {"n": int}}, frozen=False)


def test_two_message_classes_with_the_same_name_are_refused() -> None:
    with pytest.raises(ModelError, match=r"^message Item is defined in devs_stories and again in else"):
        define("Item", (Message,), {"__annotations__": {"n": int}, "__module__": "elsewhere"})


class Bundle(Message):
    parts: tuple[int, ...] = ()
    by: Item | None = None
    point: Point = Point(0.0)


@pytest.mark.parametrize(
    ("fields", "shown"),
    [
        ({"parts": [1, 2]}, "field parts: the list [1, 2]"),
        ({"parts": (1, [2])}, "field parts: the tuple (1, [2])"),
        ({"parts": ((1, {"a": 2}),)}, "field parts: the tuple ((1, {'a': 2}),)"),
        ({"parts": {1}}, "field parts: the set {1}"),
        ({"parts": bytearray(b"a")}, "field parts: the bytearray bytearray(b'a')"),
        ({"parts": np.array([1])}, "field parts: the ndarray array([1])"),
        ({"by": Loose(1.0)}, "field by: the Loose Loose(x=1.0)"),
        ({"point": Point([1.0])}, "field point: the Point Point(x=[1.0])"),
    ],
    ids=lambda x: "" if isinstance(x, dict) else x,
)
def test_a_message_field_that_contains_a_mutable_container_is_refused_with_or_without_annotation(
    fields: Any, shown: str
) -> None:
    """So neither a receiver nor the sender, after it has sent, can change what the others see."""
    with pytest.raises(ModelError) as caught:
        Bundle(**fields)
    assert str(caught.value) == (
        f"message Bundle, {shown} can be changed by a receiver; "
        "use numbers, str, bytes, tuples, enums or other messages"
    )


def test_a_mutable_default_in_a_message_class_is_refused_with_the_class() -> None:
    with pytest.raises(ModelError, match=r"^message Heap, field parts: list\[int\] can be changed by a receiver"):
        define("Heap", (Message,), {"__annotations__": {"parts": list[int]}, "parts": []})


def test_a_model_that_empties_its_input_bag_leaves_the_bags_of_other_models_unchanged() -> None:
    """One spoils its bag, the others and the trace keep theirs."""

    class Spoiler(Relay):
        def external(self, e: int, x: Bag) -> None:
            x[self.into].clear()
            x[self.into].append(Item(99))
            self.hold_in(0)

    spoiler, a, seed = Spoiler("a-first"), Relay("b"), Relay("seed", first=1)
    trace = Trace()
    simulator = Simulator(coupled("r", [seed, spoiler, a], (seed.out, spoiler.into), (seed.out, a.into)), trace=trace)
    simulator.start()
    simulator.advance(Tag(0))
    assert a.held == [Item(1)]
    assert [line.bag for line in trace] == [(("into", Item(1)),), (("into", Item(1)),), ()]


def test_the_receiver_of_a_message_cannot_change_the_message() -> None:
    with pytest.raises(AttributeError):
        Item(1).n = 2


def test_each_receiver_of_a_message_has_its_own_bag_and_its_own_decoded_copy() -> None:
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
def test_bytes_that_are_no_message_and_unknown_message_types_are_refused_by_name(
    type_: str, payload: bytes, sentence: str
) -> None:
    simulator = Simulator(Sink("s"), wires=[("x", "o", "s", "into")])
    simulator.start()
    with pytest.raises(ModelError) as caught:
        simulator.advance(Tag(10**9), [Event(10**9, 0, "x", "o", 0, type_, payload)])
    assert str(caught.value) == sentence
