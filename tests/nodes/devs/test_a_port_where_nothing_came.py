"""A bag has one list for each in port of its model, which is empty if no message came."""

from __future__ import annotations

from typing import Any

import pytest
from heavylift.kernel import ModelError
from heavylift.nodes import drive
from heavylift.nodes.devs import Atomic, Bag, In, InPort, Message, Out, Tag


class Summand(Message):
    n: int


class Adder(Atomic):
    a, b, done = In(Summand), In(Summand), Out(Summand)

    def start(self) -> None:
        self.ask: Any = None

    def external(self, e: int, x: Bag) -> None:
        self.sum = sum(m.n for port in (self.a, self.b) for m in x[port])
        assert (self.a in x, self.b in x) == (bool(x[self.a]), bool(x[self.b]))
        assert len(x) == sum(map(bool, (x[self.a], x[self.b]))), "asking adds nothing"
        self.hold_in(0)

    def output(self) -> None:
        self.done.send(Summand(self.sum))

    def internal(self) -> None:
        self.passivate()


@pytest.mark.parametrize(
    ("a", "b"), [((1,), ()), ((), (2,)), ((1,), (2,)), ((1, 3), ()), ((), (2, 4, 6)), ((1, 3), (2,))]
)
def test_a_port_that_received_no_messages_gives_an_empty_list(a: tuple[int, ...], b: tuple[int, ...]) -> None:
    given = [(0, "a", Summand(n)) for n in a] + [(0, "b", Summand(n)) for n in b]
    assert drive(Adder("m"), given) == [(Tag(0, 1), "done", Summand(sum(a + b)))]


@pytest.mark.parametrize(
    "ask", ["a", 1, Adder("other").a, Adder("m").done, None], ids=["name", "int", "other", "out", "none"]
)
def test_a_model_that_reads_an_unknown_port_of_its_bag_is_refused(ask: object) -> None:
    class Asking(Adder):
        def external(self, e: int, x: Any) -> None:
            x[ask]

    with pytest.raises(
        ModelError,
        match=r"^m at \(0 s, 0\): x\[.*\]: this is not an input port of the model, which has self.a, self.b$",
    ):
        drive(Asking("m"), [(0, "a", Summand(1))])


def test_a_port_that_a_model_adds_to_itself_can_be_read_in_its_transitions() -> None:
    class Wide(Adder):
        def __init__(self, name: str) -> None:
            super().__init__(name)
            self.more: list[InPort[Summand]] = [self.add_in(f"more{i}", Summand) for i in range(3)]

        def external(self, e: int, x: Bag) -> None:
            self.sum = sum(m.n for port in self.more for m in x[port])
            self.hold_in(0)

    assert drive(Wide("m"), [(0, "more1", Summand(5))]) == [(Tag(0, 1), "done", Summand(5))]
