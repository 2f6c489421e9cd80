"""What Zenoh's defaults would lose, and what our settings and frames make of it.

A trap that can be shown without a hang is shown twice: that it is there, and that a run does not fall into it.
"""

import os
import sys
import time
from pathlib import Path

import pytest
import zenoh
from heavylift.coordinator.transport import FrameReader, FrameTopic, Hub, NodeLink, Writer, key, node_session
from heavylift.coordinator.transport.session import _config
from heavylift.kernel import ProtocolError
from of_the_system import Start, network_sockets
from raw_sessions import config, heard_by_a_sleeper, listened, pair, settled
from zenoh.handlers import Callback

BURST = 30_000
BLOCK, DROP = zenoh.CongestionControl.BLOCK, zenoh.CongestionControl.DROP
SLEEP_s = 0.6  # of a reader
SHORT_us = 200_000  # in place of Zenoh's 5 s before a blocked transport is closed, so that the story is short


@pytest.mark.large
def test_a_burst_of_messages_that_zenoh_would_drop_by_default_arrives_without_loss(tmp_path: Path) -> None:
    assert len(heard_by_a_sleeper(tmp_path, BURST, DROP, SLEEP_s)) < BURST
    assert heard_by_a_sleeper(tmp_path, BURST, BLOCK, SLEEP_s) == list(range(BURST))


def test_a_reader_that_pauses_longer_than_zenoh_blocks_loses_no_message(tmp_path: Path) -> None:
    """With the shortened wait the transport is closed without an error; ours waits ten minutes, twice any lease."""
    assert len(heard_by_a_sleeper(tmp_path, BURST, BLOCK, SLEEP_s, SHORT_us)) < BURST
    queue = _config("client")["transport"]["link"]["tx"]["queue"]
    assert queue["congestion_control"]["block"]["wait_before_close"] == 600_000_000


@pytest.mark.skipif(sys.platform != "linux", reason="watches processes in /proc, which only Linux has")
def test_a_default_zenoh_session_listens_to_the_network_and_a_session_of_heavylift_does_not() -> None:
    before = network_sockets(os.getpid())
    with zenoh.open(zenoh.Config()):
        kinds = {line.split()[0].rstrip("6") for line in network_sockets(os.getpid()) if line not in before}
    assert kinds == {"tcp", "udp"}
    with Hub(["west"]):
        assert network_sockets(os.getpid()) == before


def test_zenoh_loses_messages_before_a_subscriber_is_known_so_the_hub_waits_for_it(tmp_path: Path) -> None:
    heard: list[bytes] = []
    with pair(tmp_path) as (hub, client):
        for number in range(10):
            publisher = hub.declare_publisher(f"at/{number}", congestion_control=BLOCK)
            publisher.put(b"early")
            client.declare_subscriber(
                f"at/{number}", Callback(lambda s: heard.append(s.payload.to_bytes()), indirect=False)
            )
            listened(publisher)
            publisher.put(b"known")
        settled(heard)
    assert heard == [b"known"] * 10


def test_all_messages_use_one_priority_since_zenoh_messages_of_higher_priority_overtake_others(tmp_path: Path) -> None:
    heard: list[int] = []
    with pair(tmp_path) as (hub, client):

        def read(sample: zenoh.Sample) -> None:
            time.sleep(0.0001)
            heard.append(int.from_bytes(sample.payload.to_bytes()[:4], "little"))

        hub.declare_subscriber("order/*", Callback(read, indirect=False))
        slow = client.declare_publisher("order/low", congestion_control=BLOCK, priority=zenoh.Priority.BACKGROUND)
        fast = client.declare_publisher("order/high", congestion_control=BLOCK, priority=zenoh.Priority.REAL_TIME)
        listened(fast)
        for number in range(3000):
            (fast if number % 100 == 99 else slow).put(number.to_bytes(4, "little") + bytes(1000))
        settled(heard)
    assert sorted(heard) == list(range(3000))
    assert heard != sorted(heard)
    with Hub(["west"]) as run, NodeLink(run.ticket("west")) as link:
        sender = link._senders["west"]
        for publisher in (run._publishers["west"], sender._out, sender._samples):
            assert publisher.priority == zenoh.Priority.DATA
            assert publisher.congestion_control == BLOCK


def test_more_liveliness_tokens_than_the_default_zenoh_channel_holds_are_all_received(tmp_path: Path) -> None:
    """The default channel holds 256 and then stops the session; a hub takes them by a callback."""
    heard: list[str] = []
    with pair(tmp_path) as (hub, client):
        hub.liveliness().declare_subscriber("alive/*", Callback(lambda s: heard.append(str(s.kind)), indirect=False))
        tokens = [client.liveliness().declare_token(f"alive/{number}") for number in range(600)]
        settled(heard)
        assert len(heard) == 600
        for token in tokens:
            token.undeclare()  # type: ignore[no-untyped-call]
        settled(heard)
        assert len(heard) == 1200


def test_messages_sent_while_the_hub_restarts_are_lost_and_the_loss_is_reported(tmp_path: Path) -> None:
    heard: list[bytes] = []
    writer, reader = Writer("run", "west", FrameTopic.OUT, 1), FrameReader("run", "west", FrameTopic.OUT, 1)
    at = [f"unixsock-stream/{tmp_path / 's'}"]
    hub = zenoh.open(config("peer", listen=at))
    with zenoh.open(config("client", connect=at)) as client:
        publisher = client.declare_publisher("out", congestion_control=BLOCK)
        for words in ((b"before",), (b"after",)):
            subscriber = hub.declare_subscriber(
                "out", Callback(lambda s: heard.append(s.payload.to_bytes()), indirect=False)
            )
            listened(publisher)
            for word in words:
                publisher.put(writer.frame(word))
            settled(heard)
            if words == (b"before",):
                subscriber.undeclare()  # type: ignore[no-untyped-call]
                hub.close()  # type: ignore[no-untyped-call]
                publisher.put(writer.frame(b"meanwhile"))
                (tmp_path / "s").unlink(missing_ok=True)
                hub = zenoh.open(config("peer", listen=at))
    hub.close()  # type: ignore[no-untyped-call]
    assert len(heard) == 2
    assert reader.open(heard[0]) == b"before"
    with pytest.raises(ProtocolError, match=r"message 2 arrived out of sequence \(messages were lost\)"):
        reader.open(heard[1])


def test_a_node_does_not_receive_messages_for_other_nodes(start: Start) -> None:
    heard: list[bytes] = []
    hub, _ = start(west=())
    with node_session(hub.ticket("west")) as session:
        for pattern in ("**", key(hub.run, "in", "*", "*"), key(hub.run, "out", "**"), key(hub.run, "samples", "**")):
            session.declare_subscriber(pattern, lambda sample: heard.append(sample.payload.to_bytes()))
        for _ in range(3):
            hub.send("west", b"sample")
            assert hub.receive(5) == ("west", b"sample")
        settled(heard)
    assert heard == []


@pytest.mark.parametrize("size", [65_535, 65_536, 65_537, 16 * 2**20])
def test_messages_beyond_64_KiB_pass_unchanged(start: Start, size: int) -> None:
    """The low-latency transport loses them silently: it is off."""
    assert _config("client")["transport"]["unicast"]["lowlatency"] is False
    hub, _ = start(west=())
    message = bytes(range(251)) * (size // 251 + 1)
    hub.send("west", message[:size])
    assert hub.receive(20) == ("west", message[:size])
