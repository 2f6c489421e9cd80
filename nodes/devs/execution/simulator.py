"""The abstract simulator of Parallel DEVS for a flattened model: one heap of distinct logical times, and direct routes.

One call of `advance(tag, bag)`, for tag = next_time or an earlier tag with inputs, does:
  1. lambda of all imminent atomics (those with next == tag), in path order;
  2. route: put each message into its receivers' bags at this same tag, ordered by source (see `flatten`);
  3. one transition per atomic: `internal` if imminent, `external` if it has input, `confluent` if both;
  4. next = after(tag, ta) for each; a wait of zero is due at the next microstep.
Driving it from a larger simulation: while min(next_time, first input) < limit, read `outputs()` if that
tag is next_time, then `advance`. `outputs` may be called any number of times, or not at all. `run` does this
for a model alone, for events at t < until. In a node it may advance ahead of the others, by a bounded number
of tags without outgoing events; messages between its models take direct routes and are kept for the recording
(`among`).
After Chow and Zeigler (1994); two phases after adevs. Broken rules raise ModelError.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs.events import BEGIN, FOREVER, NEVER, Event, Instant, Slack, Tag, tag_of
from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Atomic, Model, Present
from heavylift.nodes.devs.ports import Arrived, InPort, Port, travelling

from .bags import Schedule, deliver, entry, fitting, received, sorted_bag, spoken
from .flatten import Wire, flatten
from .rules import LIMIT, MicrostepLimit, Witness, fail, frozen, thawed
from .transitions import Border, Observed, Trace, Transition, TransitionLog, leaving, results_of, speak

SILENT = 256  # tags, and messages between its models, that a node works ahead of an `advance`


class Simulator:
    """Simulates a DEVS model on its own, or one or more models as the `Steppable` of a node."""

    def __init__(
        self,
        models: Model | Sequence[Model],
        log: Callable[[Transition], None] | None = None,
        microsteps: int = LIMIT,
        trace: Trace | None = None,
        watched: bool = True,
        wires: Iterable[Wire] | None = None,
    ) -> None:
        """Create a simulator of one or several models.

        `log` is called with every transition, `trace` stores them. `microsteps` is the number of microsteps at one time
        that raises ModelError for a zero-time loop. If `watched`, an output function that changes the state raises
        ModelError. `wires`: couplings (source, port, target, port) of the node's models.
        """
        self.models = [models] if isinstance(models, Model) else list(models)
        self._wires = None if wires is None else list(wires)
        self._patience, self._watched = MicrostepLimit(microsteps), watched
        self.trace = TransitionLog(log) if log is not None else trace
        self._present, self._observed = Present(live=True, node=wires is not None), Observed()
        self._due: Tag | None = None  # the next tag, once it is looked for
        self._adopt()

    def _adopt(self) -> None:
        """Flatten the present model tree."""
        if self.trace is not None:
            self.trace.settle()
        self.atomics, self._entries = flatten(self.models, self._wires)
        self._border = Border(self.models, self.atomics)
        self.lookahead = self._border.lookahead
        for m in (*self.atomics, *self.models):
            m._present = self._present

    @property
    def model(self) -> Model:
        """The simulated model; if several models are simulated, the first one."""
        return self.models[0]

    def start(self) -> None:
        """Set every atomic model to its initial state at (0, 0); a second call begins a new run."""
        self._last: Instant = (-1, 0)
        self._staged: list[tuple[InPort[Message], Message]] = []
        self._present.now, self._present.speaker, self._present.busy = (0, 0), None, False
        self._observed, self._witness = Observed(), Witness(self._watched)
        self._begin(())

    def _begin(self, known: Collection[Atomic]) -> None:
        """Continue from the last logical time with the present atomic models; models not in `known` are started."""
        self._witness.meet(self.atomics)
        self._due, self._spoken = None, False  # whether lambda has run for it
        self._schedule = Schedule(self.atomics, self._last, self._present, known)

    @property
    def next_time(self) -> Tag:
        """The logical time of the next internal transition; FOREVER if all atomic models are passive."""
        if self._present.busy:
            at = f"{self.model.path} at {Tag(*self._present.now)}"
            raise ModelError(f"{at}: a transition at this time failed, or called the simulator itself; start again")
        if self._present.changes:
            self._restructure()
        # a changed structure may have changed schedule and routes before the next tag is known
        if self._due is None:
            if not hasattr(self, "_schedule"):
                raise ModelError(f"{self.model.path}: the simulation has not begun; call start() first")
            self._due = tag_of(self._schedule.next(self._last))
        return self._due

    @property
    def passed(self) -> int:
        """Measure of progress that grows with the simulated time; another thread may read it."""
        return sum(self._present.now)

    @property
    def quiet(self) -> Tag:
        """The earliest logical time at which an event can leave the root model if no input arrives."""
        tag = self.next_time
        if tag == FOREVER or leaving(self._lambda(tag).sources):
            return tag
        return self._border.quiet(tag)

    def outputs(self) -> list[Event]:
        """Return the events that leave the root model at next_time, in total order, without changing the state."""
        tag = self.next_time
        text = self._lambda(tag)
        return spoken(tag, text.sources, text.values) if leaving(text.sources) else []

    def among(self) -> list[Event]:
        """Return the events sent within the node since the last call, which no other node receives, in total order."""
        return [event for at in self._observed.among() for event in spoken(*at, inner=True)]

    def inject(self, port: str, value: Message) -> None:
        """Put a message into an input port of the root model; the next `advance` delivers it."""
        into = entry(self.model, port)
        self._staged.append((into, travelling(fitting(into, value), repr(into))))

    def advance(self, tag: Tag, bag: Sequence[Event] = (), until: Tag = BEGIN) -> None:
        """Execute the transitions at `tag` with the sorted input events `bag` and the injected messages.

        Transitions before `until` are executed too, as long as no event leaves the root model."""
        due = self.next_time
        if tag == due:
            # lambda may have run already in `outputs`: it runs once per tag
            text = self._lambda(due)
            imminent, sources, values = self._schedule.imminent, text.sources, text.values
        elif tag <= self._last:
            raise ModelError(f"{self.model.path} at {Tag(*self._last)}: late message: {tag} has already passed")
        elif tag > due:
            raise ModelError(f"{self.model.path}: cannot advance to {tag}: the next transition is due before, at {due}")
        else:
            # an input comes first: what is imminent stays scheduled at its own tag
            self._schedule.wait()
            imminent, sources, values = [], [], []
        if bag or self._staged:
            # inputs from outside precede those of this node's models, by the order of sources
            heard = [*(received(self._entries, event) for event in bag), *self._staged]
            sources = [*(port for port, _ in heard), *sources]
            values = [*(value for _, value in heard), *values]
            self._staged = []
        self._work(tag, imminent, sources, values, until, SILENT)

    def run(self, until: int = NEVER, stop: Callable[[], bool] | None = None) -> None:
        """Execute all transitions at t < `until` [ns], or stop after the first transition at which `stop()` returns
        true; a second call continues the run."""
        due, until = self.next_time, min(until, NEVER)
        while due.t < until:
            if self._staged:
                self.advance(due)
            else:
                text = self._lambda(due)
                end = (until, 0) if stop is None else BEGIN
                self._work(due, self._schedule.imminent, text.sources, text.values, end)
            if stop is not None and stop():
                return
            due = self.next_time

    def _work(
        self,
        tag: Instant,
        imminent: list[int],
        sources: list[Port[Message]],
        values: list[Message],
        until: Instant,
        silent: int = 0,
    ) -> None:
        """Execute steps 2 to 4 (see the module) at `tag`, and all steps at later logical times before `until`, while
        the model structure stays the same. If `silent` > 0, execute at most this many logical times, and only while no
        event leaves and the time does not stand still for long."""
        present, schedule, atomics, trace = self._present, self._schedule, self.atomics, self.trace
        border, witness, move, patience = self._border, self._witness, schedule.move, self._patience.start
        promises, noted, heard = border.promises, border.noted, border.spoken
        self._spoken, present.busy = False, True
        while True:
            (t, k), soon = tag, schedule.soon
            present.now = tag
            reached = deliver(sources, values, t) if sources else ()
            if heard and sources:
                self._observed.note(tag, sources, values, noted)
            movers = [*imminent, *reached] if reached else imminent
            # from late microsteps on, models are recorded, to name those of a loop in which time stands still
            if k >= patience:
                self._patience.watch(tag, [atomics[i].path for i in movers])
            for i in movers:
                m = atomics[i]
                what = "internal"
                try:
                    if m._port is None:
                        m.internal()
                    else:
                        if m._more is None:
                            x: Any = Arrived()
                            x[m._port] = [m._value]
                        else:
                            x = sorted_bag(m)
                        m._port = m._value = None
                        # elapsed time counts from the last transition, as in Zeigler's external transition function
                        if m._t != t:
                            what = "external"
                            m.external(t - m._last, x)
                        # the default confluent function, written out: internal, then external with elapsed time zero
                        elif m._plain:
                            m.internal()
                            what = "external"
                            m.external(0, x)
                        else:
                            what = "confluent"
                            m.confluent(x)
                except BaseException as error:
                    fail(m, tag, what, error)
                m._last, wait = t, m._wait
                # hold_in or passivate must be called in the transition that was scheduled; an input may keep the old
                # schedule
                if wait is None:
                    if m._t == t:
                        fail(m, tag, what, ModelError(f"{what}() scheduled nothing: call hold_in or passivate"))
                else:
                    m._wait, m._set = None, t
                    if wait:
                        move(m, t + wait, t)
                    else:
                        if m._t != t:
                            move(m, t, t)
                        # a wait of zero is due at the next microstep, which needs no heap
                        soon.append(i)
            if trace is not None:
                trace.note(tag, atomics, imminent, sources, values)
            # requested changes of structure happen between tags
            due = None if present.changes else schedule.next(tag)
            if due is None or due >= until or (silent and (silent == 1 or due[1] >= patience)):
                self._last, self._due, present.busy = tag, None if due is None else tag_of(due), False
                return
            speak(due, schedule.imminent, atomics, present, witness, promises)
            if silent:
                # working ahead without events to others is bounded, or the coordinator would not hear of this node
                silent -= 1
                if present.sources:
                    if leaving(present.sources):
                        self._last, self._due, present.busy, self._spoken = tag, tag_of(due), False, True
                        return
                    if noted:
                        silent = max(1, silent - len(present.sources))
            tag, imminent, sources, values = due, schedule.imminent, present.sources, present.values

    def _restructure(self) -> None:
        """Apply the changes of the model structure that were requested during the last transitions."""
        changes, before, border = self._present.changes, set(self.atomics), self._border
        self._present.changes, self._present.live = [], False
        # models must not call into a structure that is being changed
        for where, change in changes:
            try:
                change()
            except ModelError as error:
                raise ModelError(
                    f"{error} (in a change of the structure of {where.path} at {Tag(*self._last)})"
                ) from None
        self._present.live = True
        self._adopt()
        # others rely on the lookaheads declared in HELLO
        self._border.still_promises(Tag(*self._last), border)
        self._begin(before)

    def snapshot(self) -> bytes:
        """Return the complete state after a transition as bytes; raises ModelError if a part of it cannot be saved."""
        _ = self.next_time  # what was asked of the structure has happened then
        return frozen(self.models, self._last, self._staged)

    def restore(self, snapshot: bytes) -> None:
        """Continue from a snapshot; the objects in `models` and `atomics` are replaced by new ones."""
        self.models, self._last, self._staged = thawed(snapshot, self.models)
        self._present.now, self._present.busy = self._last, False
        self._adopt()
        self._observed, self._witness = Observed(), Witness(self._watched)
        self._begin(set(self.atomics))

    def _lambda(self, tag: Instant) -> Present:
        """Return the outputs of the imminent models at `tag` = next_time, in the order of their paths; they are
        computed only once."""
        if not self._spoken:
            speak(tag, self._schedule.imminent, self.atomics, self._present, self._witness, self._border.promises)
            self._spoken = True
        return self._present

    @property
    def last(self) -> Tag:
        """The logical time of the last transition; (-1, 0) before the first one."""
        return Tag(*self._last)

    def results(self, end: Tag | int = 0) -> dict[str, Message]:
        """Return the results of the atomic models at the end of a run, by model path, without models that have no
        result.

        `end`: logical time of the end, or time [ns]."""
        _ = self.next_time  # what was asked of the structure has happened then
        at = Tag(end) if isinstance(end, int) else end
        return results_of(self.atomics, self._present, max(self.last, at, Tag(0)))

    @property
    def slack(self) -> list[Slack]:
        """The observed lookaheads of output ports that send to other nodes, since start or restore."""
        return self._observed.table()
