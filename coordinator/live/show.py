"""A run of node processes can be found and watched while in progress; a run in one process cannot."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from heavylift.coordinator.transport.hub import Hub
from heavylift.coordinator.transport.local_hub import LocalHub
from heavylift.nodes.devs import Message

from .announce import Announcement
from .observers import Audience


@contextmanager
def shown(
    hub: Hub | LocalHub,
    name: str,
    recording: Path | None,
    turning: Iterable[str] = (),
) -> Iterator[Audience | None]:
    """The audience of the run `name`; `turning`: the actuators whose coordinate is an angle."""
    if isinstance(hub, LocalHub):
        yield None
        return
    units = {kind.__name__: kind.units for kind in _kinds(Message) if kind.units}
    with (
        Audience(hub) as audience,
        Announcement(hub.directory.path, hub.run, name, recording, units, tuple(turning)),
    ):
        yield audience


def _kinds(type_: type[Message]) -> Iterator[type[Message]]:
    yield type_
    for kind in type_.__subclasses__():
        yield from _kinds(kind)
