"""Server for one page on this machine: 127.0.0.1, a random word in the address, no access for other sites.

Requests must name this host, may not come from a page of another origin, and must contain the word. GET of the word's
folder returns the page, of `events` in it the messages as Server-Sent Events: all from the first (or from the one after
`Last-Event-ID`), then each as it comes. A browser that stops reading is disconnected; it reconnects by itself.

The page of a run in progress: data are packed 30 times a second and kept for all browsers.

The run only hands over data that it has anyway; a separate thread packs them, and every browser reads the same list of
messages at its own pace, so neither a slow browser nor none at all can delay the run.
"""

import hmac
import secrets
import socket
import threading
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, cast

import msgspec
import numpy as np
from heavylift.recordings.format.samples import SampleLayout, thinned
from heavylift.recordings.format.text import duration
from heavylift.recordings.format.viewer_messages import DrawnBox, RopeLine
from heavylift.recordings.write.broadcast import Spectator
from heavylift.recordings.write.sink import texts
from numpy.typing import NDArray

from .content import PageColumns, event_shown, facts_shown, is_inner, load_of, packed, shown, stage_name

HOST = "127.0.0.1"
READERS = 16  # browsers at a time
STALLED = 5.0  # [s] without reading until a browser is let go
POLL = 0.05  # [s] between looks for the end
PULSE = 2.0  # [s] between signs of life where nothing happens


HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Resource-Policy": "same-origin",
}


def refusal(headers: Mapping[str, str], port: int) -> str:
    """Return the reason why a request must be refused; "" if the request is allowed.

    `headers`: function that returns a header of the request by name, in upper or lower case.
    """
    names = [f"{name}:{port}" for name in (HOST, "localhost")]
    if headers.get("Host", "") not in names:
        return "this page is served to this machine only"
    origin = headers.get("Origin")
    if origin is not None and origin not in [f"http://{name}" for name in names]:
        return "this page is not served to other sites"
    if headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin"):
        return "this page is not served to other sites"
    return ""


class PageServer:
    """Server that sends a page and its messages to browsers until `close`; `say` adds a message for all browsers."""

    def __init__(self) -> None:
        self.word = secrets.token_urlsafe(24)
        self.messages: list[bytes] = []
        self.change = threading.Condition()
        self.closing = False
        self.readers = self.served = 0  # browsers that read now; that have ever read to the end of what there was
        self._http = _Server((HOST, 0), _Handler)
        self._http.owner = self
        self.port = self._http.server_address[1]
        self.url = f"http://{HOST}:{self.port}/{self.word}/"
        self._thread = threading.Thread(target=self._http.serve_forever, args=(POLL,), name="page server", daemon=True)
        self._thread.start()

    def say(self, kind: str, data: bytes) -> None:
        """Add a message for all browsers; `data`: JSON on a single line."""
        with self.change:
            number = len(self.messages)
            self.messages.append(b"id: %d\nevent: %s\ndata: %s\n\n" % (number, kind.encode(), data))
            self.change.notify_all()

    def close(self, patience: float, farewell: float) -> None:
        """Stop the server after browsers have received all messages.

        Waits up to `patience` [s] for a first browser, then up to `farewell` [s] for all.
        """
        with self.change:
            self.change.wait_for(lambda: self.readers or self.served, timeout=patience)
            self.closing = True
            self.change.notify_all()
            self.change.wait_for(lambda: not self.readers, timeout=farewell)
        self._http.shutdown()
        self._thread.join()
        self._http.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False  # a browser that never reads must not keep a run from ending
    owner: PageServer

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore errors of disconnected browsers."""


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    protocol_version = "HTTP/1.1"
    timeout = STALLED

    def do_GET(self) -> None:
        """Answer an HTTP GET request by the HTML page, the stream of messages, or an error."""
        refused = refusal(cast(Mapping[str, str], self.headers), self.server.owner.port)
        if refused:
            return self._answer(HTTPStatus.FORBIDDEN, refused.encode() + b"\n", "text/plain")
        _, word, *rest = self.path.split("?")[0].split("/")
        if not hmac.compare_digest(word.encode(), self.server.owner.word.encode()) or rest not in ([""], ["events"]):
            return self._answer(HTTPStatus.NOT_FOUND, b"no such page; copy the whole address\n", "text/plain")
        if rest == ["events"]:
            return self._stream()
        from .view import page

        return self._answer(HTTPStatus.OK, page({"live": "events"}).encode(), "text/html; charset=utf-8")

    def _answer(self, status: HTTPStatus, body: bytes, kind: str) -> None:
        self.send_response(status)
        for name, value in (("Content-Type", kind), ("Content-Length", str(len(body)))):
            self.send_header(name, value)
        self._send_policy()
        self.wfile.write(body)

    def _send_policy(self) -> None:
        for name, value in {"Connection": "close", **HEADERS}.items():
            self.send_header(name, value)
        self.end_headers()
        self.close_connection = True

    def _stream(self) -> None:
        owner = self.server.owner
        with owner.change:
            owner.readers += 1
            owner.change.notify_all()
        try:
            if owner.readers > READERS:
                return self._answer(HTTPStatus.SERVICE_UNAVAILABLE, b"too many browsers look already\n", "text/plain")
            self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", "text/event-stream")
            self._send_policy()
            last = self.headers.get("Last-Event-ID", "")
            self._send_from(int(last) + 1 if last.isdecimal() and len(last) < 10 else 0)
        finally:
            with owner.change:
                owner.readers -= 1
                owner.change.notify_all()

    def _send_from(self, at: int) -> None:
        """Send the messages from number `at` on, until the server closes."""
        owner = self.server.owner
        while True:
            with owner.change:
                if not owner.closing and len(owner.messages) <= at:
                    owner.change.wait(PULSE)
                new, closing = owner.messages[at:], owner.closing
            for message in new or ([] if closing else [b": still here\n\n"]):
                self.wfile.write(message)
            at += len(new)
            if closing and not new:
                with owner.change:
                    owner.served += 1
                return

    def log_message(self, format: str, *args: object) -> None:
        """Do nothing, so that the server does not log requests."""


FRAME = 1 / 30  # [s] at least between two messages
ROWS = 64  # most samples in a message: a run can be a thousand times faster than its picture
EVENTS = 5000  # most events in the list
PATIENCE = 10.0  # [s] for a first browser to come when the run is over before one has
FAREWELL = 2.0  # [s] for browsers to get the end


class LivePage(Spectator, AbstractContextManager["LivePage"]):
    """Live page of a run in progress; a context manager and an observer of the run."""

    def __init__(self) -> None:
        self._server = PageServer()
        self.url = self._server.url
        """Address of the page, including the secret word."""
        self._lock = threading.Lock()
        self._shown: PageColumns | None = None
        self._facts: list[tuple[str, str]] = []
        self._rows: list[tuple[Sequence[int], NDArray[np.float64]]] = []
        self._more: dict[str, list[Any]] = {"events": [], "stages": [], "rig": []}
        self._events = 0
        self._t_ns = 0
        self._over = threading.Event()
        self._packer = threading.Thread(target=self._pack_on, name="live page", daemon=True)
        self._packer.start()

    def begin(
        self, run: Mapping[str, object], layout: SampleLayout, boxes: Sequence[DrawnBox], lines: Sequence[RopeLine]
    ) -> None:
        self._shown, self._facts = shown(layout), facts_shown(texts(run), [])
        head = {
            "title": run.get("scene", ""),
            "status": "starting",
            "facts": self._facts,
            **self._shown.head(),
            "boxes": boxes,
            "rig": [{"t": 0.0, "lines": lines}],
            "rated": run.get("rated", {}),
            "supports": [s for s in cast("list[dict[str, object]]", run.get("supports", [])) if not s.get("on")],
            "stages": [],
            "events": [],
            "peaks": [],
        }
        self._server.say("begin", msgspec.json.encode(head))

    def event(self, t_ns: int, source: str, port: str, type: str, payload: bytes) -> None:
        inner = is_inner(port)
        if self._events >= EVENTS or (inner and self._events >= EVENTS // 2):  # the list keeps room for what matters
            return
        self._events += 1
        with self._lock:
            self._more["events"].append((t_ns, source, port, type, payload))

    def ropes(self, t_ns: int, lines: Sequence[RopeLine]) -> None:
        with self._lock:
            self._more["rig"].append({"t": t_ns * 1e-9, "lines": list(lines)})

    def samples(self, times: Sequence[int], rows: NDArray[np.float64]) -> None:
        with self._lock:
            self._rows.append((times, rows))

    def end(self, status: str, message: Mapping[str, str], peaks: Sequence[Mapping[str, object]], where: str) -> None:
        self._over.set()
        self._packer.join()
        self._pack()
        if self._shown is not None:
            kept = [("recording", where), ("page to keep", f"heavylift view {where}")]
            text = f"{status}, {duration(self._t_ns * 1e-9)} simulated; recorded in {where}"
            last = {"status": text, "facts": [*self._facts, *message.items(), *kept], "peaks": peaks}
            self._server.say("end", msgspec.json.encode(last))

    def __exit__(self, _: object, error: object, *__: object) -> None:
        self._over.set()
        self._packer.join()
        begun = self._shown is not None and not isinstance(error, KeyboardInterrupt)
        self._server.close(PATIENCE if begun else 0.0, FAREWELL)

    def _pack_on(self) -> None:
        while not self._over.wait(FRAME):
            self._pack()

    def _pack(self) -> None:
        """Pack all data that arrived since the last message into one message."""
        with self._lock:
            rows, self._rows = self._rows, []
            more, self._more = self._more, {"events": [], "stages": [], "rig": []}
        if self._shown is None or not (rows or any(more.values())):
            return
        message: dict[str, object] = {"rig": more["rig"]}
        message["events"], message["stages"] = self._message(more["events"])
        if rows:
            times = np.concatenate([np.asarray(t, np.int64) for t, _ in rows])
            values = np.concatenate([x for _, x in rows])[:, self._shown.columns]
            kept = thinned([load_of(self._shown.signals, values[:, 7 * len(self._shown.bodies) :])], ROWS)
            message["rows"] = {"t": packed(times[kept] * 1e-9, "<f8"), "x": packed(values[kept])}
            self._t_ns = int(times[-1])
        message["status"] = f"running, {duration(self._t_ns * 1e-9)} simulated"
        self._server.say("more", msgspec.json.encode(message))

    @staticmethod
    def _message(events: list[Any]) -> tuple[list[dict[str, object]], list[dict[str, object]]]:
        """Return events and stages as plain data for the page."""
        listed, stages = [], []
        for t_ns, source, port, type_, payload in events:
            value = msgspec.msgpack.decode(payload)
            listed.append(event_shown(t_ns, source, port, type_, value))
            if name := stage_name(port, value):
                stages.append({"t": t_ns * 1e-9, "name": name})
        return listed, stages
