"""A damaged, foreign, repeated or missing message ends in one sentence that says what arrived."""

import json

import pytest
import zenoh
from heavylift.coordinator.transport import LOCAL, FrameReader, FrameTopic, Hub, LocalHub, Writer, key
from heavylift.kernel import ProtocolError

RUN = "0123456789abcdef"


def reader() -> FrameReader:
    return FrameReader(RUN, "west", FrameTopic.OUT, 1)


def writer(run: str = RUN, node: str = "west", topic: FrameTopic = FrameTopic.OUT, epoch: int = 1) -> Writer:
    return Writer(run, node, topic, epoch)


def refusal(frame: bytes) -> str:
    with pytest.raises(ProtocolError) as error:
        reader().open(frame)
    return str(error.value)


def test_message_frames_received_in_order_are_decoded_to_their_payloads() -> None:
    w, r = writer(), reader()
    assert [r.open(w.frame(p)) for p in (b"", b"a", b"b" * 1_000_000)] == [b"", b"a", b"b" * 1_000_000]


def test_every_single_flipped_bit_of_a_message_frame_is_detected() -> None:
    frame = writer().frame(b"grant")
    for bit in range(8 * len(frame)):
        damaged = bytearray(frame)
        damaged[bit // 8] ^= 1 << bit % 8
        with pytest.raises(ProtocolError):
            reader().open(bytes(damaged))


def test_a_damaged_message_frame_is_reported() -> None:
    frame = writer().frame(b"grant")
    assert refusal(frame[:-1] + b"T") == (
        f"node west, message 0 on 'out': a message of {len(frame)} bytes arrived damaged "
        "(its CRC32 does not match), start the run again"
    )


def test_a_truncated_message_between_processes_is_reported_as_damaged() -> None:
    assert "arrived damaged" in refusal(writer().frame(b"grant" * 10)[:-7])


def test_bytes_that_are_no_heavylift_message_are_refused_with_the_name_of_the_node() -> None:
    assert refusal(b"ping") == (
        "node west, message 0 on 'out': 4 bytes arrived that are no heavylift message (b'ping'); "
        "another program writes to this run's keys, end it and start the run again"
    )


def test_a_node_refuses_a_message_that_belongs_to_another_run() -> None:
    assert refusal(writer(run="feed").frame(b"")) == (
        "node west, message 0 on 'out': a message of run feed arrived in run 0123456789abcdef, "
        "end the other run's processes"
    )


def test_a_message_frame_sent_by_another_node_is_refused() -> None:
    assert refusal(writer(node="east").frame(b"")) == (
        "node west, message 0 on 'out': a message of node east arrived in its place, "
        "each node must use its own name and key"
    )


def test_a_node_refuses_a_message_that_was_sent_on_another_topic() -> None:
    assert "a message of topic 'samples' arrived" in refusal(writer(topic=FrameTopic.SAMPLES).frame(b""))


def test_a_message_from_a_replaced_process_of_the_node_is_refused() -> None:
    assert refusal(writer(epoch=0).frame(b"")) == (
        "node west, message 0 on 'out': a message of epoch 0 arrived in epoch 1, end the node's older process"
    )


def test_a_lost_message_between_processes_is_reported_by_the_gap_in_message_numbers() -> None:
    w = writer()
    w.frame(b"lost")
    assert refusal(w.frame(b"")) == (
        "node west, message 0 on 'out': message 1 arrived out of sequence (messages were lost), start the run again"
    )


def test_a_message_that_arrives_twice_over_the_network_is_reported() -> None:
    frame, r = writer().frame(b""), reader()
    r.open(frame)
    with pytest.raises(ProtocolError, match=r"message 0 arrived out of sequence \(it had arrived before\)"):
        r.open(frame)


def test_the_hub_refuses_wrong_messages_of_a_node() -> None:
    with LocalHub(["west", "kernel"]) as hub:
        put = hub._session.put
        put(key(hub.run, "out", LOCAL, "west"), writer(run=hub.run, node="east").frame(b""))
        put(key(hub.run, "samples", LOCAL, "west"), b"\x00" * 40)
        put(key(hub.run, "out", LOCAL, "gantry"), writer(run=hub.run, node="gantry").frame(b""))
        with pytest.raises(ProtocolError, match="a message of node east arrived in its place"):
            hub.receive()
        with pytest.raises(ProtocolError, match="40 bytes arrived that are no heavylift message"):
            hub.samples()
        with pytest.raises(ProtocolError, match=r"this run has no such node \(west, kernel\)"):
            hub.receive()


def test_the_node_refuses_repeated_messages_of_the_hub() -> None:
    with LocalHub(["west"]) as hub:
        link = hub.link("west")
        frame = Writer(hub.run, "west", FrameTopic.IN, 1).frame(b"grant")
        for _ in range(2):
            hub._session.put(key(hub.run, "in", LOCAL, "west"), frame)
        assert link.receive() == b"grant"
        with pytest.raises(ProtocolError, match="it had arrived before"):
            link.receive()


@pytest.mark.parametrize("name", ["", "west/out", "*", "event", "observer", "west crane"])
def test_a_node_name_that_is_not_a_valid_zenoh_key_is_refused(name: str) -> None:
    with pytest.raises(ProtocolError, match="cannot be used; choose 1 to 200 letters"):
        Hub([name])


def test_two_nodes_with_the_same_name_are_refused() -> None:
    with pytest.raises(ProtocolError, match="two of the node names are 'west'; give each node its own name"):
        LocalHub(["west", "east", "west"])


def test_a_client_without_a_password_is_not_admitted_to_a_run() -> None:
    with Hub(["west"]) as hub:
        endpoint = f"unixsock-stream/{hub.directory.socket}"
        config = {
            "mode": "client",
            "connect": {"endpoints": [endpoint], "timeout_ms": 300, "exit_on_failure": True},
            "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        }
        with pytest.raises(zenoh.ZError):
            zenoh.open(zenoh.Config.from_json5(json.dumps(config)))


def test_only_undamaged_messages_of_an_earlier_process_of_the_same_node_count_as_outdated() -> None:
    def spoiled(frame: bytes) -> bytes:
        return frame[:-1] + b"?"

    r = FrameReader(RUN, "west", FrameTopic.OUT, 3)
    assert r.outdated(writer(epoch=2).frame(b"done"))
    for other in (
        writer(epoch=3).frame(b"done"),
        writer(epoch=4).frame(b"done"),
        writer(node="east", epoch=2).frame(b"done"),
        writer(run="feed", epoch=2).frame(b"done"),
        writer(topic=FrameTopic.SAMPLES, epoch=2).frame(b"done"),
        spoiled(writer(epoch=2).frame(b"done")),
        b"done",
    ):
        assert not r.outdated(other)
