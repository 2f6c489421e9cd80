"""The commands that an operator gave to a run: as events, in its journal, in its recording.

run(scene, "again.mcap", commands=operator_commands("turnover.mcap"))      the same run, the same digest
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import msgspec
from heavylift.coordinator.participants.configuration import COMMAND, OPERATOR
from heavylift.coordinator.supervision.journal import read
from heavylift.kernel.errors import UNREADABLE, RecordingError
from heavylift.nodes.devs import Event, Tag, encode
from heavylift.nodes.models.parts.messages import OperatorCommand
from heavylift.recordings import Recording, file_path
from heavylift.recordings.write.outputs import COMMANDS


class TimedCommand(NamedTuple):
    """A command and when it was given: the canonical bytes of an OperatorCommand."""

    tag: Tag
    payload: bytes


def command(given: TimedCommand) -> Event:
    """The event that a command is."""
    return Event(*given.tag, OPERATOR, COMMAND, 0, OperatorCommand.__name__, given.payload)


def journal_of(recording: Path) -> Path:
    """Where the commands of a run are journaled until its recording is whole."""
    return recording.with_name(recording.name + COMMANDS)


def journaled(recording: Path) -> set[TimedCommand]:
    """The commands in the journal of a run that was cut off."""
    path = journal_of(recording)
    try:
        return {TimedCommand(*msgspec.msgpack.decode(entry, type=tuple[Tag, bytes])) for entry in read(path)}
    except UNREADABLE as error:
        raise RecordingError(f"{path}: is no journal of commands ({error}); remove it to go on without them") from None


def operator_commands(recording: str | Path) -> list[TimedCommand]:
    """The commands of a recorded run, in order; of one that was cut off those in its journal, too."""
    path = file_path(recording)
    found = journaled(path)
    for event in Recording(path).events(OPERATOR, COMMAND) if path.exists() else ():
        try:
            said = msgspec.convert(event.value, OperatorCommand)
        except UNREADABLE as error:
            raise RecordingError(f"{path}: what was ordered at {event.t_ns} ns is no command ({error})") from None
        found.add(TimedCommand(Tag(event.t_ns, event.microstep), encode(said)))
    return sorted(found)
