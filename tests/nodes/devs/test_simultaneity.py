"""Events at one instant: one bag, confluent transitions, zero delays, exact coincidence in integer time."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from devs_stories import Generator, Item, Relay, Sink, coupled, kinds, run
from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Out, Simulator, Tag, seconds


def test_a_model_that_receives_a_message_at_its_scheduled_time_makes_a_confluent_transition() -> None:
    seed, a, b = Relay("seed", first=1), Relay("a"), Relay("b")
    model = coupled("r", [seed, a, b], (seed.out, a.into), (seed.out, b.into), (a.out, b.into))
    assert kinds(model, 1) == {"r.seed": "i", "r.a": "ei", "r.b": "eci"}


class Accumulator(Atomic):
    """Sums what it hears; a reset makes it say the sum at the next microstep and forget it."""

    add, reset, total = In(Item), In(Item), Out(Item)

    def start(self) -> None:
        self.sum, self.bags = 0, 0

    def external(self, e: int, x: Bag) -> None:
        self.sum += len(x.get(self.add, []))
        self.bags += 1
        if self.reset in x:
            self.hold_in(0)

    def output(self) -> None:
        self.total.send(Item(self.sum))

    def internal(self) -> None:
        self.sum = 0
        self.passivate()


@pytest.mark.parametrize("nested", [False, True])
def test_a_counter_receives_a_reset_and_its_fifth_tick_in_one_bag(nested: bool) -> None:
    tick, reset, acc = Generator("tick", seconds(1)), Generator("reset", seconds(5)), Accumulator("acc")
    sink = Sink("sink")
    model = Coupled("r")
    model.add(sink)
    if nested:
        left, right = model.add(Coupled("left")), model.add(Coupled("right"))
        for generator in (tick, reset):
            left.add(generator)
            left.connect(generator.out, left.add_out(generator.name, Item))
        right.add(acc)
        for port, name in ((acc.add, "tick"), (acc.reset, "reset")):
            right.connect(right.add_in(name, Item), port)
            model.connect(left.ports[name], right.ports[name])
        right.connect(acc.total, right.add_out("total", Item))
        model.connect(right.ports["total"], sink.into)
    else:
        for child in (tick, reset, acc):
            model.add(child)
        model.connect(tick.out, acc.add)
        model.connect(reset.out, acc.reset)
        model.connect(acc.total, sink.into)
    simulator = Simulator(model)
    simulator.start()
    simulator.run(seconds(5))
    assert (sink.got, acc.sum) == ([], 4)
    simulator.run(seconds(5) + 1)
    assert sink.got == [(Tag(seconds(5), 1), [5])]
    assert (acc.bags, acc.sum, simulator.next_time) == (5, 0, Tag(seconds(6)))


class Holder(Atomic):
    """Holds each token for 1 s."""

    into, out = In(Item), Out(Item)

    def __init__(self, name: str, token: bool) -> None:
        super().__init__(name)
        self.token = token

    def start(self) -> None:
        if self.token:
            self.hold_in(seconds(1))

    def output(self) -> None:
        self.out.send(Item(0))

    def internal(self) -> None:
        self.passivate()

    def external(self, e: int, x: Bag) -> None:
        self.hold_in(seconds(1))


def test_in_a_ring_of_two_models_one_token_gives_alternating_and_two_tokens_give_confluent_transitions() -> None:
    a, b = Holder("a", True), Holder("b", False)
    ring = coupled("ring", [a, b], (a.out, b.into), (b.out, a.into))
    there, back = ("internal", "external"), ("external", "internal")
    assert run(ring, 11) == [
        (float(t), 0, path, kind)
        for t in range(1, 11)
        for path, kind in zip(("ring.a", "ring.b"), there if t % 2 else back, strict=True)
    ]
    a, b = Holder("a", True), Holder("b", True)
    assert kinds(coupled("ring", [a, b], (a.out, b.into), (b.out, a.into)), 11) == {
        "ring.a": "c" * 10,
        "ring.b": "c" * 10,
    }


def test_a_model_in_a_chain_with_equal_periods_makes_only_confluent_transitions_after_its_first() -> None:
    g, p = Generator("g", seconds(1)), Relay("p", seconds(1))
    assert run(coupled("r", [g, p], (g.out, p.into)), 4) == [
        (1.0, 0, "r.g", "internal"),
        (1.0, 0, "r.p", "external"),
        (2.0, 0, "r.g", "internal"),
        (2.0, 0, "r.p", "confluent"),
        (3.0, 0, "r.g", "internal"),
        (3.0, 0, "r.p", "confluent"),
    ]


def test_messages_from_two_sources_to_two_ports_at_one_instant_cause_one_transition() -> None:
    tick, reset, acc = Generator("a", seconds(1), count=1), Generator("b", seconds(1), count=1), Accumulator("acc")
    run(coupled("r", [tick, reset, acc], (tick.out, acc.add), (reset.out, acc.reset)), 2)
    assert acc.bags == 1


def test_a_message_with_two_paths_to_one_port_is_delivered_twice() -> None:
    inner = Coupled("inner")
    sink = inner.add(Sink("sink"))
    for name in ("one", "two"):
        inner.connect(inner.add_in(name, Item), sink.into)
    seed = Relay("seed", first=7)
    run(coupled("r", [seed, inner], (seed.out, inner.ports["one"]), (seed.out, inner.ports["two"])), 1)
    assert sink.got == [(Tag(0), [7, 7])]


def test_clocks_of_100_ms_and_300_ms_coincide_exactly_at_every_multiple_of_300_ms() -> None:
    a, b, sink = Generator("a", seconds(0.1)), Generator("b", seconds(0.3)), Sink("sink")
    run(coupled("r", [a, b, sink], (a.out, sink.into), (b.out, sink.into)), 30 + 1e-9)
    sizes = [len(bag) for _, bag in sink.got]
    assert (len(sizes), sizes.count(2)) == (300, 100)
    assert all(size == (2 if i % 3 == 2 else 1) for i, size in enumerate(sizes))


class Twice(Atomic):
    """Says n and n + 1 by `late`, then n + 2 by `early`."""

    early, late = Out(Item), Out(Item)

    def __init__(self, name: str, n: int) -> None:
        super().__init__(name)
        self.n = n

    def start(self) -> None:
        self.hold_in(0)

    def output(self) -> None:
        self.late.send(Item(self.n))
        self.late.send(Item(self.n + 1))
        self.early.send(Item(self.n + 2))

    def internal(self) -> None:
        self.passivate()


def test_a_model_receives_simultaneous_messages_ordered_by_source_then_port_then_index() -> None:
    sources, sink = [Twice("b", 20), Twice("a-b", 10), Twice("a", 0)], Sink("sink")
    couplings = [(port, sink.into) for s in sources for port in (s.late, s.early)]
    run(coupled("r", [sink, *sources], *couplings), 1)
    assert sink.got == [(Tag(0), [2, 0, 1, 12, 10, 11, 22, 20, 21])]


HASHING = """
import sys
sys.path.insert(0, sys.argv[1])
from devs_stories import *
sources, sink = [Generator(f"s{i}", seconds(1 + i % 3)) for i in range(12)], Sink("sink")
log = run(coupled("r", [*sources, sink], *[(s.out, sink.into) for s in sources]), 10)
print(log, sink.got)
"""


def test_the_order_of_messages_in_a_bag_does_not_depend_on_the_hash_seed() -> None:
    message = set()
    for seed in "0123":
        run_ = [sys.executable, "-c", HASHING, str(Path(__file__).parent)]
        message.add(subprocess.check_output(run_, env={**os.environ, "PYTHONHASHSEED": seed}))
    assert len(message) == 1
