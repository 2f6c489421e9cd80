"""Atomics and couplings come and go at an instant: after all its transitions, and never half."""

import pytest
from devs_stories import Generator, Item, Relay, Sink, coupled
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Out, Simulator, Tag, Trace, Transition, ns


class Breeder(Atomic):
    """Adds a relay to its yard with every number it hears, up to three, and couples it to the sink."""

    into = In(Item)

    def start(self) -> None:
        self.born = 0

    def external(self, e: int, x: Bag) -> None:
        if self.born < 3 and isinstance(yard := self.parent, Coupled):
            child = yard.add(Relay(f"r{self.born}", first=100 + self.born))
            yard.connect(child.out, yard.children["sink"].into)
            self.born += 1


class Remover(Atomic):
    """Takes a model out at the time it is told."""

    def __init__(self, name: str, victim: str, when: int) -> None:
        super().__init__(name)
        self.victim, self.when = victim, when

    def start(self) -> None:
        self.hold_in(self.when)

    def internal(self) -> None:
        assert isinstance(self.parent, Coupled)
        self.parent.remove(self.victim)
        self.passivate()


def started(model: Coupled, log: list[Transition] | None = None) -> Simulator:
    simulator = Simulator(model, None if log is None else log.append)
    simulator.start()
    return simulator


def test_what_is_added_starts_at_the_next_microstep() -> None:
    g, b, sink = Generator("g", ns(1)), Breeder("b"), Sink("sink")
    simulator = started(coupled("yard", [g, b, sink], (g.out, b.into)))
    simulator.run(ns(5))
    assert sink.got == [(Tag(ns(t), 1), [99 + t]) for t in (1, 2, 3)]
    assert [m.name for m in simulator.atomics] == ["b", "g", "r0", "r1", "r2", "sink"]


def test_what_is_removed_hears_nothing_any_more_but_what_came_at_that_instant() -> None:
    g, sink = Generator("g", ns(1)), Sink("sink")
    remover = Remover("x", "sink", ns(3))
    simulator = started(coupled("yard", [g, sink, remover], (g.out, sink.into)))
    simulator.run(ns(6))
    assert sink.got == [(Tag(ns(t)), [t - 1]) for t in (1, 2, 3)]
    assert [m.name for m in simulator.atomics] == ["g", "x"]


def test_what_is_removed_does_not_speak() -> None:
    g, sink = Generator("g", ns(1)), Sink("sink")
    started(coupled("yard", [g, sink, Remover("x", "g", ns(2.5))], (g.out, sink.into))).run(ns(6))
    assert sink.got == [(Tag(ns(1)), [0]), (Tag(ns(2)), [1])]


def test_couplings_come_and_go() -> None:
    class Switch(Atomic):
        def start(self) -> None:
            self.hold_in(ns(2))

        def internal(self) -> None:
            yard = self.parent
            assert isinstance(yard, Coupled)
            if self.now.t == ns(2):
                yard.disconnect(g.out, left.into)
                yard.connect(g.out, right.into)
                self.hold_in(ns(100))

    g, left, right = Generator("g", ns(1)), Sink("left"), Sink("right")
    started(coupled("yard", [g, left, right, Switch("s")], (g.out, left.into))).run(ns(5))
    assert [n for _, n in left.got] == [[0], [1]], "what was said at the instant of the change took the old way"
    assert [n for _, n in right.got] == [[2], [3]]


def test_the_clock_of_the_others_runs_on() -> None:
    """A model whose neighbours change keeps its schedule and its elapsed time."""
    relay, g, b, sink = Relay("relay", ns(2.5)), Generator("g", ns(1), count=1), Breeder("b"), Sink("sink")
    simulator = started(coupled("yard", [g, b, relay, sink], (g.out, b.into), (g.out, relay.into)))
    simulator.trace = Trace()
    simulator.run(ns(10))
    assert (Tag(ns(3.5)), "yard.relay", "internal") in [(line.tag, line.path, line.kind) for line in simulator.trace]


def test_between_runs_the_structure_changes_before_the_next_tag() -> None:
    g, sink = Generator("g", ns(1)), Sink("sink")
    yard = coupled("yard", [g, sink], (g.out, sink.into))
    simulator = started(yard)
    simulator.run(ns(1.5))
    late = yard.add(Sink("late"))
    yard.connect(g.out, late.into)
    simulator.run(ns(3.5))
    assert late.got == [(Tag(ns(2)), [1]), (Tag(ns(3)), [2])]


def test_impossible_changes_name_place_and_time() -> None:
    simulator = started(coupled("yard", [Remover("x", "nobody", ns(2))]))
    with pytest.raises(ModelError) as error:
        simulator.run(ns(5))
    assert str(error.value) == ("yard: there is no child nobody to remove; it has x (a change of yard at (2 s, 0))")


def test_a_promised_lookahead_holds() -> None:
    class Speaker(Atomic):
        out = Out(Item, lookahead=ns(1))

    class Hasty(Atomic):
        out = Out(Item)

    class Adder(Remover):
        def internal(self) -> None:
            yard = self.parent
            assert isinstance(yard, Coupled)
            yard.connect(yard.add(Hasty("hasty")).out, yard.ports["out"])
            self.passivate()

    yard = coupled("yard", [speaker := Speaker("speaker"), Adder("adder", "", ns(1))])
    yard.connect(speaker.out, yard.add_out("out", Item))
    with pytest.raises(ModelError) as error:
        started(yard).run(ns(5))
    assert str(error.value) == (
        "yard at (1 s, 0): the lookahead of port out falls from 1000000000 ns to 0 ns, but others rely on it; "
        "give what is added no less lookahead"
    )


def test_what_is_added_keeps_its_promise_from_the_change_on() -> None:
    class Hasty(Atomic):
        out = Out(Item, lookahead=ns(1))

        def start(self) -> None:
            self.hold_in(ns(0.5))

        def output(self) -> None:
            self.out.send(Item(1))

    class Adder(Remover):
        def internal(self) -> None:
            yard = self.parent
            assert isinstance(yard, Coupled)
            yard.add(Hasty("hasty"))
            self.passivate()

    with pytest.raises(ModelError) as error:
        started(coupled("yard", [Adder("adder", "", ns(1))])).run(ns(5))
    assert str(error.value) == (
        "yard.hasty at (1.5 s, 0): port out promises a lookahead of 1000000000 ns and speaks 500000000 ns after the "
        "transition that scheduled it; hold for longer or declare less"
    )
