"""Where a new run parts from a recorded one: the first event or sample that is not the same, as both tell it."""

from __future__ import annotations

import msgspec
from heavylift.nodes.devs import Event, Tag


class Deviation(msgspec.Struct, frozen=True):
    """Tag, topic and what was recorded and came now; None where nothing was said."""

    t_ns: int
    microstep: int
    topic: str
    recorded: object
    now: object

    def __str__(self) -> str:
        told = [msgspec.json.encode(x).decode() if x is not None else "nothing" for x in (self.recorded, self.now)]
        return f"at {Tag(self.t_ns, self.microstep)} on {self.topic}: recorded {told[0]}, now {told[1]}"


class Outcome(msgspec.Struct, frozen=True):
    """How far the new run was the recorded one: events that came again, the first deviation, the digest if known."""

    events: int
    deviation: Deviation | None = None
    digest: str = ""

    @property
    def same(self) -> bool:
        """Whether nothing deviated."""
        return self.deviation is None


class Follower:
    """Compares events as they come, in total order, with the recorded ones."""

    def __init__(self, recorded: list[Event]) -> None:
        self._recorded = recorded
        self.count = 0
        """Recorded events that have come again."""

    def hear(self, event: Event) -> Deviation | None:
        """The next event; the deviation if it is not the next recorded one."""
        due = self._recorded[self.count] if self.count < len(self._recorded) else None
        if due == event:
            self.count += 1
            return None
        if due is None or event.order < due.order:
            return _deviation(None, event)
        return _deviation(due, event if event.order == due.order else None)

    def reach(self, tag: Tag) -> Deviation | None:
        """Nothing before this tag comes any more; the deviation if something recorded is missing."""
        due = self._recorded[self.count] if self.count < len(self._recorded) else None
        return _deviation(due, None) if due is not None and due.tag < tag else None


def _deviation(recorded: Event | None, now: Event | None) -> Deviation:
    known = recorded or now
    assert known is not None
    return Deviation(known.t, known.k, f"/{known.source}/{known.port}", _plain(recorded), _plain(now))


def _plain(event: Event | None) -> object:
    return None if event is None else {event.type: msgspec.msgpack.decode(event.payload)}
