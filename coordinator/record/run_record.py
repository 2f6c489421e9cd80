"""Record of any run: events, protocol traffic, the reason of its end; and where its wall time went.

`RunRecorder` computes only the digest; `FileRecorder` writes a recording and finishes it in any case. `Budget`: working
time of the kernel's node under grants, of the coordinator on the file, and `rounds`, the rest between the first grant
and the last answer. Nodes in processes work while the coordinator records, so the sum can exceed the total.
"""

import platform
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache, wraps
from itertools import pairwise
from pathlib import Path
from typing import Concatenate, ParamSpec, Self, TypeVar

import msgspec
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.stopping import whole
from heavylift.nodes.devs import Event, Message, Slack, Tag
from heavylift.recordings import Digest, Recorder

Mark = tuple[float, float]  # an instant, and the seconds of recording until then


@dataclass(frozen=True)
class Budget:
    """Wall time [s] that each part of a run has taken: start, kernel, rounds of grants, recording, exit."""

    start: float = 0.0
    kernel: float = 0.0
    rounds: float = 0.0
    recording: float = 0.0
    exit: float = 0.0

    @staticmethod
    def of(start: Mark, greeted: Mark, played: Mark, ended: Mark, kernel: float) -> "Budget":
        """Return the wall time [s] that each part of a run took, from clock readings taken between the parts."""
        marks = [start, greeted, played, ended]
        starting, playing, ending = ((b[0] - a[0]) - (b[1] - a[1]) for a, b in pairwise(marks))  # without the recording
        return Budget(starting, kernel, max(0.0, playing - kernel), ended[1], ending)

    def __str__(self) -> str:
        return ", ".join(f"{f.name} {getattr(self, f.name):.2f}" for f in fields(self))


class ClockedWork:
    """Base class of recorders, which measure their own working time `spent_s` [s]."""

    spent_s = 0.0

    def mark(self) -> Mark:
        """Return the present wall-clock time and the working time `spent_s` so far, both in s."""
        return time.perf_counter(), self.spent_s


T = TypeVar("T", bound=ClockedWork)
P = ParamSpec("P")
R = TypeVar("R")


def clocked(method: Callable[Concatenate[T, P], R]) -> Callable[Concatenate[T, P], R]:
    """Decorate a method of a recorder: count its duration in `spent_s`, and let no signal interrupt it."""

    @wraps(method)
    def timed(self: T, /, *args: P.args, **kwargs: P.kwargs) -> R:
        began = time.perf_counter()
        try:
            with whole():
                return method(self, *args, **kwargs)
        finally:
            self.spent_s += time.perf_counter() - began

    return timed


Held = Sequence[tuple[int, str]]  # after so many DONEs of all nodes, who began to hold a node back

SUMMARY: dict[type, tuple[str, ...]] = {
    m.Grant: ("gseq", "until", "inputs", "committed"), m.GrantDone: ("gseq", "next", "spoken", "offer"),
    m.Hello: ("next", "lookahead"), m.Fail: ("tag", "sentence"), m.StopRun: ("end", "why"),
    m.Bye: ("busy_s", "sentence"),
}  # fmt: skip
COUNTED = ("inputs", "spoken", "offer")
_schema = cache(msgspec.json.schema)  # of a type of messages, which many ports have


class RunRecorder(ClockedWork):
    """Recorder of a run without a file: computes only the digest of the events and the time reached."""

    def __init__(self) -> None:
        self.digest = Digest()
        self.last_ns = 0
        """Simulation time of the last event or sample [ns]."""
        self.slack: list[Slack] = []
        """Observed lookaheads of the ports of all nodes; known after the nodes have left."""

    def event(self, e: Event) -> None:
        """Record a committed event; events must arrive in total order."""
        self.last_ns = max(self.last_ns, e.t)
        self.digest.event(e.t, e.k, e.source, e.port, e.index, e.type, e.payload)

    def samples(self, node: str, batch: bytes) -> int:
        """Record a batch of samples; return the simulation time [ns] of its last sample."""
        return self.last_ns

    @property
    def notes(self) -> list[str]:
        """The notes for the user that nodes have sent so far; none if no file is written."""
        return []

    def settle(self, t_ns: int) -> None:
        """Take note that all data before this simulation time [ns] have arrived; does nothing without a file."""

    def protocol(
        self, t_ns: int, node: str, direction: str, message: m.AnyMessage, data: bytes, held: Held = ()
    ) -> None:
        """Record a message of the time protocol; `direction`: "to node" or "from node"; `held`: nodes that blocked a
        GRANT."""

    def checkpoint(self, at: Tag, state: bytes) -> None:
        """Record a checkpoint, which is not part of the digest: the kernel's state after everything before the logical
        time `at`."""

    def failed(self, message: m.Fail) -> None:
        """Record the failure of a node."""

    def note(self, t_ns: int, sentence: str) -> None:
        """Record, at this simulation time [ns], a failure from which the run has recovered; the note is not part of the
        digest."""

    def close(self, facts: Mapping[str, object]) -> None:
        """Finish the record of a run that ended without failure."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Record an error that ended the run."""


class FileRecorder(RunRecorder):
    """Recorder that writes a file; its ports must be announced before the run begins."""

    def __init__(
        self, output: Path, facts: Mapping[str, object], attachments: Mapping[str, bytes], force: bool = False
    ) -> None:
        super().__init__()
        machine = {"python": sys.version.split()[0], "platform": platform.platform()}
        self.recorder = Recorder(output, {**facts, **machine}, attachments, force=force)
        self.digest = self.recorder.digest
        self.facts: dict[str, object] = {}
        """Facts to record if an error ends the run."""
        self.worthless: Callable[[], bool] = lambda: False
        """Return whether no recording is to be left if an error ends the run now."""
        self._began_ns = time.perf_counter_ns()

    def port(self, model: str, port: str, type_: type[Message]) -> None:
        """Add a channel to the recording for an output port of a model."""
        self.recorder.add_port(model, port, _schema(type_), f"event/{model}/{port}", type_.units)

    @clocked
    def event(self, e: Event) -> None:
        """Record a committed event; events must arrive in total order."""
        self.last_ns = max(self.last_ns, e.t)
        self.recorder.event(e.t, e.k, e.source, e.port, e.index, e.type, e.payload)

    @property
    def notes(self) -> list[str]:
        """Notes for the user that nodes have sent so far, as sentences."""
        return [note.sentence for note in self.recorder.notes]

    @clocked
    def settle(self, t_ns: int) -> None:
        """Write the data before this simulation time [ns]."""
        self.recorder.settle(t_ns)

    @clocked
    def protocol(
        self, t_ns: int, node: str, direction: str, message: m.AnyMessage, data: bytes, held: Held = ()
    ) -> None:
        """Record a message of the time protocol with a summary and the data that `heavylift trace` needs."""
        summary = {**_summary(message), "wall_ns": time.perf_counter_ns() - self._began_ns}
        if held:
            summary["held"] = held
        self.recorder.protocol(t_ns, node, direction, m.name_of(message), summary, data)

    @clocked
    def checkpoint(self, at: Tag, state: bytes) -> None:
        """Store a checkpoint of the kernel as an attachment of the recording."""
        self.recorder.checkpoint(at, state)

    def failed(self, message: m.Fail) -> None:
        """Record the traceback of a failed node."""
        self.recorder.log(message.tag.t, "error", message.path, f"{message.sentence}\n{message.traceback}")

    def note(self, t_ns: int, sentence: str) -> None:
        """Log a failure from which the run has recovered."""
        self.recorder.log(t_ns, "warning", "coordinator", sentence)

    @clocked
    def close(self, facts: Mapping[str, object]) -> None:
        """Finish the recording with the outcome of the run and the observed lookaheads."""
        self.recorder.close("finished", "", {**facts, "slack": msgspec.to_builtins(self.slack)})

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if error is not None and self.worthless():
            self.recorder.discard()
        elif error is not None:
            self.recorder.close("failed", str(error) or type(error).__name__, self.facts)


def _summary(message: m.AnyMessage) -> dict[str, object]:
    """Return the fields of a message as they are recorded; lists are replaced by their lengths."""
    fields = SUMMARY.get(type(message), ())
    values = ((name, getattr(message, name)) for name in fields)
    return {name: len(x) if name in COUNTED else x for name, x in values}
