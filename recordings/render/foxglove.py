"""The Foxglove websocket of a run in progress: samples, poses, ropes, boxes and events for Foxglove and Lichtblick.

The server listens on this machine only, its address holds a random word, and of web pages only these viewers may
connect, since any site in a browser can try such a port. It sends the four messages of protocol `foxglove.sdk.v1` that
these viewers need. A slow viewer misses older data and never delays the run.

A layout for Lichtblick and Foxglove, with what those programs need to show a recording at once: the scene in three
dimensions seen from the world, the rope tensions by name, the stages, the log.

It is attached to each recording; in the program: import the layout from the file, then open the recording.  What is
the same in all of them stands in `page/lichtblick.json`.
"""

import base64
import hmac
import json
import queue
import re
import secrets
import struct
import threading
from collections.abc import Sequence
from contextlib import AbstractContextManager, suppress
from math import atan2, degrees, hypot
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
from google.protobuf.descriptor import Descriptor  # type: ignore[import-untyped]
from heavylift.kernel.errors import RecordingError, extra
from heavylift.recordings.format.schema import file_descriptor_set

HOST, PORT = "127.0.0.1", 8765  # the port that viewers propose
PROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
ORIGINS = re.compile(
    r"https?://(localhost|127\.0\.0\.1)(:\d+)?|file://|https://(app|studio)\.foxglove\.dev"
    r"|https://lichtblick-suite\.github\.io"
)
VIEWERS, BACKLOG = 16, 1024  # at a time; messages that wait for one of them
LARGEST = 1 << 16  # message of a viewer [bytes]
MESSAGE = struct.Struct("<BIQ")  # 1, the number of the subscription, time [ns]; then the message itself


class _Viewer(NamedTuple):
    waiting: queue.Queue[str | bytes]
    numbers: dict[int, int]  # of subscriptions, by channel


class FoxgloveServer(AbstractContextManager["FoxgloveServer"]):
    """Server that sends a run in progress to Foxglove and Lichtblick on this machine; closed as a context manager."""

    def __init__(self, name: str, port: int = PORT) -> None:
        """Open the websocket; raises RecordingError if its package is missing or the port is in use."""
        missing = "--foxglove needs the package websockets: pip install 'heavylift[foxglove]'"
        server = extra("websockets.sync.server", RecordingError(missing))
        self._hello = json.dumps({"op": "serverInfo", "name": name, "capabilities": [], "metadata": {}})
        self._word = secrets.token_urlsafe(24)
        self._channels: dict[str, dict[str, Any]] = {}
        self._viewers: list[_Viewer] = []
        self._lock = threading.Lock()
        try:
            self._server = server.serve(
                self._serve, HOST, port, process_request=self._refused, select_subprotocol=_chosen,
                compression=None, max_size=LARGEST, server_header=None,
            )  # fmt: skip
        except (OSError, OverflowError) as error:
            raise RecordingError(
                f"--foxglove: port {port} cannot be served ({error}); stop the program that uses it"
            ) from None
        self.url = f"ws://{HOST}:{self._server.socket.getsockname()[1]}/{self._word}"
        """Address for viewers."""
        threading.Thread(target=self._server.serve_forever, name="foxglove", daemon=True).start()

    def announce(self, topic: str, descriptor: Descriptor) -> None:
        """Announce a topic and the type of its messages."""
        schema = base64.b64encode(file_descriptor_set(descriptor)).decode()
        about = {"topic": topic, "encoding": "protobuf", "schemaName": descriptor.full_name, "schema": schema}
        with self._lock:
            self._channels[topic] = {"id": len(self._channels) + 1, **about, "schemaEncoding": "protobuf"}
            for viewer in self._viewers:
                _put(viewer, json.dumps({"op": "advertise", "channels": [self._channels[topic]]}))

    def listens(self) -> bool:
        """Return whether any viewer has subscribed to a topic."""
        return any(viewer.numbers for viewer in self._viewers)

    def put(self, topic: str, t_ns: int, data: bytes) -> None:
        """Send a message with a simulation time [ns] to all subscribers of its topic."""
        with self._lock:
            channel = self._channels[topic]["id"]
            for viewer in self._viewers:
                if channel in viewer.numbers:
                    _put(viewer, MESSAGE.pack(1, viewer.numbers[channel], t_ns) + data)

    def _refused(self, connection: Any, request: Any) -> Any:
        """Return the response that refuses a request; None if the request is accepted."""
        headers = request.headers
        hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
        names = [f"{name}:{self._server.socket.getsockname()[1]}" for name in (HOST, "localhost")]
        if len(hosts) != 1 or hosts[0] not in names or any(not ORIGINS.fullmatch(origin) for origin in origins):
            return connection.respond(403, "this run is not served to other sites\n")
        if not hmac.compare_digest(request.path.encode(), f"/{self._word}".encode()):
            return connection.respond(404, "no such run; copy the whole address\n")
        if len(self._viewers) >= VIEWERS:
            return connection.respond(503, "too many viewers look already\n")
        return None

    def _serve(self, connection: Any) -> None:
        """Serve a viewer until it disconnects."""
        viewer = _Viewer(queue.Queue(BACKLOG), {})
        with self._lock:
            _put(viewer, self._hello)
            _put(viewer, json.dumps({"op": "advertise", "channels": list(self._channels.values())}))
            self._viewers.append(viewer)
        threading.Thread(target=_send, args=(connection, viewer), daemon=True).start()
        try:
            for message in connection:
                with suppress(ValueError, KeyError, TypeError, RecursionError):
                    self._hear(viewer, json.loads(message))
        finally:
            with self._lock:
                self._viewers.remove(viewer)
            _put(viewer, "")

    def _hear(self, viewer: _Viewer, message: dict[str, Any]) -> None:
        known = {channel["id"] for channel in self._channels.values()}
        with self._lock:
            if message["op"] == "subscribe":
                found = {int(x["channelId"]): int(x["id"]) & 0xFFFFFFFF for x in message["subscriptions"]}
                viewer.numbers.update({channel: number for channel, number in found.items() if channel in known})
            elif message["op"] == "unsubscribe":
                for channel in [c for c, number in viewer.numbers.items() if number in message["subscriptionIds"]]:
                    del viewer.numbers[channel]

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()


def _chosen(connection: Any, offered: Any) -> Any:
    """Return the protocol to use with a viewer that offers these; None if none of them is suitable."""
    return next((name for name in PROTOCOLS if name in offered), None)


def _put(viewer: _Viewer, message: str | bytes) -> None:
    while True:
        try:
            return viewer.waiting.put_nowait(message)
        except queue.Full:
            with suppress(queue.Empty):
                viewer.waiting.get_nowait()


def _send(connection: Any, viewer: _Viewer) -> None:
    """Send the queued messages to a viewer until it disconnects."""
    with suppress(Exception):  # it may leave in any way
        while message := viewer.waiting.get():
            connection.send(message)


LAYOUT = "lichtblick.json"
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#7a6fd0", "#6b7682")
VIEW = (-0.62, -0.72, 0.32)  # from where the scene is seen


def layout(ropes: Sequence[str], middle: tuple[float, float, float], radius: float) -> bytes:
    """Return the Foxglove layout as JSON: tensions of the ropes (in recorded order), and a 3D view of a sphere with
    this centre and radius [m]."""
    whole = msgspec.json.decode((Path(__file__).parents[1] / "page" / LAYOUT).read_bytes())
    panels: dict[str, Any] = whole["configById"]
    x, y, z = VIEW
    panels["3D!scene"]["cameraState"] |= {
        "target": list(middle),
        "distance": 2.6 * radius,
        "phi": degrees(atan2(hypot(x, y), z)),
        "thetaOffset": degrees(atan2(y, x)) + 180.0,
        "near": radius / 200,
        "far": 60 * radius,
    }
    panels["3D!scene"]["layers"]["ground"] |= {"size": 6 * radius, "position": [middle[0], middle[1], 0]}
    panels["Plot!tension"]["paths"] = [
        {
            "value": f"/samples.rope_tension[{i}]",
            "label": f"{name} [N]",
            "enabled": True,
            "timestampMethod": "receiveTime",
            "color": COLOURS[i % len(COLOURS)],
        }
        for i, name in enumerate(ropes)
    ]
    return msgspec.json.format(msgspec.json.encode(whole))
