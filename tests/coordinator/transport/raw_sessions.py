"""Two plain Zenoh sessions over a unix socket with our settings, or with one of them spoilt."""

import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import zenoh
from heavylift.coordinator.transport import session as ours
from zenoh.handlers import Callback


def config(mode: str, wait_before_close_us: int | None = None, **ends: list[str]) -> zenoh.Config:
    """Our settings; `wait_before_close_us` in place of ours."""
    made: dict[str, Any] = ours._config(mode, **ends)
    if wait_before_close_us is not None:
        queue = made["transport"]["link"]["tx"]["queue"]
        queue["congestion_control"]["block"]["wait_before_close"] = wait_before_close_us
    return zenoh.Config.from_json5(json.dumps(made))


@contextmanager
def pair(folder: Path, wait_before_close_us: int | None = None) -> Iterator[tuple[zenoh.Session, zenoh.Session]]:
    """A hub and a client of it."""
    at = [f"unixsock-stream/{folder / 's'}"]
    with (
        zenoh.open(config("peer", wait_before_close_us, listen=at)) as hub,
        zenoh.open(config("client", wait_before_close_us, connect=at)) as client,
    ):
        yield hub, client


def heard_by_a_sleeper(
    folder: Path, count: int, control: zenoh.CongestionControl, sleep_s: float, wait_before_close_us: int | None = None
) -> list[int]:
    """Numbers that arrive of a burst of `count` messages at a reader that does not look for `sleep_s`."""
    heard: list[int] = []
    awake = threading.Event()

    def read(sample: zenoh.Sample) -> None:
        awake.wait()
        heard.append(int.from_bytes(sample.payload.to_bytes()[:4], "little"))

    with pair(folder, wait_before_close_us) as (hub, client):
        hub.declare_subscriber("burst", Callback(read, indirect=False))
        publisher = client.declare_publisher("burst", congestion_control=control)
        listened(publisher)

        def speak() -> None:
            for number in range(count):
                publisher.put(number.to_bytes(4, "little") + bytes(100))

        speaker = threading.Thread(target=speak)
        speaker.start()
        time.sleep(sleep_s)
        awake.set()
        speaker.join()
        settled(heard)
    return heard


def listened(publisher: zenoh.Publisher) -> None:
    """Wait until the publisher knows of a subscriber."""
    while not publisher.matching_status.matching:  # type: ignore[attr-defined]
        time.sleep(0.001)


def settled(heard: list[Any]) -> None:
    """Wait until nothing has arrived for a while."""
    before = -1
    while before != len(heard):
        before = len(heard)
        time.sleep(0.3)
