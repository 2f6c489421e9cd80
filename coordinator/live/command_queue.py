"""Queue of an operator's orders to a run: pause, step, continue, rate, stop, commands.

Orders arrive in a thread of the bus or of the terminal; the coordinator handles them between two rounds. A command gets
the first whole nanosecond at which nothing is decided yet (`OpenCoordinator.safe`), is synced to a journal beside the
recording before it takes effect, and enters the run as an event of the source "operator". `operator_commands` returns
those of a recorded run, to repeat it:

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
from heavylift.nodes.devs import Event, Tag, encode, encode as canonical
from heavylift.nodes.models.parts.messages import OperatorAnswer, OperatorCommand
from heavylift.recordings import Recording, file_path
from heavylift.recordings.write.outputs import COMMANDS

from .announce import Reply, RunOrder
from .pace import Tempo


class TimedCommand(NamedTuple):
    """An operator's command with its simulation time: `payload` holds the canonical bytes of an OperatorCommand."""

    tag: Tag
    payload: bytes


def command(given: TimedCommand) -> Event:
    """Return an operator's command as an event from outside, to be injected into the run."""
    return Event(*given.tag, OPERATOR, COMMAND, 0, OperatorCommand.__name__, given.payload)


def journal_of(recording: Path) -> Path:
    """Return the path of the journal of commands, a file that exists while the recording is incomplete."""
    return recording.with_name(recording.name + COMMANDS)


def journaled(recording: Path) -> set[TimedCommand]:
    """Read the commands in the journal of a run that was cut off; raises RecordingError if the file is not such a
    journal."""
    path = journal_of(recording)
    try:
        return {TimedCommand(*msgspec.msgpack.decode(entry, type=tuple[Tag, bytes])) for entry in read(path)}
    except UNREADABLE as error:
        raise RecordingError(
            f"{path}: is not a valid journal of commands ({error}); remove it to continue without these commands"
        ) from None


def operator_commands(recording: str | Path) -> list[TimedCommand]:
    """Return the operator's commands of a recorded run in order, including those in the journal if the run was cut
    off."""
    path = file_path(recording)
    found = journaled(path)
    for event in Recording(path).events(OPERATOR, COMMAND) if path.exists() else ():
        try:
            text = msgspec.convert(event.value, OperatorCommand)
        except UNREADABLE as error:
            raise RecordingError(f"{path}: the order at {event.t_ns} ns is not a valid command ({error})") from None
        found.add(TimedCommand(Tag(event.t_ns, event.microstep), encode(text)))
    return sorted(found)


SHOWN = 200  # characters of what is wrong with an order
STOP = "stop"  # in place of the words of a command: the end of the run


class QueuedOrder(NamedTuple):
    """An order of a client in the queue: the encoded RunOrder, and a function that receives the replies."""

    order: bytes
    reply: Callable[[Reply], None]


class CommandQueue(AbstractContextManager["CommandQueue"]):
    """Queue of the orders that an operator gives to a run; on exit it answers all waiting clients."""

    def __init__(
        self,
        recording: Callable[[], Path],
        tempo: Tempo,
        read: Callable[[str], OperatorCommand] | None = None,
        why: Callable[[OperatorAnswer], str] = lambda answer: answer.refused,
    ) -> None:
        """Create the queue. `recording` returns the future path of the recording; `read` parses the words of a command
        (None: commands are refused); `why` explains to people why a command was refused."""
        self._recording, self._tempo, self._read, self._why = recording, tempo, read, why
        self._journal: Journal | None = None
        self._asked: deque[QueuedOrder] = deque()
        self._unanswered: dict[int, QueuedOrder] = {}  # by the time of the command [ns]
        self._steps: list[QueuedOrder] = []
        self._taken: set[int] = set()  # times of commands [ns]
        self._closed = False

    def repeat(self, commands: Iterable[TimedCommand], core: OpenCoordinator) -> None:
        """Schedule the commands that an operator gave in another run."""
        for given in commands:
            self._order(given, core)

    def open(self, hub: Hub) -> None:
        """Accept orders of clients from now on."""
        hub.serve("control", self._arrived)

    def attend(self, core: OpenCoordinator) -> None:
        """Carry out queued orders, and reply to clients that wait for the end of a step."""
        if self._steps and self._tempo.held and self._tempo.limit is not None:
            self._stepped(f"paused at {_seconds(self._tempo.limit)}")
        while self._asked:
            asked = self._asked.popleft()
            try:
                text = self._execute(msgspec.msgpack.decode(asked.order, type=RunOrder), core, asked)
            except HeavyliftError as error:
                asked.reply(Reply(False, str(error)))
            except UNREADABLE as error:
                asked.reply(Reply(False, f"this is not a valid order: {printable(str(error), SHOWN)}"))
            else:
                if text is not None:
                    asked.reply(text)

    def event(self, event: Event) -> None:
        """Forward a model's answer to a command to the client that gave the command; ignore other events."""
        if event.type == OperatorAnswer.__name__:
            answer = event.value
            assert isinstance(answer, OperatorAnswer)
            asked = self._unanswered.pop(answer.t_ns, None)
            if asked is not None:
                at = _seconds(Tag(answer.t_ns))
                text = f"at {at} refused: command: {self._why(answer)}" if answer.refused else f"began at {at}"
                asked.reply(Reply(not answer.refused, f"{answer.text}: {text}", answer.t_ns))

    def _stepped(self, text: str) -> None:
        at = None if self._tempo.limit is None else self._tempo.limit.t
        for asked in self._steps:
            asked.reply(Reply(True, text, at))
        self._steps.clear()

    def ask(self, asked: QueuedOrder) -> None:
        """Queue an order; may be called from any thread."""
        self._asked.append(asked)
        self._tempo.alarm.set()
        if self._closed:
            self.close()

    def close(self) -> None:
        """Stop handling orders, and reply to all waiting clients while the bus is still open."""
        self._closed = True
        self._asked.extend([*self._steps, *self._unanswered.values()])
        self._steps.clear()
        self._unanswered.clear()
        with suppress(IndexError):  # none is left; another thread may take one, too
            while True:
                self._asked.popleft().reply(Reply(False, "the run has ended"))

    def _arrived(self, query: zenoh.Query) -> None:
        def reply(text: Reply) -> None:
            query.reply(query.key_expr, msgspec.msgpack.encode(text))
            if text.last:
                query.drop()  # type: ignore[no-untyped-call]

        self.ask(QueuedOrder(query.payload.to_bytes() if query.payload else b"", reply))

    def _execute(self, order: RunOrder, core: OpenCoordinator, asked: QueuedOrder) -> Reply | None:
        """Execute an order and return the reply; None if the reply comes later."""
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
                    return Reply(True, f"{order.text}: at {_seconds(Tag(t))}, when the run continues", t)
                self._unanswered[t] = asked  # first: Ctrl-C may come at once
                self._hold(t, asked)
                return None
            case "rate":
                return Reply(True, f"{tempo.pace.change(order.factor):g} x real time")

    def _paused(self, t: int) -> bool:
        """Return whether the run is paused before this time [ns]."""
        return self._tempo.limit is not None and Tag(t) >= self._tempo.limit

    def _hold(self, t: int, asked: QueuedOrder) -> None:
        """Reply that a command takes effect when the run continues, if it is paused before time `t` [ns]."""
        if self._paused(t):
            at = _seconds(Tag(t))
            text = f"the run is paused at {at}; the command takes effect there when the run continues"
            asked.reply(Reply(False, text, t, last=False))

    def _give(self, words: str, core: OpenCoordinator) -> int:
        """Schedule a command as early as possible and return its time [ns]; raises HeavyliftError if no model accepts
        commands."""
        if self._read is None:
            raise HeavyliftError(
                f"{words}: no model of this run takes commands; the run can be paused, stepped, continued, or "
                "stopped with Ctrl-C"
            )
        text = OperatorCommand(STOP) if words == STOP else self._read(words)
        t = core.safe_ns
        while t in self._taken:
            t += 1
        if Tag(t) >= core.end:
            raise HeavyliftError(
                f"{text.text}: too late: everything up to the end of the run has already been computed"
            )
        self._order(TimedCommand(Tag(t), canonical(text)), core)
        return t

    def _order(self, given: TimedCommand, core: OpenCoordinator) -> None:
        """Write a command to the journal on disk, then inject it into the run."""
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
