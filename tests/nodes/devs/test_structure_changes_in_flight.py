"""Atomics and couplings are added and removed at an instant, after all its transitions."""

import re
from collections.abc import Callable

import pytest
from devs_stories import Generator, Item, Relay, Sink, coupled
from heavylift.kernel import ModelError
from heavylift.nodes import drive
from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Out, Simulator, Tag, Trace, seconds


class Breeder(Atomic):
    """Adds a relay to its yard with every number it hears, up to three, and couples it to the sink."""

    into = In(Item)

    def start(self) -> None:
        self.born = 0

    def external(self, e: int, x: Bag) -> None:
        if self.born < 3 and isinstance(builder := self.parent, Coupled):
            child = builder.add(Relay(f"r{self.born}", first=100 + self.born))
            builder.connect(child.out, builder.children["sink"].into)
            self.born += 1


class Remover(Atomic):
    """Takes a model out at the time it is reported."""

    def __init__(self, name: str, victim: str, when: int) -> None:
        super().__init__(name)
        self.victim, self.when = victim, when

    def start(self) -> None:
        self.hold_in(self.when)

    def internal(self) -> None:
        assert isinstance(self.parent, Coupled)
        self.parent.remove(self.victim)
        self.passivate()


def started(builder: Coupled) -> Simulator:
    """Of a site that the yard is a child of."""
    simulator = Simulator(coupled("site", [builder]))
    simulator.start()
    return simulator


def test_a_model_added_during_a_run_starts_at_the_next_microstep() -> None:
    g, b, sink = Generator("g", seconds(1)), Breeder("b"), Sink("sink")
    simulator = started(coupled("yard", [g, b, sink], (g.out, b.into)))
    simulator.run(seconds(5))
    assert sink.got == [(Tag(seconds(t), 1), [99 + t]) for t in (1, 2, 3)]
    assert [m.name for m in simulator.atomics] == ["b", "g", "r0", "r1", "r2", "sink"]


def test_a_model_removed_by_another_model_still_receives_the_messages_of_that_instant() -> None:
    g, sink = Generator("g", seconds(1)), Sink("sink")
    remover = Remover("x", "sink", seconds(3))
    simulator = started(coupled("yard", [g, sink, remover], (g.out, sink.into)))
    simulator.run(seconds(6))
    assert sink.got == [(Tag(seconds(t)), [t - 1]) for t in (1, 2, 3)]
    assert [m.name for m in simulator.atomics] == ["g", "x"]


def test_a_model_removed_during_a_run_sends_nothing() -> None:
    g, sink = Generator("g", seconds(1)), Sink("sink")
    started(coupled("yard", [g, sink, Remover("x", "g", seconds(2.5))], (g.out, sink.into))).run(seconds(6))
    assert sink.got == [(Tag(seconds(1)), [0]), (Tag(seconds(2)), [1])]


def test_couplings_between_models_can_be_added_and_removed_during_a_run() -> None:
    class Switch(Atomic):
        def start(self) -> None:
            self.hold_in(seconds(2))

        def internal(self) -> None:
            builder = self.parent
            assert isinstance(builder, Coupled)
            if self.now.t == seconds(2):
                builder.disconnect(g.out, left.into)
                builder.connect(g.out, right.into)
                self.hold_in(seconds(100))

    g, left, right = Generator("g", seconds(1)), Sink("left"), Sink("right")
    started(coupled("yard", [g, left, right, Switch("s")], (g.out, left.into))).run(seconds(5))
    assert [n for _, n in left.got] == [[0], [1]], "what was said at the instant of the change took the old way"
    assert [n for _, n in right.got] == [[2], [3]]


def test_adding_or_removing_models_keeps_the_schedule_and_the_elapsed_time_of_all_others() -> None:
    """A model whose neighbours change keeps its schedule and its elapsed time."""
    relay, g, b, sink = Relay("relay", seconds(2.5)), Generator("g", seconds(1), count=1), Breeder("b"), Sink("sink")
    simulator = started(coupled("yard", [g, b, relay, sink], (g.out, b.into), (g.out, relay.into)))
    simulator.trace = Trace()
    simulator.run(seconds(10))
    lines = [(line.tag, line.path, line.kind) for line in simulator.trace]
    assert (Tag(seconds(3.5)), "site.yard.relay", "internal") in lines


def test_changes_of_the_model_structure_between_runs_act_before_the_next_logical_time() -> None:
    g, sink = Generator("g", seconds(1)), Sink("sink")
    builder = coupled("yard", [g, sink], (g.out, sink.into))
    simulator = started(builder)
    simulator.run(seconds(1.5))
    late = builder.add(Sink("late"))
    builder.connect(g.out, late.into)
    simulator.run(seconds(3.5))
    assert late.got == [(Tag(seconds(2)), [1]), (Tag(seconds(3)), [2])]


def test_impossible_structure_changes_are_reported_with_place_and_time() -> None:
    simulator = started(coupled("yard", [Remover("x", "nobody", seconds(2))]))
    with pytest.raises(ModelError) as error:
        simulator.run(seconds(5))
    change = "in a change of the structure of site.yard at (2 s, 0)"
    message = f"site.yard: there is no child nobody to remove; it has x ({change})"
    assert str(error.value) == message


def test_adding_a_model_to_a_network_may_not_reduce_the_declared_lookahead_of_the_network() -> None:
    class Speaker(Atomic):
        out = Out(Item, lookahead=seconds(1))

    class Hasty(Atomic):
        out = Out(Item)

    class Adder(Remover):
        def internal(self) -> None:
            builder = self.parent
            assert isinstance(builder, Coupled)
            builder.connect(builder.add(Hasty("hasty")).out, builder.ports["out"])
            self.passivate()

    builder = coupled("yard", [speaker := Speaker("speaker"), Adder("adder", "", seconds(1))])
    builder.connect(speaker.out, builder.add_out("out", Item))
    site = coupled("site", [builder])
    site.connect(builder.ports["out"], site.add_out("out", Item))
    simulator = Simulator(site)
    simulator.start()
    with pytest.raises(ModelError) as error:
        simulator.run(seconds(5))
    assert str(error.value) == (
        "site at (1 s, 0): the lookahead of port out drops from 1000000000 ns to 0 ns, but other nodes rely on it; "
        "give the added models at least the former lookahead"
    )


def test_a_model_added_during_a_run_keeps_the_lookahead_that_it_has_when_added() -> None:
    class Hasty(Atomic):
        out = Out(Item, lookahead=seconds(1))

        def start(self) -> None:
            self.hold_in(seconds(0.5))

        def output(self) -> None:
            self.out.send(Item(1))

    class Adder(Remover):
        def internal(self) -> None:
            builder = self.parent
            assert isinstance(builder, Coupled)
            builder.add(Hasty("hasty"))
            self.passivate()

    with pytest.raises(ModelError) as error:
        started(coupled("yard", [Adder("adder", "", seconds(1))])).run(seconds(5))
    assert str(error.value) == (
        "site.yard.hasty at (1.5 s, 0): port out promises a lookahead of 1000000000 ns but sends 500000000 ns after "
        "the transition that scheduled the output; hold for longer or declare less"
    )


CHANGES: dict[str, Callable[[Coupled], object]] = {
    "add": lambda yard: yard.add(Sink("late")),
    "remove": lambda yard: yard.remove("sink"),
    "connect": lambda yard: yard.connect(yard.children["g"].ports["out"], yard.children["spare"].ports["into"]),
    "disconnect": lambda yard: yard.disconnect(*yard.couplings[0]),
    "add_in": lambda yard: yard.add_in("job", Item),
    "add_out": lambda yard: yard.add_out("done", Item),
}
WHEN = {"start": 0, "output": 1, "internal": 1, "external": 2}


class Restless(Atomic):
    """Due at 1 s; changes what is around it in one of its functions."""

    into = In(Item)

    def __init__(self, function: str, change: str) -> None:
        super().__init__("m")
        self.function, self.change = function, change

    def act(self, function: str) -> None:
        if function == self.function:
            assert self.parent is not None
            CHANGES[self.change](self.parent)

    def start(self) -> None:
        self.hold_in(seconds(1))
        self.act("start")

    def output(self) -> None:
        self.act("output")

    def internal(self) -> None:
        self.passivate()
        self.act("internal")

    def external(self, e: int, x: Bag) -> None:
        self.act("external")


def changing(function: str, change: str) -> Coupled:
    g, m, sink, spare = Generator("g", seconds(2), count=1), Restless(function, change), Sink("sink"), Sink("spare")
    return coupled("yard", [g, m, sink, spare], (g.out, sink.into), (g.out, m.into))


def run(builder: Coupled) -> None:
    simulator = Simulator(builder)
    simulator.start()
    simulator.run(seconds(5))


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("function", WHEN)
def test_a_model_cannot_change_the_structure_of_its_parent_during_a_transition(
    function: str, change: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    message = f"yard.m at ({WHEN[function]} s, 0): yard.{change} cannot be accessed: in a run each child of yard is a "
    with pytest.raises(ModelError, match=f"^{re.escape(message)}"):
        run(changing(function, change))
    if function != "output":
        drive(changing(function, change), until=seconds(5))  # what is driven alone is one node, which may
        monkeypatch.setattr(Coupled, "_reachable", lambda root, name: None)
        run(changing(function, change))


@pytest.mark.parametrize("change", CHANGES)
def test_the_root_model_of_a_simulation_may_change_between_runs(change: str) -> None:
    builder = changing("", change)
    simulator = Simulator(builder)
    simulator.start()
    simulator.run(seconds(1.5))
    CHANGES[change](builder)
    simulator.run(seconds(5))
    assert ("late" in builder.children, "sink" in builder.children) == (change == "add", change != "remove")
