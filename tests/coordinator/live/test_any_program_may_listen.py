"""`watch --ticket`, `run --publish`, `run --foxglove`: programs of others hear a run, and change nothing of it."""

from __future__ import annotations

import asyncio
import json
import struct
import sys
import time
from itertools import pairwise
from pathlib import Path

import pytest
import zenoh
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from heavylift.kernel import RecordingError
from heavylift.nodes.devs import message_type
from heavylift.recordings import Recording
from heavylift.recordings.render import FoxgloveServer
from heavylift.recordings.write import Broadcast
from running import PATIENCE_s, command, found, going, said

TOPICS = 5  # with /log
DRAWN = {"/poses", "/samples", "/scene", "/ropes"}
Heard = list[tuple[str, str, dict[str, float], bytes]]


@pytest.mark.large
def test_a_plain_zenoh_session_with_a_ticket_receives_events_and_samples(tmp_path: Path) -> None:
    heard: Heard = []
    denied: Heard = []

    def keep(into: Heard, sample: zenoh.Sample) -> None:
        attached = json.loads(sample.attachment.to_bytes()) if sample.attachment else {}
        key = str(sample.key_expr).split("/", 2)[2]
        into.append((key, str(sample.encoding), attached, sample.payload.to_bytes()))

    with going(tmp_path, "run", "lift", "--rate", "8", "--publish", "4") as process:
        run = found(tmp_path / "lift.mcap")
        code, ticket, _ = said(tmp_path, "watch", run.notice.run, "--ticket")
        assert code == 0
        message = json.loads(ticket)["metadata"]["heavylift"]
        assert message["keys"] == [f"heavylift/{run.notice.run}/{topic}/**" for topic in ("event", "sample")]
        config = zenoh.Config.from_json5(ticket)
        with zenoh.open(config) as session, zenoh.open(config) as curious:
            subscribers = [session.declare_subscriber(key, lambda x: keep(heard, x)) for key in message["keys"]]
            more = [f"heavylift/{run.notice.run}/{key}" for key in ("**", "in/**", "out/**", "samples/**")]
            subscribers += [curious.declare_subscriber(key, lambda x: keep(denied, x)) for key in more]
            assert process.wait(PATIENCE_s) == 0
    recording = Recording(tmp_path / "lift.mcap")
    events = {(e.source, e.port, e.t_ns, e.microstep, e.index): e for e in recording.events()}
    poses = [(at["t_ns"], data) for key, kind, at, data in heard if key == "sample/poses"]
    assert poses
    kinds = {kind for key, kind, _, _ in heard if key == "sample/poses"}
    assert kinds == {"application/protobuf;foxglove.FrameTransforms"}
    assert all(b - a >= 250_000_000 for (a, _), (b, _) in pairwise(poses))
    recorded = {raw.log_time: raw.data for _, raw in recording.stream("/poses")}
    assert all(recorded[t] == data for t, data in poses)
    assert FrameTransforms.FromString(poses[-1][1]).transforms[0].parent_frame_id == "world"
    seen = [x for x in heard if x[0].startswith("event/")]
    assert seen
    for key, kind, at, data in seen:
        event = events[*key.split("/")[1:], at["t_ns"], at["k"], at["index"]]
        assert kind == f"application/msgpack;{event.type}"
        assert at["s"] == event.t_ns / 1e9
        assert message_type(event.type)
        assert data
    assert denied == []


@pytest.mark.large
def test_serving_foxglove_and_lichtblick_leaves_the_digest_unchanged(tmp_path: Path) -> None:
    from tornado.websocket import websocket_connect

    async def look() -> dict[str, bytes]:
        socket = await websocket_connect(url, subprotocols=["foxglove.sdk.v1"])
        topics: dict[int, str] = {}
        got: dict[str, bytes] = {}
        deadline = time.monotonic() + PATIENCE_s
        while not got.keys() >= DRAWN and time.monotonic() < deadline:
            message = await socket.read_message()
            if message is None:
                break
            if isinstance(message, str) and json.loads(message)["op"] == "advertise":
                topics |= {channel["id"]: channel["topic"] for channel in json.loads(message)["channels"]}
                if len(topics) == TOPICS:  # a moment after the first the server does not know it yet
                    wanted = [{"id": number, "channelId": number} for number in topics]
                    await socket.write_message(json.dumps({"op": "subscribe", "subscriptions": wanted}))
            elif isinstance(message, bytes) and message[0] == 1:
                number, t_ns = struct.unpack_from("<IQ", message, 1)
                assert t_ns <= 60 * 10**9
                got[topics[number]] = message[13:]
        socket.close()
        return got

    with command(tmp_path, "run", "lift", "--rate", "20", "--foxglove") as process:
        assert process.stderr is not None
        url = process.stderr.readline().split()[-1]
        assert url.startswith("ws://127.0.0.1:8765/")
        got = asyncio.run(look())
        assert process.wait(PATIENCE_s) == 0
    assert got.keys() >= DRAWN
    said(tmp_path, "run", "lift", "-o", "alone.mcap", "--in-process")
    digests = [Recording(tmp_path / name).result["digest"] for name in ("lift.mcap", "alone.mcap")]
    assert digests[0] == digests[1]


def test_the_package_that_live_viewing_needs_is_named_in_one_sentence_if_it_is_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "websockets.sync.server", None)
    with pytest.raises(RecordingError, match=r"^--foxglove needs the package websockets: pip install 'heavylift\[fox"):
        FoxgloveServer("lift")


def test_no_data_are_encoded_for_an_observer_that_has_not_subscribed() -> None:
    class Deaf:
        def announce(self, topic: str, descriptor: object) -> None:
            raise AssertionError

        def listens(self) -> bool:
            return False

        put = announce

    Broadcast(Deaf(), 10.0).samples([0], None)  # type: ignore[arg-type]
