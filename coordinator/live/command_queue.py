"""Where a run takes the orders of an operator: pause, step, continue, rate, stop, commands.

Orders arrive in a thread of the bus or of the terminal and wait; the conversation attends to them between two rounds.
A command gets the first whole nanosecond at which nothing is decided yet (`OpenCoordinator.safe`), is journaled beside
the recording, on the disk before anything can come of it, and enters the run as an event of the source "operator", in
the total order and on record.  Its reply waits for what the model answers; one who does not wait for a paused run
is told when it will take effect.

The commands that an operator gave to a run: as events, in its journal, in its recording.

run(scene, "again.mcap", commands=operator_commands("turnover.mcap"))      the same run, the same digest
"""

from collections import deque
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from typing import NamedTuple

import msgspec
import zenoh
from heavylift.coordinator.participants.configuration import COMMAND, OPERATOR
from heavylift.coordinator.protocol.outside import OpenCoordinator
from heavylift.coordinator.supervision.journal import Journal, read
from heavylift.coordinator.transport.hub import Hub
from heavylift.kernel.errors import UNREADABLE, HeavyliftError, RecordingError, printable
from heavylift.nodes.devs import Event, Tag, encode
from heavylift.nodes.devs import encode as canonical
from heavylift.nodes.models.parts.messages import OperatorAnswer, OperatorCommand
from heavylift.recordings import Recording, file_path
from heavylift.recordings.write.outputs import COMMANDS

from .announce import Order, Reply
from .pace import Tempo


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


SHOWN = 200  # characters of what is wrong with an order
STOP = "stop"  # in place of the words of a command: the end of the run


class Asked(NamedTuple):
    """An encoded Order and who hears the replies."""

    order: bytes
    reply: Callable[[Reply], None]


class Desk(AbstractContextManager["Desk"]):
    """A context manager: at its end nobody is left without an answer, and a journal that is not needed goes."""

    def __init__(
        self,
        recording: Callable[[], Path],
        tempo: Tempo,
        read: Callable[[str], OperatorCommand] | None = None,
        why: Callable[[OperatorAnswer], str] = lambda answer: answer.refused,
    ) -> None:
        """`recording`: where it is written, once it is.  `read` makes a command of an operator's words or raises a
        HeavyliftError; None: nobody takes commands.

        `why` says for people why a command is refused.
        """
        self._recording, self._tempo, self._read, self._why = recording, tempo, read, why
        self._journal: Journal | None = None
        self._asked: deque[Asked] = deque()
        self._unanswered: dict[int, Asked] = {}  # by the time of the command [ns]
        self._steps: list[Asked] = []
        self._taken: set[int] = set()  # times of commands [ns]
        self._closed = False

    def repeat(self, commands: Iterable[TimedCommand], core: OpenCoordinator) -> None:
        """Order what was ordered in another run."""
        for given in commands:
            self._order(given, core)

    def open(self, hub: Hub) -> None:
        """Take orders from now on."""
        hub.serve("control", self._arrived)

    def attend(self, core: OpenCoordinator) -> None:
        """Do what has been ordered since the last time; tell those who wait for the end of a step."""
        if self._steps and self._tempo.held and self._tempo.limit is not None:
            self._stepped(f"paused at {_seconds(self._tempo.limit)}")
        while self._asked:
            asked = self._asked.popleft()
            try:
                said = self._obey(msgspec.msgpack.decode(asked.order, type=Order), core, asked)
            except HeavyliftError as error:
                asked.reply(Reply(False, str(error)))
            except UNREADABLE as error:
                asked.reply(Reply(False, f"this is no order that a run takes: {printable(str(error), SHOWN)}"))
            else:
                if said is not None:
                    asked.reply(said)

    def event(self, event: Event) -> None:
        """Pass the model's answer to a command on to who gave it."""
        if event.type == OperatorAnswer.__name__:
            answer = event.value
            assert isinstance(answer, OperatorAnswer)
            asked = self._unanswered.pop(answer.t_ns, None)
            if asked is not None:
                at = _seconds(Tag(answer.t_ns))
                said = f"at {at} refused: command: {self._why(answer)}" if answer.refused else f"began at {at}"
                asked.reply(Reply(not answer.refused, f"{answer.text}: {said}", answer.t_ns))

    def _stepped(self, said: str) -> None:
        at = None if self._tempo.limit is None else self._tempo.limit.t
        for asked in self._steps:
            asked.reply(Reply(True, said, at))
        self._steps.clear()

    def ask(self, asked: Asked) -> None:
        """Lay an order on the desk, from any thread."""
        self._asked.append(asked)
        self._tempo.alarm.set()
        if self._closed:
            self.close()

    def close(self) -> None:
        """The run is over: nobody waits in vain, as long as the bus still carries an answer."""
        self._closed = True
        self._asked.extend([*self._steps, *self._unanswered.values()])
        self._steps.clear()
        self._unanswered.clear()
        with suppress(IndexError):  # none is left; another thread may take one, too
            while True:
                self._asked.popleft().reply(Reply(False, "the run has ended"))

    def _arrived(self, query: zenoh.Query) -> None:
        def reply(said: Reply) -> None:
            query.reply(query.key_expr, msgspec.msgpack.encode(said))
            if said.last:
                query.drop()  # type: ignore[no-untyped-call]

        self.ask(Asked(query.payload.to_bytes() if query.payload else b"", reply))

    def _obey(self, order: Order, core: OpenCoordinator, asked: Asked) -> Reply | None:
        """The answer to an order; None if it comes later."""
        tempo = self._tempo
        match order.do:
            case "pause":
                at = tempo.pause(core)
                for t, waiting in self._unanswered.items():
                    self._hold(t, waiting)
                return Reply(True, f"paused at {_seconds(at)}", at.t)
            case "continue":
                tempo.go_on()
                self._stepped("goes on")
                return Reply(True, "goes on")
            case "step":
                tempo.step(core, order.by_ns)
                self._steps.append(asked)
                return None
            case "stop":
                t = self._give(STOP, core)
                tempo.go_on()
                return Reply(True, f"ends at {_seconds(Tag(t))}", t)
            case "command":
                t = self._give(order.text, core)
                if self._paused(t) and not order.wait:
                    return Reply(True, f"{order.text}: at {_seconds(Tag(t))}, when the run goes on", t)
                self._unanswered[t] = asked  # first: Ctrl-C may come at once
                self._hold(t, asked)
                return None
            case "rate":
                return Reply(True, f"{tempo.pace.change(order.factor):g} x real time")

    def _paused(self, t: int) -> bool:
        """Whether the run does not come to this time [ns] before it goes on."""
        return self._tempo.limit is not None and Tag(t) >= self._tempo.limit

    def _hold(self, t: int, asked: Asked) -> None:
        """Tell who waits for the answer to a command that it comes later, if it does."""
        if self._paused(t):
            at = _seconds(Tag(t))
            said = f"the run is paused at {at}; the command takes effect there when it goes on"
            asked.reply(Reply(False, said, t, last=False))

    def _give(self, words: str, core: OpenCoordinator) -> int:
        """Let a command take effect as soon as may be; returns when [ns]."""
        if self._read is None:
            raise HeavyliftError(
                f"{words}: no model of this run takes commands; pause, step and continue it, or Ctrl-C"
            )
        said = OperatorCommand(STOP) if words == STOP else self._read(words)
        t = core.safe_ns
        while t in self._taken:
            t += 1
        if Tag(t) >= core.end:
            raise HeavyliftError(f"{said.text}: too late, everything before the end of the run is decided already")
        self._order(TimedCommand(Tag(t), canonical(said)), core)
        return t

    def _order(self, given: TimedCommand, core: OpenCoordinator) -> None:
        """It is on the disk before anything can come of it."""
        if self._journal is None:
            self._journal = Journal(journal_of(self._recording()), exclusive=True)
        self._journal.append(msgspec.msgpack.encode(given), sync=True)
        core.inject(command(given))
        self._taken.add(given.tag.t)

    def __exit__(self, *_: object) -> None:
        self.close()
        if self._journal is not None:
            self._journal.close()
            if self._recording().exists():  # it holds the commands
                self._journal.delete()


def _seconds(tag: Tag) -> str:
    return f"{tag.t * 1e-9:.9f} s"
