"""An output function that changes its model's state ends the run, at the first or at a later check."""

from collections import deque
from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
import pytest
from devs_stories import Item, Relay, coupled
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Atomic, Out, Simulator, Tag
from heavylift.nodes.devs.execution import rules
from heavylift.nodes.plan import Gear


class Clock(Atomic):
    """Speaks every 10 ns; `spoil` is what its output does beside."""

    out = Out(Item)

    def __init__(self, name: str, spoil: Callable[[Any], object] = lambda self: None, after: int = 0) -> None:
        super().__init__(name)
        self.spoil, self.after = spoil, after

    def start(self) -> None:
        self.n, self.x, self.word = 0, 0.5, "a"
        self.queue, self.deque, self.table = [1, 2], deque([1]), {"a": [1]}
        self.array, self.random, self.numpy = np.zeros(3), Random(1), np.random.default_rng(1)
        self.inner = Inner()
        self.hold_in(10)

    def output(self) -> None:
        if self.n >= self.after:
            self.spoil(self)
        self.out.send(Item(self.n))

    def internal(self) -> None:
        self.n += 1
        self.hold_in(10)


class Light(Clock):
    def start(self) -> None:
        self.n = 0
        self.hold_in(10)


class Inner:
    def __init__(self) -> None:
        self.parts = [[0]]


def put(key: str, value: object) -> Callable[[Any], object]:
    return lambda self: setattr(self, key, value)


SPOILS: list[tuple[str, Callable[[Any], object]]] = [
    ("n", put("n", 7)),
    ("x", put("x", float("nan"))),
    ("word", put("word", "b")),
    ("new", put("new", 1)),
    ("word", lambda self: delattr(self, "word")),
    ("queue", lambda self: self.queue.pop()),
    ("deque", lambda self: self.deque.rotate() or self.deque.append(2)),
    ("table", lambda self: self.table["a"].append(2)),
    ("array", lambda self: self.array.fill(1.0)),
    ("random", lambda self: self.random.random()),
    ("numpy", lambda self: self.numpy.random()),
    ("inner", lambda self: self.inner.parts[0].append(1)),
]


def ran(until: int, *models: Atomic) -> str:
    """The sentence that a run ends with, or where it came to."""
    simulator = Simulator(coupled("r", [*models]))
    simulator.start()
    try:
        simulator.run(until)
    except ModelError as error:
        return str(error)
    return f"came to {simulator.next_time.t}"


@pytest.mark.parametrize(("key", "spoil"), SPOILS, ids=[f"{key}-{i}" for i, (key, _) in enumerate(SPOILS)])
def test_an_output_function_that_changes_the_state_is_reported_with_the_changed_attribute(
    key: str, spoil: Callable[[Any], object], monkeypatch: pytest.MonkeyPatch
) -> None:
    message = f"r.b at (0.00000001 s, 0): output() must not change the state: it changed {key}; do that in a transition"
    assert ran(45, Clock("a"), Clock("b", spoil)) == message
    monkeypatch.setattr(rules.Witness, "after", lambda witness, tag, seen: None)
    assert ran(15, Clock("a"), Clock("b", spoil)) != message, "nobody else sees it"


@pytest.mark.parametrize("after", range(0, 4000, 333))
def test_an_output_function_that_begins_to_change_the_state_late_in_a_run_is_soon_found(after: int) -> None:
    message = ran(
        50_000, *(Light(f"c{i}") for i in range(5)), Light("late", lambda self: put("n", self.n + 1)(self), after)
    )
    assert "r.late at (" in message, message
    assert "it changed n" in message
    seen = round(float(message.split("(")[1].split(" s")[0]) * 1e9)
    assert 0 <= seen - 10 * (after + 1) < 20 * rules.EVERY  # [ns]


def test_an_output_function_that_changes_no_state_is_accepted() -> None:
    harmless: list[Callable[[Any], object]] = [
        lambda self: self.queue.sort(),
        put("n", 0),
        lambda self: setattr(self, "word", "".join(["a"])),
        lambda self: self.now,
        lambda self: [x for x in self.queue],
    ]
    for spoil in harmless:
        assert ran(15, Clock("a", spoil)) == "came to 20"


def test_a_model_with_a_large_state_is_checked_less_often_for_changes_in_its_output_function() -> None:
    candidates = 0

    class Heavy(Relay):
        def __getstate__(self) -> object:
            raise AssertionError("models are no part of a state")

    class Counted(list[int]):
        def __reduce__(self) -> tuple[Any, ...]:
            nonlocal candidates
            candidates += 1
            return list, ([0] * 100_000,)

    clock = Clock("a")
    simulator = Simulator(clock)
    simulator.start()
    clock.big, clock.neighbour = Counted(), Heavy("h")  # type: ignore[attr-defined]
    simulator.run(10 * 251 * 100)
    assert simulator.next_time == Tag(10 * 251 * 100)
    assert 2 <= candidates <= 30, "of 25 000 outputs"


class Planned(Clock):
    def start(self) -> None:
        super().start()
        self.gear, self.known = gear(0), Inner()
        self.known.parts = [gear(n) for n in range(1000)]


def gear(number: int) -> Gear:
    return Gear(name=f"shackle {number}", kind="shackle", number=number)


@pytest.mark.parametrize(
    ("key", "spoil"),
    [("gear", lambda self: put("gear", gear(1))(self)), ("known", lambda self: self.known.parts.insert(9, gear(1)))],
)
def test_an_output_function_that_replaces_a_part_of_a_plan_is_reported_without_reading_plans(
    key: str, spoil: Callable[[Any], object], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert f"it changed {key}" in ran(45, Planned("a", spoil))
    monkeypatch.setattr(Gear, "__reduce__", lambda self: pytest.fail("a plan was read"))
    assert ran(15, Planned("a")) == "came to 20"


class Bare(Atomic):
    """Of attributes that cannot change in place, so that nobody looks at their names before."""

    def start(self) -> None:
        self.a, self.b, self.c = "one", "two", "three"
        self.hold_in(10)

    def internal(self) -> None:
        self.hold_in(10)


def exchange(self: Any) -> None:
    self.b, self.c = self.c, self.b


def replace(self: Any) -> None:
    del self.b
    self.d = "four"


UNCHANGEABLE: list[tuple[str, Callable[[Any], object]]] = [
    ("b", lambda self: put("b", self.a)(self)),
    ("a", lambda self: put("a", self.c)(self)),
    ("c", lambda self: put("c", "new")(self)),
    ("b", exchange),
    ("d", lambda self: put("d", "new")(self)),
    ("the set of attributes", lambda self: put("d", self.a)(self)),
    ("an attribute, which it deleted", lambda self: delattr(self, "b")),
    ("d", replace),
]


@pytest.mark.parametrize(("key", "spoil"), UNCHANGEABLE)
def test_an_output_function_that_replaces_an_immutable_attribute_is_reported_with_its_name(
    key: str, spoil: Callable[[Any], object]
) -> None:
    message = f"r.a at (0.00000001 s, 0): output() must not change the state: it changed {key}; do that in a transition"
    spoiled = type("Spoiled", (Bare,), {"output": spoil})
    assert ran(45, spoiled("a")) == message
