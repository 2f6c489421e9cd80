"""Conformance of one atomic: schedules, elapsed time, output before transition, the half-open run."""

import pytest
from devs_stories import Generator, Item, Relay, kinds, run
from heavylift.kernel import ModelError
from heavylift.nodes.devs import (
    FOREVER,
    NEVER,
    Atomic,
    Bag,
    In,
    Out,
    Simulator,
    Tag,
    Transition,
    after,
    ms,
    seconds,
    succ,
)


class Shot(Atomic):
    def __init__(self, wait: int) -> None:
        super().__init__("shot")
        self.wait = wait

    def start(self) -> None:
        self.hold_in(self.wait)

    def internal(self) -> None:
        self.passivate()


def test_an_atomic_model_scheduled_once_has_one_transition_and_a_passive_model_has_none() -> None:
    assert run(Shot(seconds(5)), 100) == [(5.0, 0, "shot", "internal")]
    assert run(Shot(NEVER), 100) == []


def test_a_generator_with_a_period_of_2_s_makes_five_transitions_before_9_s() -> None:
    assert [t for t, _, _, _ in run(Generator("g", seconds(2), first=0), 9)] == [0, 2, 4, 6, 8]


def test_the_output_function_is_called_before_an_internal_transition_and_may_be_called_repeatedly() -> None:
    g = Generator("g", seconds(10))
    simulator = Simulator(g)
    simulator.start()
    for tick in range(10):
        assert simulator.next_time == Tag(seconds(10) * (tick + 1))
        assert [e.value for e in simulator.outputs()] == [Item(tick)] == [e.value for e in simulator.outputs()]
        assert g.n == tick
        simulator.advance(simulator.next_time)
        assert g.n == tick + 1


def test_a_generator_model_that_receives_an_input_before_its_first_output_sends_nothing() -> None:
    g = Generator("g", seconds(10))
    simulator = Simulator(g)
    simulator.start()
    simulator.inject("stop", Item(0))
    simulator.advance(Tag(seconds(5)))
    assert (simulator.next_time, g.n, simulator.outputs()) == (FOREVER, 0, [])


def test_a_relay_model_changes_its_state_only_when_it_receives_or_sends_a_message() -> None:
    log: list[Transition] = []
    simulator = Simulator(Relay("r", seconds(1)), log.append)
    simulator.start()
    simulator.inject("into", Item(1))
    simulator.advance(Tag(0))
    simulator.run()
    assert log == [
        Transition(Tag(0), "r", "external", (("into", Item(1)),), ()),
        Transition(Tag(seconds(1)), "r", "internal", (), (("out", Item(1)),)),
    ]


def test_the_elapsed_time_of_a_model_counts_from_its_last_transition() -> None:
    relay = Relay("r", seconds(100))
    simulator = Simulator(relay)
    simulator.start()
    for t in (seconds(0.5), seconds(1.25)):
        simulator.inject("into", Item(1))
        simulator.advance(Tag(t))
    assert relay.elapsed == [seconds(0.5), seconds(0.75)]


def test_an_external_transition_that_sets_no_new_schedule_keeps_the_old_one() -> None:
    class Busy(Generator):
        def external(self, e: int, x: Bag) -> None:
            pass

    simulator = Simulator(Busy("b", seconds(10)))
    simulator.start()
    simulator.inject("stop", Item(0))
    simulator.advance(Tag(seconds(9)))
    assert simulator.next_time == Tag(seconds(10))


def test_an_input_at_the_scheduled_time_causes_one_confluent_transition_with_zero_elapsed_time() -> None:
    relay = Relay("r", seconds(1))
    log: list[Transition] = []
    simulator = Simulator(relay, log.append)
    simulator.start()
    for t in (0, seconds(1)):
        simulator.inject("into", Item(t))
        simulator.advance(Tag(t))
    assert [line.kind for line in log] == ["external", "confluent"]
    assert relay.elapsed == [0, 0]
    assert (relay.held, simulator.next_time) == ([Item(seconds(1))], Tag(seconds(2)))


def test_a_confluent_transition_can_be_overridden_and_never_occurs_without_an_input() -> None:
    class Patient(Relay):
        def confluent(self, x: Bag) -> None:
            self.held = [Item(-1)]
            self.hold_in(seconds(5))

    simulator = Simulator(Patient("p", seconds(1)))
    simulator.start()
    for t in (0, seconds(1)):
        simulator.inject("into", Item(1))
        simulator.advance(Tag(t))
    assert [(e.tag, e.value) for e in simulator.outputs()] == [(Tag(seconds(6)), Item(-1))]
    assert kinds(Patient("p", first=3), 1) == {"p": "i"}


def test_a_simulator_refuses_to_advance_past_the_next_transition_or_into_the_past() -> None:
    simulator = Simulator(Generator("g", seconds(1)))
    simulator.start()
    with pytest.raises(ModelError, match=r"^g: cannot advance to \(2 s, 0\): the next transition is"):
        simulator.advance(Tag(seconds(2)))
    simulator.advance(Tag(seconds(1)))
    with pytest.raises(ModelError, match=r"^g at \(1 s, 0\): late message: \(0.5 s, 0\) has already passed$"):
        simulator.advance(Tag(seconds(0.5)))


def test_a_simulator_run_stops_before_its_end_time_and_can_be_continued() -> None:
    def log_of(*ends: int) -> list[Transition]:
        log: list[Transition] = []
        simulator = Simulator(Generator("g", seconds(1)), log.append)
        simulator.start()
        for end in ends:
            simulator.run(end)
        return log

    assert [line.tag.t for line in log_of(seconds(3))] == [seconds(1), seconds(2)]
    assert log_of(seconds(3), seconds(6)) == log_of(seconds(6))


def test_starting_a_simulator_again_begins_a_new_run_and_does_not_affect_other_simulators() -> None:
    log: list[Transition] = []
    simulator = Simulator(Generator("g", seconds(1)), log.append)
    other = Simulator(Generator("g", seconds(7)))
    other.start()
    simulator.start()
    simulator.run(seconds(5))
    first = log.copy()
    log.clear()
    other.run(seconds(50))
    simulator.start()
    simulator.run(seconds(5))
    assert log == first


def test_logical_times_are_ordered_by_time_and_then_by_microstep() -> None:
    assert after(Tag(1, 1), 0) == succ(Tag(1, 1)) == Tag(1, 2)
    assert after(Tag(1, 3), 4) == Tag(5, 0)
    assert Tag(1, 9) < Tag(2, 0) < Tag(2, 1) < FOREVER == after(FOREVER, 5) == succ(FOREVER) == after(Tag(3), NEVER)
    assert [seconds(0.1), ms(2.5), seconds(1e-9 / 3)] == [100_000_000, 2_500_000, 0]
    assert [str(t) for t in (Tag(seconds(1.5), 2), Tag(-1), FOREVER)] == [
        "(1.5 s, 2)",
        "(-0.000000001 s, 0)",
        "(forever)",
    ]


def test_ports_are_declared_on_the_model_class_and_bound_to_each_instance() -> None:
    class Both(Atomic):
        here, there = In(Item), Out(Item, lookahead=ms(10))

    both = Both("b")
    extra = both.add_in("more", Item)
    assert (repr(both.here), repr(both.there), both.there.lookahead) == ("b.here", "b.there", 10_000_000)
    assert list(both.ports) == ["here", "there", "more"]
    assert extra is both.ports["more"]
