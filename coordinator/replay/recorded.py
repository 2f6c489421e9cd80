"""A recording as what it was made of: the plan, and the events with their canonical bytes.

The values of events stand in the file as JSON; decoded into their message classes and encoded again they give the
bytes that the digest is made of.  A recording whose plan or messages this version does not know is refused.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import msgspec
from heavylift.kernel.errors import ModelError, RecordingError
from heavylift.nodes.devs import Event, Tag, encode, message_type, ns
from heavylift.nodes.models import couplings
from heavylift.nodes.scene.plan import Plan, decode
from heavylift.recordings import RecordedEvent, Recording

__all__ = ["RecordedRun"]

RESOLVED = "resolved.json"


class RecordedRun:
    """Plan, events and end of the run in a recording."""

    def __init__(self, path: str | Path) -> None:
        self.recording = Recording(path)
        self.path = self.recording.path

    @cached_property
    def plan(self) -> Plan:
        """The resolved scene that was run; RecordingError if the file has none that this version can run."""
        attached = self.recording.attachments.get(RESOLVED)
        if attached is None:
            raise RecordingError(
                f"{self.path}: has no scene attached to simulate again; record it with `heavylift run`"
            )
        try:
            return decode(attached)
        except msgspec.MsgspecError as error:
            made = self.recording.library
            raise RecordingError(
                f"{self.path}: this version cannot run its scene ({error}); use the version that made it, {made}"
            ) from None

    @cached_property
    def events(self) -> list[Event]:
        """All events in total order."""
        return [self.event(e) for e in self.recording.events()]

    def event(self, e: RecordedEvent) -> Event:
        """A recorded event with its canonical bytes."""
        try:
            value = msgspec.convert(e.value, message_type(e.type))
        except (msgspec.MsgspecError, ModelError) as error:
            raise RecordingError(
                f"{self.path}: {e.source}.{e.port} at {Tag(e.t_ns, e.microstep)} is no {e.type} that this version "
                f"knows ({error}); use the version that made it, {self.recording.library}"
            ) from None
        return Event(e.t_ns, e.microstep, e.source, e.port, e.index, e.type, encode(value))

    @property
    def complete(self) -> bool:
        """Whether the run came to its own end."""
        return self.recording.result.get("status") == "finished"

    @property
    def end(self) -> Tag:
        """The tag before which the recording knows everything."""
        last = self.events[-1].tag if self.events else Tag(0)
        if not self.complete:
            return last
        return max(Tag(last.t + 1), Tag(ns(float(self.recording.fact("sim_s", 0.0))) + 1))

    @property
    def wiring(self) -> list[tuple[str, str, str, str]]:
        """Source, its port, target, its port of all couplings between the nodes."""
        return couplings(self.plan)
