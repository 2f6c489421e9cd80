"""Runs that must do without bytes: whoever encodes an event, a row or a message of the protocol fails."""

from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

from heavylift.coordinator.participants import RowFrames
from heavylift.coordinator.protocol import Node, messages
from heavylift.nodes.devs import events


def _refuse(*_: object) -> bytes:
    raise AssertionError("something was encoded")


@contextmanager
def without_bytes() -> Iterator[None]:
    with (
        patch.object(events, "encode", _refuse),
        patch.object(messages, "encode", _refuse),
        patch.object(Node, "__init__", _refuse),
        patch.object(RowFrames, "__init__", _refuse),
    ):
        yield
