"""A recording as what it was made of: the models that took part, and the events with their canonical bytes.

The values of events stand in the file as JSON; decoded into their message classes and encoded again they give the
bytes that the digest is made of.  A recording whose models or messages this version does not know is refused.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import msgspec
from heavylift.coordinator.protocol.core import RunEnd
from heavylift.kernel.errors import UNREADABLE, ModelError, RecordingError
from heavylift.kernel.version import __version__, again
from heavylift.nodes.devs import FOREVER, Event, Tag, encode, message_type, seconds
from heavylift.recordings import RecordedEvent, Recording

from .recorded_models import RecordedModels, cast_of


class RecordedRun:
    """Cast, events and end of the run in a recording."""

    def __init__(self, path: str | Path) -> None:
        self.recording = Recording(path)
        self.path = self.recording.path

    @cached_property
    def cast(self) -> RecordedModels:
        """The models; RecordingError if this version cannot build them."""
        return cast_of(self.recording)

    @cached_property
    def events(self) -> list[Event]:
        """All events in total order."""
        assert self.cast  # their message classes are known when the models are built
        return [self._event(e) for e in self.recording.events()]

    def _event(self, e: RecordedEvent) -> Event:
        try:
            value = msgspec.convert(e.value, message_type(e.type))
        except (*UNREADABLE, ModelError) as error:
            raise RecordingError(
                f"{self.path}: {e.source}.{e.port} at {Tag(e.t_ns, e.microstep)} is no {e.type} that heavylift "
                f"{__version__} knows ({error}); {again(self.recording.version)}"
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
        if self.recording.fact("outcome") == RunEnd.QUIET.value:
            return FOREVER
        return Tag(max(last.t, seconds(float(self.recording.fact("sim_s", 0.0)))) + 1)


def plain(e: RecordedEvent) -> Event:
    """A recorded event with the bytes that its value has without its class, for those who only pass it on."""
    return Event(e.t_ns, e.microstep, e.source, e.port, e.index, e.type, msgspec.msgpack.encode(e.value))
