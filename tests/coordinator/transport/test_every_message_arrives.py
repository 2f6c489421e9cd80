"""Round trips, bursts and large messages over both transports: in order, each once, none lost."""

import time

import pytest
from heavylift.coordinator.transport import LocalHub
from heavylift.kernel import ProtocolError
from of_the_system import Start


def test_each_node_process_receives_and_answers_its_own_messages(start: Start) -> None:
    hub, _ = start(west=(), east=())
    for number in range(100):
        hub.send("west", b"to west %d" % number)
        hub.send("east", b"to east %d" % number)
        answers = {hub.receive(5), hub.receive(5)}
        assert answers == {("west", b"to west %d" % number), ("east", b"to east %d" % number)}


def test_nodes_started_in_new_interpreters_behave_like_nodes_in_forked_processes(start: Start) -> None:
    hub, _ = start(fork=False, west=())
    hub.send("west", b"x")
    assert hub.receive(5) == ("west", b"x")


def test_a_burst_of_messages_arrives_without_loss(start: Start) -> None:
    hub, _ = start(west=("burst", "20000"))
    hub.send("west", b"go")
    time.sleep(0.3)  # longer than the queues on the way can hold
    assert [hub.receive(5) for _ in range(20_000)] == [
        ("west", number.to_bytes(4, "little")) for number in range(20_000)
    ]


def test_a_large_message_to_a_node_passes_unchanged(start: Start) -> None:
    hub, _ = start(west=())
    large = bytes(range(256)) * 4096
    hub.send("west", large)
    assert hub.receive(10) == ("west", large)


def test_samples_that_a_node_sends_before_its_answer_arrive_before_the_answer(start: Start) -> None:
    hub, _ = start(west=())
    for _ in range(50):
        hub.send("west", b"sample")
        assert hub.receive(5) == ("west", b"sample")
        assert hub.samples() == [("west", b"batch 0"), ("west", b"batch 1"), ("west", b"batch 2")]
        assert hub.samples() == []


def test_messages_that_a_node_sends_just_before_leaving_arrive(start: Start) -> None:
    hub, _ = start(west=("burst", "300"))
    hub.dismiss(b"go")
    assert [hub.receive(5) for _ in range(300)][-1] == ("west", (299).to_bytes(4, "little"))


def test_waiting_for_a_message_ends_at_the_timeout_if_none_arrives(start: Start) -> None:
    hub, _ = start(west=())
    for timeout in (0.0, 0.05, 0.3):
        begin = time.monotonic()
        assert hub.receive(timeout) is None
        assert time.monotonic() - begin >= timeout
    hub.send("west", b"x")
    assert hub.receive(5) == ("west", b"x")


def test_several_nodes_in_one_process_answer_in_the_order_of_the_messages() -> None:
    with LocalHub(["west", "kernel"]) as hub:
        for node in hub.nodes:
            link = hub.link(node)
            link.serve(lambda message, link=link: link.send(message + b" heard"))  # type: ignore[misc]
        for number in range(1000):
            hub.send("kernel", b"%d" % number)
            hub.send("west", b"%d" % number)
            assert hub.receive() == ("kernel", b"%d heard" % number)
            assert hub.receive() == ("west", b"%d heard" % number)


def test_a_run_in_one_process_also_transmits_bursts_of_messages_and_large_messages() -> None:
    with LocalHub(["west"]) as hub:
        link = hub.link("west")
        for number in range(20_000):
            link.send(b"%d" % number)
        link.sample(b"s" * 1_000_000)
        assert [hub.receive() for _ in range(20_000)][-1] == ("west", b"19999")
        assert hub.samples() == [("west", b"s" * 1_000_000)]


def test_an_exception_in_a_node_reaches_a_coordinator_in_the_same_process() -> None:
    def handle(message: bytes) -> None:
        raise ZeroDivisionError("a mass of zero")

    with LocalHub(["west"]) as hub:
        hub.link("west").serve(handle)
        hub.send("west", b"go")
        with pytest.raises(ZeroDivisionError, match="a mass of zero"):
            hub.receive()


def test_a_run_without_nodes_reports_an_error_if_it_is_asked_to_receive_a_message() -> None:
    with LocalHub(["west"]) as hub:
        assert hub.receive(timeout=5) is None
        with pytest.raises(ProtocolError, match="no node of this process has a message to answer"):
            hub.receive()
        with pytest.raises(ProtocolError, match="node west waits for a message that nobody"):
            hub.link("west").receive()
