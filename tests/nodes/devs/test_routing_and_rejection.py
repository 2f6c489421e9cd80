"""Couplings in, through and out of coupled models; invalid ones are refused when they are made."""

import re
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from devs_stories import Generator, Item, Relay, Sink, coupled, run
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Atomic, Coupled, In, Message, Out, Port, Simulator, Tag, ms, seconds


class Other(Message):
    n: int


def test_messages_pass_from_one_model_to_two_and_from_two_to_one_through_three_levels_of_nesting() -> None:
    seed, left, right, sink = Relay("seed", first=1), Relay("left"), Relay("right"), Sink("sink")
    inside: Coupled = coupled("level2", [left, right])
    inside.connect(inside.add_in("i", Item), left.into)
    inside.connect(inside.ports["i"], right.into)
    for child in (left, right):
        inside.connect(child.out, inside.ports.get("o") or inside.add_out("o", Item))
    for level in ("level1", "level0"):
        outer = coupled(level, [inside])
        outer.connect(outer.add_in("i", Item), inside.ports["i"])
        outer.connect(inside.ports["o"], outer.add_out("o", Item))
        inside = outer
    model = coupled("r", [seed, inside, sink], (seed.out, inside.ports["i"]), (inside.ports["o"], sink.into))
    assert run(model, 1)[-1] == (0.0, 1, "r.sink", "external")
    assert left.path == "r.level0.level1.level2.left"
    assert sink.got == [(Tag(0, 1), [1, 1])]


def test_a_message_sent_on_an_unconnected_port_is_delivered_to_no_model() -> None:
    assert run(coupled("r", [Generator("g", seconds(1), count=1), Sink("s")]), 5) == [(1.0, 0, "r.g", "internal")]


def test_a_nested_model_receives_nothing_if_an_upstream_filter_drops_the_message() -> None:
    class First(Relay):
        def output(self) -> None:
            if self.held[0].n == 0:
                self.out.send(self.held[0])

    g, first, sink = Generator("g", seconds(1)), First("first"), Sink("sink")
    nested = coupled("nested", [sink])
    nested.connect(nested.add_in("i", Item), sink.into)
    run(coupled("r", [g, first, nested], (g.out, first.into), (first.out, nested.ports["i"])), 6)
    assert sink.got == [(Tag(seconds(1), 1), [0])]


def test_outputs_of_the_root_model_are_recorded_as_events_with_numbers() -> None:
    a, b = Relay("a", first=1), Relay("b", first=2)
    model = coupled("west", [a, b])
    out = model.add_out("report", Item)
    model.connect(b.out, out)
    model.connect(a.out, out)
    simulator = Simulator(model)
    simulator.start()
    events = simulator.outputs()
    assert [e.order for e in events] == [(0, 0, "west", "report", 0), (0, 0, "west", "report", 1)]
    assert [(e.type, e.value) for e in events] == [("Item", Item(1)), ("Item", Item(2))]


def test_the_lookahead_of_a_root_model_is_the_smallest_of_all_its_ports_that_send() -> None:
    class Slow(Relay):
        late = Out(Item, lookahead=ms(10))

    slow, fast = Slow("slow", ms(10)), Relay("fast", ms(10))
    model = coupled("m", [slow, fast], (fast.out, slow.into))
    model.connect(model.add_in("i", Item), fast.into)
    model.connect(slow.late, model.add_out("o", Item))
    simulator = Simulator(model)
    simulator.start()
    assert simulator.lookahead == {"m.o": ms(10)}
    simulator.inject("i", Item(1))
    simulator.advance(Tag(0))
    assert (simulator.next_time, simulator.outputs(), simulator.quiet) == (Tag(ms(10)), [], Tag(ms(20)))


def wrong(make: Callable[[], object], sentence: str) -> None:
    with pytest.raises(ModelError, match=f"^{re.escape(sentence)}"):
        make()


def test_invalid_names_of_models_are_refused() -> None:
    r = coupled("r", [Sink("a")])
    wrong(lambda: r.add(Sink("a")), "r: two children are named a; rename one of them")
    wrong(lambda: r.add(r), "r: r already has a parent and cannot be added here")
    wrong(lambda: Coupled("x").add(r.children["a"]), "x: r.a already has a parent and cannot be added here")
    wrong(lambda: Sink("a.b"), "'a.b' is not a valid name of a model: use letters, digits, _ and - only")
    wrong(lambda: r.add_in("a b", Item), "r: 'a b' is not a valid name of a port: use letters, digits, _ and - only")
    wrong(lambda: (r.add_in("i", Item), r.add_out("i", Item)), "r: port i is declared twice")
    wrong(
        lambda: Sink("s").add_in("start", Item),
        "s: a port cannot be named start: every model has an attribute of this name",
    )


def test_couplings_between_unknown_or_unsuitable_ports_are_refused() -> None:
    a, b, inner = Relay("a"), Relay("b"), coupled("inner", [Relay("c")])
    r, c = coupled("r", [a, b, inner], (a.out, b.into)), inner.children["c"]
    i, o = r.add_in("i", Item), r.add_out("o", Item)
    other, stranger = r.add_in("other", Other), Relay("stranger")
    neither = "is neither a port of r nor of its children"
    refused: list[tuple[Port[Any], Port[Any], str]] = [
        (
            i,
            o,
            "it connects an input directly to an output, which the formalism excludes; put an atomic model in between",
        ),
        (a.out, a.into, "it connects a model to itself, which the formalism excludes; put an atomic model in between"),
        (a.out, b.into, "it exists already; a second one would duplicate every message"),
        (a.out, c.ports["into"], f"r.inner.c.into {neither}"),
        (stranger.out, a.into, f"stranger.out {neither}"),
        (other, a.into, "Other does not fit a port of Item"),
        (a.into, b.into, "r.a.into cannot be a source here; use an output port of a child"),
        (a.out, b.out, "r.b.out cannot be a target here; use an input port of a child"),
        (o, a.into, "r.o cannot be a source here; use an output port of a child"),
        (a.out, i, "r.i cannot be a target here; use an input port of a child"),
    ]
    for source, target, why in refused:
        wrong(partial(r.connect, source, target), f"r: coupling {source!r} -> {target!r}: {why}")


def test_invalid_ports_of_a_devs_model_are_refused() -> None:
    wrong(lambda: In(int), "a port cannot carry <class 'int'>: derive it from Message")  # type: ignore[type-var]
    wrong(lambda: Sink("s").add_out("o", Item, -1), "s: port o: lookahead -1 is not a number of ns >= 0")
    wrong(
        lambda: Coupled("c").add_out("o", Item, 5),
        "c: port o: declare the lookahead on the atomic that sends",
    )

    class Hasty(Atomic):
        into = In(Item)

        def __init__(self) -> None:
            print(self.into)

    wrong(Hasty, "Hasty: call super().__init__(name) before using ports")
    simulator = Simulator(coupled("r", [Sink("s")]))
    simulator.start()
    wrong(lambda: simulator.inject("x", Item(1)), "r: there is no input port x")
    simulator = Simulator(Sink("s"))
    simulator.start()
    wrong(lambda: simulator.inject("into", Other(1)), "s.into carries Item, not Other")
