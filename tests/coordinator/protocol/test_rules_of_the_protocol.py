"""The coordinator and a node, message by message: barrier, commit, windows and the end."""

from random import Random

import pytest
from clockwork import PAIR, Clockwork, Word, event, hello, started
from heavylift.coordinator.protocol import (
    AnyMessage,
    Bye,
    Coordinator,
    Coupling,
    Fail,
    Grant,
    GrantDone,
    Hello,
    Node,
    RunEnd,
    StopRun,
    Welcome,
    decode,
    encode,
)
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import FOREVER, Atomic, AtomicResult, Bag, Event, In, Out, Simulator, Slack, Tag
from in_memory import run_in_memory


def test_no_grant_is_sent_before_all_nodes_have_sent_hello() -> None:
    core = Coordinator(["a", "b"], PAIR)
    core.hello("a", hello(5, [event(5)]))
    assert (core.ready(), core.over) == ([], None)
    core.hello("b", hello(FOREVER.t))
    assert [name for name, _ in core.ready()] == ["a", "b"]


def test_a_committed_output_reaches_its_receiver_at_the_logical_time_of_the_output() -> None:
    core = Coordinator(["a", "b"], PAIR)
    core.hello("a", hello(5, [event(5)]))
    core.hello("b", hello(5, [event(5, "b")]))
    assert dict(core.ready()) == {
        "a": Grant(1, Tag(5, 1), (0, 1), True, [event(5, "b")]),
        "b": Grant(1, Tag(5, 1), (0, 1), True, [event(5)]),
    }
    assert core.running == 2
    assert core.ready() == []


def test_a_node_that_waits_for_its_first_input_delays_other_nodes_by_more_than_its_lookahead() -> None:
    core = Coordinator(["a", "b", "c"], [("a", "out", "b", "into"), ("b", "out", "c", "into")])
    core.hello("a", hello(5, [event(5)]))
    core.hello("b", hello(FOREVER.t, b=10))
    core.hello("c", hello(1))
    assert dict(core.ready())["c"].until == Tag(15)


def test_a_node_does_not_wait_for_silent_nodes_that_can_only_send_later_messages() -> None:
    core = Coordinator(["a", "b"], PAIR)
    for name in ("a", "b"):
        core.hello(name, Hello(Tag(5), [], Tag(5)))
    assert [name for name, _ in core.ready()] == ["a", "b"]


def test_an_earlier_input_cancels_an_offered_output_that_is_not_yet_committed() -> None:
    core = Coordinator(["a", "b"], [Coupling("a", "out", "b", "into")])
    core.hello("a", hello(5, [event(5)]))
    core.hello("b", hello(7, [event(7, "b")]))
    grants = dict(core.ready())
    assert not grants["b"].committed
    assert grants["b"].inputs == [event(5)]


def test_events_are_released_in_total_order_as_soon_as_no_earlier_event_is_possible() -> None:
    left: list[Event] = []
    core = Coordinator(["a", "b"], [], on_event=left.append)
    core.hello("a", hello(5, [event(5)]))
    core.hello("b", hello(3, [event(3, "b")]))
    core.ready()
    assert left == [event(3, "b")]
    core.done("a", GrantDone(1, FOREVER, [event(9)], FOREVER, [], FOREVER, b""))
    core.ready()
    assert left == [event(3, "b")]
    core.done("b", GrantDone(1, FOREVER, [event(7, "b")], FOREVER, [], FOREVER, b""))
    assert core.ready() == []
    assert (left, core.over) == ([event(3, "b"), event(5), event(7, "b"), event(9)], RunEnd.QUIET)


@pytest.mark.parametrize("order", range(5))
def test_a_run_ends_at_its_time_bound_or_at_its_ending_message_or_when_all_nodes_are_passive(order: int) -> None:
    message: list[Event] = []
    nodes = started(Clockwork("a", [5, 7, 9]), Clockwork("b", delay=0))
    core = Coordinator(["a", "b"], PAIR, Tag(9), on_event=message.append)
    assert run_in_memory(core, nodes, Random(order)) is RunEnd.BOUND
    assert [(e.t, e.k, e.source) for e in message] == [(5, 0, "a"), (5, 1, "b"), (7, 0, "a"), (7, 1, "b")]

    core = Coordinator(["a", "b"], PAIR)
    nodes = started(Clockwork("a", [5, 7, 9]), Clockwork("b", delay=0))
    assert run_in_memory(core, nodes, Random(order)) is RunEnd.QUIET

    message.clear()
    a, b = Clockwork("a", [5, 7, 9]), Clockwork("b", [12, 14], delay=0)
    core = Coordinator(["a", "b"], PAIR, finish=("a", "last"), on_event=message.append)
    assert run_in_memory(core, started(a, b), Random(order)) is RunEnd.FINISHED
    assert core.end == Tag(10)
    assert [(e.t, e.k, e.source, e.port) for e in message][-3:] == [
        (9, 0, "a", "last"),
        (9, 0, "a", "out"),
        (9, 1, "b", "out"),
    ]
    assert a.heard[-1] == (Tag(9, 1), 100)


def test_a_node_answers_a_repeated_grant_with_its_stored_done_message() -> None:
    (node,) = started(Clockwork("a", [5, 7]))
    node.hello()
    grant = Grant(1, Tag(6), None, True, [])
    done = node.handle(grant)
    assert isinstance(done, GrantDone)
    assert (done.reached, done.spoken, done.next) == (Tag(6), [], Tag(7))
    assert done.offer == [event(7, n=1, port="last"), event(7, n=1)]
    assert node.handle(grant) is done
    with pytest.raises(ProtocolError, match=r"^a got GRANT 3 after GRANT 1$"):
        node.handle(Grant(3, Tag(9), None, False, []))


def test_a_node_does_not_process_inputs_later_than_the_time_of_its_done_message() -> None:
    (node,) = started(Clockwork("a", delay=0))
    node.hello()
    inputs = [event(t, "b") for t in (5, 6)]
    done = node.handle(Grant(1, Tag(100), (0, 1), False, inputs))
    assert isinstance(done, GrantDone)
    assert (done.reached, [e.tag for e in done.spoken], done.next) == (Tag(5, 2), [Tag(5, 1)], FOREVER)


def test_the_digest_depends_on_every_event_and_on_their_order() -> None:
    hashes = []
    for n in (1, 1, 2):
        (node,) = started(Clockwork("a", delay=0))
        node.hello()
        done = node.handle(Grant(1, Tag(100), None, False, [event(5, "b", n)]))
        assert isinstance(done, GrantDone)
        hashes.append(done.hash)
    assert hashes[0] == hashes[1] != hashes[2]


def test_the_first_message_of_a_run_is_welcome_and_the_last_is_stop() -> None:
    ends: list[Tag] = []

    def finish(end: Tag) -> str:
        ends.append(end)
        return "still waiting for b"

    node = Node("a", Simulator(Clockwork("a")), finish)
    assert (node.handle(Welcome(3)), node.epoch) == (None, 3)
    node.hello()
    assert (node.handle(StopRun(Tag(9))), ends) == (Bye("still waiting for b"), [Tag(9)])
    (quiet,) = started(Clockwork("c"))
    quiet.hello()
    assert quiet.handle(StopRun(Tag(9))) == Bye()
    for message in (Bye(), hello(3), Fail(Tag(0), "a", "", "")):
        with pytest.raises(ProtocolError, match=rf"^a does not accept the message {type(message).__name__.upper()}$"):
            node.handle(message)


def test_the_last_message_of_a_node_reports_the_largest_lookahead_that_its_ports_could_have_declared() -> None:
    class Slow(Atomic):
        into, out, other = In(Word), Out(Word, lookahead=10), Out(Word)

        def start(self) -> None:
            self.hold_in(3)

        def output(self) -> None:
            (self.other if self.now.t == 3 else self.out).send(Word(1))

        def external(self, e: int, x: Bag) -> None:
            self.hold_in(10 + x[self.into][0].n)

        def internal(self) -> None:
            self.passivate()

    node = Node("a", Simulator(Slow("a"), wires=[("b", "out", "a", "into"), ("a", "out", "b", "into")]))
    node.hello()
    for gseq, (t, n) in enumerate([(10, 7), (40, 5), (60, 9)], 1):
        node.handle(Grant(gseq, Tag(t + 20), None, True, [event(t, "b", n)]))
    assert node.handle(StopRun(Tag(90))) == Bye(slack=[Slack("a.out", declared_ns=10, observed_ns=15, count=3)])


def test_valid_messages_are_decoded_unchanged_and_invalid_ones_are_refused() -> None:
    messages: list[AnyMessage] = [
        hello(3, [event(3)]),
        Welcome(1, b"x"),
        Grant(1, FOREVER, (5, 0), True, [event(2)]),
        GrantDone(1, Tag(3), [event(2)], Tag(4), [], Tag(4, 1), b"h", Tag(2)),
        Fail(Tag(3), "a.b", "it broke", ""),
        StopRun(Tag(3), "finished"),
        Bye("a waits", 0.5, [Slack("a.out", 10, 15, 3)], [AtomicResult("a.b", "Word", b"w")]),
    ]
    for message in messages:
        assert decode(encode(message)) == message
    for data in (b"", b"\x81\xa4type\xa5ghost", encode(Welcome(1))[:-2]):
        with pytest.raises(ProtocolError, match=r"^not a message of the time protocol: "):
            decode(data)
