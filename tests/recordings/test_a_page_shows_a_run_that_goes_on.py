"""The live page: who may see it, that all see the same, and that nobody who looks can hold up the run."""

from __future__ import annotations

import base64
import http.client
import json
import socket
import time
from collections.abc import Callable, Iterator
from urllib.parse import urlsplit

import msgspec
import numpy as np
import pytest
from heavylift.recordings import DrawnBox, RopeLine, SampleLayout
from heavylift.recordings.render import LivePage
from numpy.typing import NDArray
from small_run import SECOND, TIMES

NASTY = "</script><script>alert(1)</script>\n\ndata: <img src=x onerror=alert(2)>"
PATIENCE_s = 20.0


@pytest.fixture
def live() -> Iterator[LivePage]:
    with LivePage() as page:
        yield page


def ask(page: LivePage, path: str = "", **headers: str) -> tuple[int, bytes]:
    """Status and body of a request to the page."""
    url = urlsplit(page.url)
    connection = http.client.HTTPConnection(url.hostname or "", url.port, timeout=PATIENCE_s)
    connection.request("GET", path or url.path, headers={k.replace("_", "-"): v for k, v in headers.items()})
    answer = connection.getresponse()
    return answer.status, answer.read()


class Browser:
    """Reads the messages of a page as an EventSource does."""

    def __init__(self, page: LivePage, after: int | str | None = None) -> None:
        url = urlsplit(page.url)
        self._connection = http.client.HTTPConnection(url.hostname or "", url.port, timeout=PATIENCE_s)
        self._connection.request(
            "GET", url.path + "events", headers={} if after is None else {"Last-Event-ID": str(after)}
        )
        self._lines = self._connection.getresponse()

    def __iter__(self) -> Iterator[tuple[int, str, dict]]:
        fields: dict[str, str] = {}
        for line in self._lines:
            name, _, value = line.decode().rstrip("\n").partition(": ")
            if name:
                fields[name] = value
            elif "id" in fields:
                yield int(fields["id"]), fields["event"], json.loads(fields["data"])
                fields = {}


@pytest.fixture
def begin(live: LivePage, layout: SampleLayout) -> None:
    run = {"scene": NASTY, "seed": 7, "rated": {"west.H1": 9e5}}
    live.begin(
        run,
        layout,
        [DrawnBox("block", (0, 0, 0), (3, 2, 1))],
        [RopeLine("west.H1", "world", (0, 0, 9), "block", (0, 0, 1))],
    )


def stage(live: LivePage, second: int, name: str) -> None:
    live.event(second * SECOND, "commander", "stage", "Stage", msgspec.msgpack.encode({"name": name, "number": 1}))


def test_the_live_page_refuses_clients_without_its_secret_token_or_from_another_origin(live: LivePage) -> None:
    url = urlsplit(live.url)
    assert url.hostname == "127.0.0.1"
    assert len(url.path) >= 32
    assert ask(live)[0] == 200
    assert ask(live, Host=f"localhost:{url.port}")[0] == 200
    assert ask(live, Origin=f"http://127.0.0.1:{url.port}")[0] == 200
    for path in ("/", "/events", url.path[:-2] + "/", url.path + "other", "/x" + url.path, "/../etc/passwd"):
        assert ask(live, path) == (404, b"no such page; copy the whole address\n"), path
    for host in ("evil.example", f"evil.example:{url.port}", "127.0.0.1", "127.0.0.1:1"):
        assert ask(live, Host=host) == (403, b"this page is served to this machine only\n"), host
    for origin in (
        "http://evil.example",
        f"http://127.0.0.1:{url.port}.evil.example",
        "null",
        f"https://127.0.0.1:{url.port}",
    ):
        for path in (url.path, url.path + "events"):
            assert ask(live, path, Origin=origin) == (403, b"this page is not served to other sites\n"), origin
    assert ask(live, Sec_Fetch_Site="cross-site")[0] == 403


def test_the_live_page_listens_on_this_machine_only(live: LivePage) -> None:
    port = urlsplit(live.url).port
    addresses = {info[4][0] for info in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
    for address in addresses - {"127.0.0.1"}:
        with socket.socket() as other:
            other.settimeout(1.0)
            assert other.connect_ex((address, port)) != 0


@pytest.mark.usefixtures("begin")
def test_two_browsers_receive_the_same_run_at_whatever_time_they_connect(
    live: LivePage, batch: Callable[[int, int], bytes], rows: NDArray[np.float64]
) -> None:
    early = Browser(live)
    stage(live, 0, NASTY)
    live.samples(TIMES[:3], rows[:3])
    first = []
    for message in early:
        first.append(message)
        if message[1] == "more" and "rows" in message[2]:
            break
    seen = first[-1][0]
    live.ropes(3 * SECOND, [])
    live.samples(TIMES[3:], rows[3:])
    live.end("finished", {"digest": "abc"}, [], "run.mcap")
    late, again = Browser(live), Browser(live, after=seen)
    for message in early:
        first.append(message)
        if message[1] == "end":
            break
    sentence = []
    for message in late:
        sentence.append(message)
        if message[1] == "end":
            break
    assert sentence == first
    assert next(iter(again))[0] == seen + 1, "who comes back goes on where it was"
    for nonsense in ("9" * 5000, "-1", "x"):
        assert next(iter(Browser(live, after=nonsense)))[0] == sentence[0][0]
    kinds = [kind for _, kind, _ in sentence]
    assert kinds[0] == "begin"
    assert kinds[-1] == "end"
    assert sentence[0][2]["title"] == NASTY
    parts = [message["rows"] for _, kind, message in sentence if kind == "more" and "rows" in message]
    t = np.concatenate([np.frombuffer(base64.b64decode(part["t"]), "<f8") for part in parts])
    assert t.tolist() == [x / 1e9 for x in TIMES]
    x = np.concatenate([np.frombuffer(base64.b64decode(part["x"]), "<f4") for part in parts]).reshape(len(TIMES), -1)
    assert np.array_equal(x[:, :7], rows[:, 6:13].astype("<f4")), "the pose of the first body"
    assert [s["name"] for _, kind, m in sentence if kind == "more" for s in m["stages"]] == [NASTY]
    assert sentence[-1][2]["status"] == "finished, 4 s simulated; recorded in run.mcap"


@pytest.mark.usefixtures("begin")
def test_a_browser_that_never_reads_its_events_does_not_delay_others(live: LivePage, rows: NDArray[np.float64]) -> None:
    url = urlsplit(live.url)
    frozen = socket.create_connection((url.hostname, url.port), timeout=PATIENCE_s)
    frozen.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    frozen.sendall(f"GET {url.path}events HTTP/1.1\r\nHost: {url.netloc}\r\n\r\n".encode())
    many = np.repeat(rows, 200, axis=0)
    for i in range(300):  # megabytes, far more than any buffer of the system
        live.samples([i * SECOND + k for k in range(len(many))], many)
        time.sleep(0.004)
    live.end("finished", {}, [], "run.mcap")
    kinds = []
    for _, kind, _ in Browser(live):
        kinds.append(kind)
        if kind == "end":
            break
    assert kinds[0] == "begin", "another browser gets everything"
    frozen.close()


def test_the_server_of_a_live_page_ends_at_once_if_nobody_opened_it_or_the_run_failed() -> None:
    with pytest.raises(ZeroDivisionError), LivePage():
        raise ZeroDivisionError


@pytest.mark.usefixtures("begin")
def test_text_of_a_scene_cannot_break_out_of_its_message_on_the_live_page(live: LivePage) -> None:
    status, body = ask(live)
    assert status == 200
    assert body.count(b"<script") == 2
    assert NASTY.encode() not in body
    for _, kind, message in Browser(live):
        assert kind == "begin"
        assert message["title"] == NASTY, "line ends and markup are inside the JSON"
        break
