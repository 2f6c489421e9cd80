"""The kernel as a node of the time protocol: located state events are its offers, and everything between them is silent
work ahead.

The kernel has zero lookahead. `next_time` is the logical time of the next located event to which a model subscribes, or
a silent logical time in the last microsteps before the nanosecond in which the tentative step ends, so that the ends of
steps and grants never influence the logical times of events. A committed event is a transition; an input within the
tentative step discards the step. Immediate consequences of a command (such as a lock that stops a joint) are sent at
the next microstep, before any work ahead. Samples come from committed steps only and are sent by `publish`, numbered.
Signals for subscribed models are sent at logical times of their own (see `sampling`), which do not influence anything
else.
"""

from bisect import bisect_left
from collections.abc import Mapping, Sequence

import msgspec
import numpy as np
from heavylift.kernel.description.mechanics import assembled
from heavylift.kernel.errors import HeavyliftError, KernelError, ModelError
from heavylift.kernel.islands.choice import simulate
from heavylift.kernel.islands.islands import Islands
from heavylift.kernel.model.switching import StateChange as Switched
from heavylift.kernel.simulation.commands import LiftRowsView
from heavylift.kernel.simulation.native.native_functions import Stepping
from heavylift.kernel.simulation.native.samples import channels
from heavylift.kernel.simulation.simulation import FOREVER_NS, Simulation
from heavylift.nodes.devs import FOREVER, Event, Message, Slack, Tag, succ
from heavylift.nodes.devs.execution.canonical import frozen, thawed
from heavylift.nodes.devs.ports import travelling
from heavylift.nodes.models import KERNEL
from heavylift.nodes.models.parts import messages as m

from .parts import KernelConfig
from .rows import RowSink
from .sampling import Sampling

BATCH = 256  # samples in one message, but for those of a rest, which are one row
FEW = 16  # rows of one lift alone that are worth a message
SILENT = 2**30  # microstep of silent tags


class KernelNode:
    """The mechanics kernel as a node of the protocol: a `Steppable` around a `Simulation`.

    The `sink` receives its samples and, if the node `foretells`, those of a scene at rest in advance. Rows of a single
    lift are numbered separately under its name.
    """

    def __init__(self, config: KernelConfig, sink: RowSink, foretells: bool = False) -> None:
        self._subscriptions: Mapping[str, list[str]] = config.subscriptions
        models = (model for models in config.subscriptions.values() for model in models)
        self.lookahead = {f"{KERNEL}.{_port(model)}": 0 for model in models}
        self.sink, self._foretells, self._period = sink, foretells, config.sample_ns
        self._sent = self._noted = 0
        self._before = FOREVER_NS  # samples from here on wait: a step may end where the run does [ns]
        self.pauses = 0
        """Number of native calls so far; it grows during a long step and so shows the progress of the node."""
        self._last = self._spoke = Tag(-1)  # of all transitions; of those with an output or an input
        self._offer: list[Switched] | None = None
        self._message: list[Switched] = []  # what the last commands have changed, for the next microstep
        self._ran = -1  # up to when the simulation was run last [ns]
        self.mechanics = assembled(config.systems, config.gravity)
        self.simulation: Simulation | Islands = simulate(
            self.mechanics, config.tolerance, config.sample_ns, frozenset(config.subscriptions), config.method,
            config.step, config.ties, config.apart, config.lifts,
        )  # fmt: skip
        self._apart = dict.fromkeys((lift.name for lift in self.simulation.alone), 0)  # rows sent of each lift alone
        self._sampling = Sampling(config.listening, self.simulation.program)
        self.lookahead |= self._sampling.lookahead

    def layout(self) -> bytes:
        """Return the encoded names and units of the columns of a sample row, for the recording."""
        lifts = {lift.name: {"channels": _columns(lift.method)} for lift in self.simulation.alone}
        whole: dict[str, object] = {"channels": _columns(self.simulation.method)}
        return msgspec.msgpack.encode(whole | ({"lifts": lifts} if lifts else {}))

    def start(self) -> None:
        """Start the kernel: compute its initial discrete states and the first tentative integration step."""
        self.simulation.start()
        self.simulation.run(0)

    @property
    def next_time(self) -> Tag:
        """Logical time of the kernel's next event: the report of a command's effects, a due sample, or a located state
        event.

        If there is none, a silent logical time just before the end of the tentative step.

        The silent logical time never shares its nanosecond with an event that is located later, since the ends of steps
        must not influence the microsteps of events.
        """
        if self._message:
            return succ(self._spoke)
        t = self.simulation.next_ns
        if (sample := self._sample) is not None:
            return sample
        if t >= FOREVER_NS:
            return FOREVER
        if self.simulation.event:
            return self._located
        return max(Tag(t - 1, SILENT), succ(self._last))

    @property
    def _sample(self) -> Tag | None:
        """Logical time of the next sample for models, if the tentative step reaches it before any event; else None."""
        if not self._sampling.done:  # nobody listens, as mostly
            return None
        due, s = self._sampling.next_ns, self.simulation
        shown = s.next_ns >= due if s.event else self._ran >= due or s.next_ns > due
        return Tag(due) if shown and due < FOREVER_NS and not self._message else None

    @property
    def _located(self) -> Tag:
        """Logical time of the located event."""
        return max(Tag(self.simulation.next_ns), succ(self._spoke))

    @property
    def last(self) -> Tag:
        """Logical time of the kernel's last transition."""
        return self._last

    def results(self, end: Tag) -> dict[str, Message]:
        """Return no results, since the samples contain everything that the kernel computes."""
        return {}

    @property
    def slack(self) -> list[Slack]:
        """Observed lookaheads: always empty, since the kernel schedules no output in response to an input."""
        return []

    @property
    def quiet(self) -> Tag:
        """Earliest logical time at which the kernel may send a message if no input arrives."""
        due = self.next_time
        spoken = self._message or self.simulation.event or self._sample
        return due if spoken else max(Tag(self.simulation.next_ns), succ(due))

    def outputs(self) -> list[Event]:
        """Return the state events at `next_time`, one copy for each subscribed model, and the samples that are due."""
        if not (self._message or self.simulation.event or self._sampling.done):
            return []
        tag, out, index = self.next_time, list[Event](), dict[str, int]()
        if tag == self._sample:
            out += self._sampling.outputs(self.simulation.shown)
        if self._offer is None and self.simulation.event and tag == self._located:
            self._offer = self.simulation.preview()
        for e in (*self._message, *(self._offer or ())):
            for model in self._subscriptions.get(e.name, ()):
                port = _port(model)
                value = travelling(m.StateEvent(e.name, e.what, e.value), f"{KERNEL}.{port}")
                out.append(Event.of(*tag, KERNEL, port, index.get(port, 0), value))
                index[port] = index.get(port, 0) + 1
        return sorted(out, key=lambda e: e.order)

    def among(self) -> list[Event]:
        """Return no events, since the kernel sends none within its own node."""
        return []

    def advance(self, tag: Tag, bag: Sequence[Event], until: Tag) -> None:
        """Process the kernel's located event, then the inputs at this logical time, and compute ahead up to `until`."""
        fires, message = self.simulation.event and tag == self._located, bool(self._message)
        if tag == self._sample:
            self._sampling.taken()
        if fires:
            self.simulation.fire()
        elif bag:
            self._before = tag.t  # all before it is history
            self.simulation.interrupt(tag.t, self._pause)
        self._last = tag
        if fires or bag or message:
            self._spoke = tag
        before = len(self.simulation.log)
        try:
            for event in bag:
                if not isinstance(event.value, m.KernelInput):
                    raise ModelError(f"the kernel does not accept a {type(event.value).__name__}; send a KernelInput")
                event.value.apply(self.simulation)
        except (KernelError, ModelError) as error:
            raise ModelError(f"{KERNEL} at {tag}: {error}") from error
        self._message = [e for _, e in self.simulation.log[before:] if e.name in self._subscriptions]
        if fires or bag:
            self.simulation.settle()
        self._work(until)

    def finish(self, end: Tag) -> str:
        """Publish the remaining samples of the kernel up to the end of the run."""
        rows, self._before = self.simulation.rows, end.t
        rows[:] = [row for row in rows if row[0] < end.t]
        for lift in self.simulation.alone:
            lift.rows[:] = [row for row in lift.rows if row[0] < end.t]
        self.simulation.run(end.t, self._pause)  # no grant is needed for what is said to nobody
        if (present := self.simulation.present_ns) <= end.t:  # else the run is broken off behind what was worked ahead
            at = max(end.t - 1, present)  # a step that ends with the run may be history
            self.simulation.interrupt(at, self._pause)
            self.simulation.settle()
            # islands that stood there are on record already, or the row waits for the sample at the same time
            last = rows.pop()[1] if rows and rows[-1][0] >= at else self.simulation.shown(at)
            rows[:] = [*(row for row in rows if row[0] < end.t), (end.t - 1, last)]
        self._flush(1)
        return ""

    def snapshot(self) -> bytes:
        """Return a snapshot of the simulation and of the numbers of samples and notes sent so far."""
        text = (
            self._sent, self._noted, self._last, self._spoke, self._message, self.sink.most, self._sampling.done,
            self._ran,
        )  # fmt: skip
        return frozen((self.simulation.snapshot(), text, self._apart))

    @property
    def said(self) -> tuple[int, int, np.ndarray]:
        """The numbers of samples and notes sent so far, and the largest absolute value in each column of the
        samples."""
        return self._sent, self._noted, self.sink.most

    def restore(self, snapshot: bytes) -> None:
        """Continue from a snapshot of a kernel with the same config."""
        simulation, text, self._apart = thawed(snapshot)
        self.simulation.restore(simulation)
        self._sent, self._noted, self._last, self._spoke, self._message, most, self._sampling.done, self._ran = text
        self.sink.most = most
        self._offer = None

    def _work(self, until: Tag) -> None:
        self._offer, self._before = None, until.t + (until.k > 0)
        self._sampling.renew()
        try:
            if not self._message:  # a model may answer it
                self._ran = min(until.t, self._sampling.next_ns)
                self.simulation.run(self._ran, self._pause)
        except HeavyliftError:
            self._flush(1)  # what came before an error, too
            raise
        self._flush()
        self.foretell()

    def foretell(self) -> None:
        """Publish in advance the sample row of a scene at rest, which repeats until a command arrives."""
        if self._foretells and (rest := self.simulation.foretold()):
            self.sink.rows(self.simulation.method, self._sent, [*self.simulation.rows, rest], (), self._period)

    def _pause(self) -> None:
        self.pauses += 1
        self.sink.paused(self.simulation)
        if len(self.simulation.rows) >= BATCH:
            self._flush()

    def _flush(self, least: int = FEW) -> None:
        """Publish the samples before the current grant in batches; batches begin at steps or grants, so that a
        replacement repeats them. `least`: number of rows of a single lift that are sent at once."""
        rows, notes = self.simulation.rows, self.simulation.notes
        while ready := bisect_left(rows, self._before, key=lambda row: row[0]):
            same = next((i for i in range(1, ready) if rows[i][1] is not rows[0][1]), ready)
            n = same if same > 1 else min(BATCH, ready)
            some, rows[:] = rows[:n], rows[n:]
            new = [(number, *notes[number]) for number in range(self._noted, len(notes))]
            self.sink.rows(self.simulation.method, self._sent, some, new)
            self._sent, self._noted = self._sent + len(some), len(notes)
        for lift in self.simulation.alone:
            if len(lift.rows) >= least:
                self._flush_apart(lift)

    def _flush_apart(self, lift: LiftRowsView) -> None:
        ready = bisect_left(lift.rows, self._before, key=lambda row: row[0])
        some, lift.rows[:] = lift.rows[:ready], lift.rows[ready:]
        if some:
            self.sink.apart(lift, self._apart[lift.name], some)
            self._apart[lift.name] += ready


def _columns(method: Stepping) -> list[dict[str, object]]:
    return [
        {"topic": c.topic, "names": list(c.names), "unit": c.unit, "start": c.start, "stop": c.stop}
        for c in channels(method)
    ]


def _port(model: str) -> str:
    return f"state_{model}"
