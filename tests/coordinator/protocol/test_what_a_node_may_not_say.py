"""What a node may not say, and what it answers when its model does what it may not."""

import pytest
from clockwork import PAIR, Clockwork, event, hello, started
from heavylift.coordinator.protocol import Coordinator, Fail, Grant, GrantDone
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import FOREVER, Tag


def test_messages_that_the_protocol_forbids_to_nodes_are_refused() -> None:
    core = Coordinator(["a", "b"], PAIR)
    with pytest.raises(ProtocolError, match=r"^x is not a node of this run; its nodes are a, b$"):
        core.hello("x", hello(1))
    core.hello("a", hello(5, [event(5)]))
    with pytest.raises(ProtocolError, match=r"^a sent HELLO twice"):
        core.hello("a", hello(5))
    core.hello("b", hello(FOREVER.t))
    done = GrantDone(1, FOREVER, [], FOREVER, [], FOREVER, b"")
    with pytest.raises(ProtocolError, match=r"^a sent DONE 1 out of order; its last GRANT was 0$"):
        core.done("a", done)
    core.ready()
    with pytest.raises(ProtocolError, match=r"^a sent an event of b: a node sends events of its own models only$"):
        core.done("a", GrantDone(1, FOREVER, [event(6, "b")], FOREVER, [], FOREVER, b""))
    with pytest.raises(ProtocolError, match=r"^a offers a\.out at \(0.000000007 s, 0\): an offer holds its own"):
        core.done("a", GrantDone(1, Tag(5, 1), [], Tag(8), [event(7)], Tag(8), b""))
    core = Coordinator(["a", "b"], PAIR)
    core.hello("a", hello(5, [event(5)]))
    core.hello("b", hello(FOREVER.t))
    core.ready()
    early = r"^a sent an event on port out at \(0.000000005 s, 0\), earlier than the \(0.000000005 s, 1\)"
    with pytest.raises(ProtocolError, match=early):
        core.done("a", GrantDone(1, FOREVER, [event(5)], FOREVER, [], FOREVER, b""))


@pytest.mark.parametrize(("reached", "then"), [(Tag(6), Tag(8)), (Tag(5, 1), Tag(4))])
def test_a_done_message_of_a_node_covers_exactly_the_events_of_its_last_grant(reached: Tag, then: Tag) -> None:
    core = Coordinator(["a", "b"], PAIR)
    core.hello("a", hello(5, [event(5)]))
    core.hello("b", hello(FOREVER.t))
    core.ready()
    with pytest.raises(ProtocolError) as error:
        core.done("a", GrantDone(1, reached, [], then, [], then, b""))
    assert str(error.value) == (
        f"a has done all before {reached} and goes on at {then}: a DONE reaches at most the end of its GRANT, "
        "(0.000000005 s, 1), and leaves nothing undone"
    )


def test_a_node_that_sends_earlier_than_its_lookahead_is_reported_with_its_port() -> None:
    (node,) = started(Clockwork("a", delay=10))
    node.model.lookahead = {"a.out": 50}  # type: ignore[misc]
    node.hello()
    fail = node.handle(Grant(1, Tag(100), None, False, [event(5, "b")]))
    assert isinstance(fail, Fail)
    assert fail.sentence == (
        "a at (0.000000015 s, 0): output on port out before (0.000000055 s, 0), the earliest time that its declared "
        "lookahead allows; "
        "declare a shorter lookahead"
    )


def test_a_late_message_ends_the_run_and_is_reported_by_name() -> None:
    (node,) = started(Clockwork("a", [5]))
    node.hello()
    node.handle(Grant(1, Tag(6), None, True, []))
    fail = node.handle(Grant(2, Tag(9), None, False, [event(4, "b")]))
    assert isinstance(fail, Fail)
    assert fail.sentence == "a at (0.000000005 s, 0): message from b.out is late: due at (0.000000004 s, 0)"


def test_an_exception_in_model_code_becomes_a_fail_message_with_sentence_and_traceback() -> None:
    class Broken(Clockwork):
        def internal(self) -> None:
            raise ValueError("no rope")

    (node,) = started(Broken("a", [5]))
    node.hello()
    fail = node.handle(Grant(1, Tag(6), None, True, []))
    assert isinstance(fail, Fail)
    line = Broken.internal.__code__.co_firstlineno + 1
    message = f"internal() raised ValueError: no rope (test_what_a_node_may_not_say.py:{line})"
    assert fail.sentence == f"a at (0.000000005 s, 0): {message}"
    assert "in internal" in fail.traceback
