"""What is easily got wrong in a time protocol, one story each; and why its two shortest simplifications fail."""

from itertools import permutations
from random import Random

import pytest
from heavylift.coordinator.protocol import Coordinator, Grant, GrantDone, Hello, Node, RunEnd
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import FOREVER, Atomic, Bag, Event, In, Message, Out, Simulator, Tag, encode
from in_memory import run_in_memory
from mutants import MUTANTS


class Count(Message):
    n: int


class Timer(Atomic):
    """Says 1, 2, 3 ... at its times [ns]; `log` has what moved it: (t, k, i | e | c, what it heard)."""

    into, out = In(Count), Out(Count)

    def __init__(self, name: str, *times: int, lookahead: int = 0) -> None:
        super().__init__(name)
        self.times, self.out.lookahead = times, lookahead

    def start(self) -> None:
        self.n, self.log = 0, list[tuple[int, int, str, list[int]]]()
        self.wait()

    def wait(self) -> None:
        if self.n < len(self.times):
            self.hold_in(self.times[self.n] - self.now.t)
        else:
            self.passivate()

    def output(self) -> None:
        self.out.send(Count(self.n + 1))

    def internal(self) -> None:
        self.note("i")
        self.n += 1
        self.wait()

    def external(self, e: int, x: Bag) -> None:
        self.note("e", x)

    def confluent(self, x: Bag) -> None:
        self.note("c", x)
        self.n += 1
        self.wait()

    def note(self, kind: str, x: Bag | None = None) -> None:
        self.log.append((*self.now, kind, [count.n for count in x[self.into]] if x else []))


def lines(core: Coordinator, *timers: Timer, order: int = 0) -> dict[str, list[tuple[int, int, str, list[int]]]]:
    run_in_memory(core, [Node(timer.name, Simulator(timer, wires=core._couplings)) for timer in timers], Random(order))
    return {timer.name: timer.log for timer in timers}


def event(t: int, source: str = "a", n: int = 1, k: int = 0) -> Event:
    return Event(t, k, source, "out", 0, "Count", encode(Count(n)))


TO_C = [("a", "out", "c", "into"), ("b", "out", "c", "into"), ("d", "out", "c", "into")]
ONE_WAY = [("a", "out", "b", "into")]


def test_simultaneous_events_are_ordered_by_source_whichever_node_answers_first() -> None:
    for order in permutations("abd"):
        core = Coordinator("abcd", TO_C)
        for name in "abcd":
            core.hello(name, Hello(FOREVER if name == "c" else Tag(1), [], FOREVER if name == "c" else Tag(1, 1)))
        assert [name for name, _ in core.ready()] == ["a", "b", "d"]
        for name in order:
            core.done(name, GrantDone(1, Tag(1, 1), [], Tag(2), [event(2, name)], Tag(2), b""))
        grants = dict(core.ready())
        assert [event.source for event in grants["c"].inputs] == ["a", "b", "d"]


def test_a_message_causes_a_transition_of_a_passive_model() -> None:
    log = lines(Coordinator("ab", ONE_WAY), Timer("a", 5, 9), Timer("b"))
    assert log["b"] == [(5, 0, "e", [1]), (9, 0, "e", [2])]


def test_a_node_that_has_an_event_at_the_time_of_a_message_makes_a_confluent_transition() -> None:
    for order in range(6):
        log = lines(Coordinator("ab", ONE_WAY), Timer("a", 5), Timer("b", 5), order=order)
        assert log["b"] == [(5, 0, "c", [1])]


def test_a_model_that_schedules_its_next_event_with_zero_delay_has_it_one_microstep_later() -> None:
    for order in range(6):
        log = lines(Coordinator("ab", ONE_WAY), Timer("a", 5, 5, 5), Timer("b", 5, 5), order=order)
        assert log["b"] == [(5, 0, "c", [1]), (5, 1, "c", [2]), (5, 2, "e", [3])]


def test_a_run_ends_at_its_time_bound_even_if_messages_for_later_times_are_pending() -> None:
    left: list[Event] = []
    core = Coordinator("ab", [], Tag(9), on_event=left.append)
    core.hello("a", Hello(Tag(5), [event(5)], Tag(5)))
    core.hello("b", Hello(FOREVER, [], FOREVER))
    assert [(name, grant.until) for name, grant in core.ready()] == [("a", Tag(9))]
    core.done("a", GrantDone(1, Tag(9), [], Tag(9), [event(9, n=2)], Tag(9), b""))
    assert (core.ready(), core.over, left) == ([], RunEnd.BOUND, [event(5)])


def test_messages_later_than_the_event_that_ends_the_run_are_not_delivered() -> None:
    left: list[Event] = []
    core = Coordinator("ab", ONE_WAY, finish=("a", "out"), on_event=left.append)
    log = lines(core, Timer("a", 5, 5, 6), Timer("b", 7))
    assert (core.end, core.over, left) == (Tag(6), RunEnd.FINISHED, [event(5), event(5, n=2, k=1)])
    assert log["b"] == [(5, 0, "e", [1]), (5, 1, "e", [2])]


def test_a_repeated_grant_gets_the_stored_done_message_which_the_coordinator_counts_once() -> None:
    timer = Timer("a", 5)
    node = Node("a", Simulator(timer))
    core = Coordinator("a", [])
    core.hello("a", node.hello())  # type: ignore[arg-type]
    ((_, grant),) = core.ready()
    done = node.handle(grant)
    assert isinstance(done, GrantDone)
    assert node.handle(grant) is done
    assert timer.log == [(5, 0, "i", [])]
    core.done("a", done)
    with pytest.raises(ProtocolError) as error:
        core.done("a", done)
    assert str(error.value) == "a sent DONE 1 out of order; its last GRANT was 1"
    with pytest.raises(ProtocolError) as error:
        node.handle(Grant(4, FOREVER, None, False, []))
    assert str(error.value) == "a got GRANT 4 after GRANT 1"


def test_a_node_that_sends_hello_twice_is_refused() -> None:
    core = Coordinator("ab", ONE_WAY)
    core.hello("a", Hello(Tag(5), [], Tag(5, 1)))
    with pytest.raises(ProtocolError) as error:
        core.hello("a", Hello(Tag(5), [], Tag(5, 1)))
    assert str(error.value) == "a sent HELLO twice: two nodes have this name, or an earlier process has reconnected"


def test_a_message_sent_into_the_past_is_refused_with_its_port() -> None:
    core = Coordinator("ab", [("a", "out", "b", "into"), ("b", "out", "a", "into")])
    core.hello("a", Hello(Tag(5), [event(5)], Tag(5)))
    core.hello("b", Hello(FOREVER, [], FOREVER, {"b.out": 10, "b.quick": 0}))
    core.ready()
    with pytest.raises(ProtocolError) as error:
        core.done("b", GrantDone(1, Tag(5, 1), [], Tag(14), [event(14, "b")], Tag(14), b""))
    assert str(error.value) == (
        "b sent an event on port out at (0.000000014 s, 0), earlier than the (0.000000015 s, 0) that it had declared: "
        "the lookahead of that port is too long"
    )


def test_a_message_that_arrives_too_late_is_refused_with_its_sender() -> None:
    node = Node("b", Simulator(Timer("b", 7), wires=ONE_WAY))
    node.hello()
    node.handle(Grant(1, Tag(9), None, True, []))
    fail = node.handle(Grant(2, Tag(20), None, False, [event(6)]))
    assert fail.sentence == "b at (0.000000007 s, 0): message from a.out is late: due at (0.000000006 s, 0)"  # type: ignore[union-attr]


def test_outputs_delayed_by_a_microstep_would_prevent_a_confluent_transition() -> None:
    """Two nodes, one message: b's own event and a's message meet at (5, 0); at (5, 1) b has moved alone already."""
    log = lines(Coordinator("ab", ONE_WAY), Timer("a", 5), Timer("b", 5))
    assert log["b"] == [(5, 0, "c", [1])] != [(5, 0, "i", []), (5, 1, "e", [1])]


def test_grants_up_to_the_next_event_plus_lookahead_would_let_messages_arrive_too_late(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two nodes, one message: a is due at 5 since the start, and its lookahead of 10 says nothing of that."""

    def window_of_b() -> Tag:
        core = Coordinator("ab", [("a", "out", "b", "into"), ("b", "out", "a", "into")])
        core.hello("a", Hello(Tag(5), [event(5)], Tag(5), {"a.out": 10}))
        core.hello("b", Hello(Tag(3), [], Tag(3, 1), {"b.out": 0}))
        return dict(core.ready())["b"].until

    assert window_of_b() == Tag(5)
    MUTANTS["a_scheduled_output_has_lookahead"](monkeypatch)
    assert window_of_b() == Tag(15)  # and at (5, 0) the message of a is late
