"""Simulation of one compiled system in integer time: steps, located events, samples.

Event times are rounded up to the next nanosecond and the state is integrated to that nanosecond. Steps depend on the
history of commands and state events only: `run(until)` never cuts a step: a step that passes `until` stays tentative,
and a command inside the step discards it.

    next_ns        time of the next located event, or of the end of the tentative step
    run(until)     commit steps up to `until`; stops at a subscribed event
    fire()         take the located event: integrate to it, switch the laws, return the events
    interrupt(t)   integrate to t, so that commands (see `commands`) can be given
    settle()       after events and commands: new derivative; guards that are negative after the jump become events

Its parts: `native` (state and machine code), `recorder` (samples), `integrator` (steps), `events`, and the commands.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.control import rounded, scale_of
from heavylift.kernel.model.program import Program
from heavylift.kernel.model.references import References
from heavylift.kernel.model.switching import StateChange, Switches
from heavylift.kernel.multibody.continuous_angles import starting
from heavylift.kernel.simulation.native.native_functions import Stepping
from heavylift.kernel.simulation.native.native_state import FOREVER_NS, NEVER, NativeState, Options
from heavylift.kernel.simulation.native.steps import EVENT, FAILED, RUNNING, STILL
from heavylift.kernel.simulation.safeguards.failures import check_resistance

from .call_protocol import FIRED, GOING, PAUSED, SETTLED, STOPPED, CallProtocol, check_present, check_time, passed_by
from .commands import CommandSwitches, CommandTarget
from .events import Events
from .held_rows import HeldRows
from .integrator import Integrator
from .recorder import SampleRecorder
from .shared_loads import note_shared_loads
from .snapshots import Snapshot, go_on, kept

__all__ = ["FOREVER_NS", "Simulation"]

SPELL = 4000  # attempted steps in one native call at most: 25 ms


class Simulation(CommandTarget):
    """Simulation of one mechanical system, from event to event.

    `subscribed`: laws whose events stop `run`; other arguments as in `Options`. Raises KernelError for an invalid
    system or option.
    """

    def __init__(
        self,
        system: System,
        tolerance: float = 1e-7,
        sample_ns: int = 500_000_000,
        subscribed: frozenset[str] = frozenset(),
        **options: Any,
    ) -> None:
        o = Options(tolerance, sample_ns, **options)
        self.subscribed = subscribed
        self.native = native = NativeState(system, o)
        self.references = References(native.program.parameters, native.P, system)
        check_resistance(native.program, native.state)
        self.switches = Switches(native.program, native.P)
        self.order = CallProtocol()
        self.held = HeldRows(native, self.references)
        self.recorder = SampleRecorder(native, sample_ns, tolerance, o.step)
        self.integrator = Integrator(native, self.recorder, self.references, self.held, o.step is not None)
        self.events = Events(native, self.integrator, self.switches, self.held, o.step or 0.0)
        self.commands = CommandSwitches(native, self.order, self.references, self.switches, self.held, self.events)
        self.X, self.P, self.state = native.X, native.P, native.state  # of the steps; of the scene; (ny,) at present
        self.rows, self.log, self.notes = self.recorder.rows, self.events.log, native.notes
        self.row, self.instant = native.row, native.instant
        self.still = False  # nothing moves, or will move by itself
        self._sets_of_ropes: set[frozenset[str]] = set()  # whose loads were looked at

    @property
    def program(self) -> Program:
        """The compiled program with the joints that are locked now."""
        return self.native.program

    @property
    def method(self) -> Stepping:
        """The native functions compiled for this simulation and method, with the layout of sample rows."""
        return self.native.method

    @property
    def epoch(self) -> int:
        """The time of the last event or command [ns]."""
        return self.native.epoch

    def __getitem__(self, name: str) -> float:
        """Return a scalar of the state block X."""
        return self.native[name]

    def _addressed(self, what: str, kind: str, name: str) -> CommandSwitches:
        return self.commands

    def start(self) -> None:
        """Find the discrete states of the initial pose and take the first sample; raises KernelError if the simulation
        has already advanced."""
        native = self.native
        self.order.check_new(native.epoch)
        self.references.write(0)
        self.held.assemble()
        # turns of angles before the start follow from the joints; a single pose would give them modulo 2 pi
        joints = [native.program.turned_at_start(label) for label in native.program.angles]
        native.angles[:] = [starting(float(x), y) for x, y in zip(self.row().turned, joints, strict=True)]
        native.set(peak_time=0.0)
        native.call("refresh")
        self.events.start()
        self.held.check_start()
        # contacts and rigid ropes may be closed at the start: their forces decide which of them carry
        if native.program.contacts.sites or native.program.system.rigid_ropes:
            self.held.resolve([], 0)
        self.integrator.new_stretch(0)
        self.order.phase = STOPPED
        self.settle()

    @property
    def next_ns(self) -> int:
        """The time [ns] of the located event or of the end of the tentative step; FOREVER_NS if nothing moves."""
        if self.events.fallen:
            return self.events.t_ns
        if self.still:
            return FOREVER_NS
        return self.native.reached_ns(self.native["t"])

    @property
    def event(self) -> bool:
        """Whether the next stop, at `next_ns`, is an event of a law whose events are subscribed."""
        return bool(self.events.fallen) and not self.subscribed.isdisjoint(self.events.names)

    @property
    def present_ns(self) -> int:
        """The earliest time [ns] at which commands are possible."""
        return self.events.present_ns

    @property
    def now(self) -> float:
        """Simulation time [s] reached by committed steps."""
        return self.native.now

    def run(self, until_ns: int, pause: Callable[[], None] = lambda: None) -> None:
        """Commit steps up to the time `until_ns` or a subscribed event; `pause` is called every 25 ms of work."""
        if self.order.phase == PAUSED:  # without a command in between
            self.settle()
        self.order.check_settled("run", self.epoch)
        check_time(until_ns)
        self.order.phase, native = GOING, self.native
        while not self.still:
            if self.events.fallen:
                if self.event or self.events.t_ns > until_ns:
                    return
                self.fire()
                self.settle()
                self.order.phase = GOING
                continue
            horizon = native.local(until_ns)
            # the last step already passes `until`: it stays tentative, so that grants do not influence steps
            if native["t"] > horizon and native["tentative"] > 0.0:
                return
            if native["t"] >= native["t_stop"]:
                self.integrator.pass_break()
            self._advance(horizon)
            pause()

    def _advance(self, horizon: float) -> None:
        """Take steps up to local time `horizon` in one native call, and handle the reason why it ended."""
        # spells end at fixed numbers of attempts, so that checks come at the same steps in any run
        native, done = self.native, self.native.attempts % SPELL
        if not done:
            self.integrator.check_pace(self.events.patience)
        rows = len(self.rows)
        native.set(run=1.0, status=RUNNING, budget=SPELL - done, until=horizon)
        native.call("advance")
        self.recorder.drain()
        self.held.check()
        status = native["status"]
        if status == FAILED or not np.isfinite(native["t"]):
            raise self.integrator.failure()
        # beyond an event the tentative state is not part of the run
        if status != EVENT and len(self.rows) > rows and self.recorder.energy.balance.strict:
            self.recorder.energy.check(native.raw(), native.now)
        if status == EVENT:
            self.events.locate()
        elif status == STILL:
            # the attempted step is undone: the scene rests in the state committed last
            self.events.take_back()
            self.still = True

    def preview(self) -> list[StateChange]:
        """Return the events that the next `fire` will return, without changing the state."""
        self.order.check_settled("preview", self.epoch)
        return self.events.preview()

    def fire(self) -> list[StateChange]:
        """Integrate to the located event and switch the laws whose guards are negative; return the events."""
        if not self.events.fallen:
            self.order.check_settled("fire", self.epoch)
            raise KernelError("no event has been located; call run() first")
        self.order.phase = STOPPED
        fallen, t_ns = self.events.take()
        self._end_stretch(t_ns)
        events = self.events.switch(fallen, t_ns)
        self.events.hear(events, t_ns)
        self.order.phase = FIRED
        return events

    def interrupt(self, t_ns: int, pause: Callable[[], None] = lambda: None) -> None:
        """Integrate to t_ns so that commands can be given; `pause` as in `run`.

        Raises KernelError for a time before committed steps or after an event.
        """
        if self.order.stands_at(t_ns, self.epoch):
            return
        check_present(t_ns, self.present_ns)
        # earlier ends of steps and unsubscribed events come first, or they would act on the state after the command
        self.run(t_ns, pause)  # what ends or happens unheard by then comes first
        if self.event and self.events.t_ns < t_ns:
            raise passed_by(t_ns, self.events.t_ns, self.events.names)
        # the step across t is discarded: the command changes its second part
        self.events.take_back()
        if self.still:
            self._rest(t_ns, pause)
        else:
            self.integrator.led(self.native.local(t_ns))
        self.integrator.commit()
        self._end_stretch(t_ns)
        self.events.forget()
        self.events.instant = 0
        self.order.phase = PAUSED

    def _rest(self, t_ns: int, pause: Callable[[], None]) -> None:
        """Record the samples of a scene at rest up to t_ns, without integration."""
        self.still = False
        self.integrator.note_peaks()
        try:
            self.recorder.rest(t_ns)
        finally:
            self._show_rest(pause)
        self.native.set(t=self.native.local(t_ns))

    def _show_rest(self, pause: Callable[[], None]) -> None:
        while self.recorder.unroll():
            pause()

    def _end_stretch(self, t_ns: int) -> None:
        """End the stretch of local time: the committed state at t_ns is the last one before a jump."""
        self.recorder.energy.end(self.now)
        self.integrator.new_stretch(t_ns)

    def foretold(self) -> tuple[int, np.ndarray] | None:
        # a flexible body near buckling counts time, so that its samples are not all alike
        """Return the time [ns] of the next sample and its row if nothing moves; None if something moves.

        All following samples repeat the row until a command comes. Does not change the state.
        """
        native = self.native
        bending = [x for x in self.program.guards if x[0] == "bending"] if self.program.axial else []
        if not self.still or any(self.P[self.program.parameters.at[x]][2] >= 0.0 for x in bending):
            return None  # what moves, or may buckle
        before = native.X.copy()
        self.integrator.note_peaks()
        row = np.array(self.method.row_layout.pack(native.row()))
        native.X[:] = before
        row[self.method.row_layout.at["peak_time"]] += self.epoch * 1e-9
        return self.recorder.next_ns, row

    def shown(self, t_ns: int) -> np.ndarray:
        """Return the sample row at a time within the tentative step, or at rest, without changing the state."""
        return self.native.shown(t_ns, self.events.before, self.still)

    def settle(self) -> None:
        """Recompute derivative and guards after an event or command; negative guards become immediate events."""
        native, program = self.native, self.program
        self.order.check_standing("settle", self.epoch)
        if self.order.phase == STOPPED:  # by a command; else it was done where the stretch begins
            self.references.write(self.epoch)
        native.set(
            t_stop=next(iter(self.references.breaks(self.epoch)), NEVER),
            t_rest=self.references.rest(self.epoch),
        )
        if native["scale"] < 1.0:
            # a jump in speed, such as by an impact, raises the scale at once
            native.set(scale=float(scale_of(native["scale"], [float(np.abs(native.velocities).max(initial=0.0))])))
        native.call("refresh")
        if native["scale"] < 1.0:
            # stiff laws may have changed, and with them what rounding does to accelerations
            native.set(**rounded(self._accelerations, self.state[: program.nq].copy(), native["tol"]))
        self.integrator.note_peaks()  # of a rope that a jump has tightened, and where no step lies between two samples
        row = native.raw().copy()
        # angles are integrated only to count their turns; within a turn the pose is exact
        native.angles[:] = row[self.method.row_layout.at["turned"]]  # without the error of their integrals
        self.recorder.energy.begin(row)
        if self.recorder.steps:
            self.recorder.steps.check(self.epoch, row)
        self.recorder.keep(self.epoch, row)
        # peaks count from here; those before the jump are in the row just kept
        native.set(peak=0.0)
        note_shared_loads(native, self._sets_of_ropes)
        self.events.look()
        self.order.phase = SETTLED

    def _accelerations(self, q: np.ndarray) -> np.ndarray:
        nq, y = self.program.nq, self.state.copy()
        y[:nq] = q
        return self.native.rate(y)[0][nq : nq + self.program.nv]

    def snapshot(self) -> Snapshot:
        """Return the complete state from which the run can continue (see `snapshots`)."""
        self.order.check_begun()
        return kept(self, self.native)

    def restore(self, snapshot: Snapshot) -> None:
        """Continue, bit for bit, from a snapshot of the same system and options. The simulation must have started."""
        self.order.check_begun()
        go_on(self, self.native, snapshot)
