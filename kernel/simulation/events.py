"""Events of a run: located inside a step, previewed, then executed: the laws of negative guards switch in a fixed
order.

A guard that becomes negative stops the run; the step is repeated up to the next whole nanosecond, where the guards are
evaluated again. Until the events are taken, all of this can be undone.
"""

from math import ceil
from types import SimpleNamespace

import numpy as np
from heavylift.kernel.description.findings import Note
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.force_law import LawBreakdown
from heavylift.kernel.forces.ropes import RopeAt
from heavylift.kernel.model.switching import StateChange, Switches
from heavylift.kernel.simulation.impacts.unilateral import KINDS
from heavylift.kernel.simulation.native.native_state import FOREVER_NS, NativeState
from heavylift.kernel.simulation.safeguards.chatter import RESOLVED, Rattling, StepBudget, critical, moved_mass
from heavylift.kernel.simulation.safeguards.deflection_check import bent, pass_limit

from .held_rows import HeldRows
from .integrator import Integrator

CHATTER = 200  # events at one instant, after which the laws contradict each other


class Events:
    """Locates the next event of a run, switches the force laws at the event, and logs past events."""

    def __init__(
        self, native: NativeState, integrator: Integrator, switches: Switches, held: HeldRows, step: float
    ) -> None:
        self._native, self._integrator, self._switches, self._held = native, integrator, switches, held
        self.fallen: list[int] = []  # guards that are negative at the located event
        self.t_ns = FOREVER_NS  # its time [ns]
        self.before: np.ndarray | None = None  # X before the event was located
        self.instant = 0  # consecutive events at the same time
        self.log: list[tuple[int, StateChange]] = []  # past events with times [ns]
        self._elastic = [r.name for r in native.program.system.ropes]
        self.rattling = Rattling(max(step, RESOLVED))
        self.patience = StepBudget(round(RESOLVED * 1e9))

    @property
    def names(self) -> list[str]:
        """Names of the laws that switch at the located event."""
        return [self._native.program.guards[i][1] for i in self.fallen] if self.fallen else []

    @property
    def present_ns(self) -> int:
        """The earliest time [ns] at which commands are possible."""
        native = self._native
        # a command may come at any time from the start of the tentative step on, as that step can still be discarded
        X = native.X if self.before is None else self.before
        return native.reached_ns(float(X[native.at["t0" if X[native.at["tentative"]] > 0.0 else "t"]]))

    def start(self) -> None:
        """Set the discrete states of the laws in the initial pose."""
        native = self._native
        row, switched = None, list[object]()
        for i in self._below():
            found = native.program.of_guard.get(native.program.guards[i])
            # only guards that set the states of the initial pose; the others become events
            if found and found.law.initial:
                if row is None or any(found is x for x in switched):  # what a law shows depends on its own states alone
                    row, switched = native.row(), []
                self._switches.fire(i, row)
                switched.append(found)

    def look(self) -> None:
        """Look for guards that are negative after a jump of the state; they become an event at the present time."""
        self.fallen = self._below()
        self.t_ns = self._native.epoch if self.fallen else FOREVER_NS

    def _below(self) -> list[int]:
        return [i for i, x in enumerate(self._native.part("G").tolist()) if x < 0.0]

    def locate(self) -> None:
        """Locate the event in the tentative step at which a guard becomes negative, to the nanosecond."""
        native = self._native
        # the first nanosecond at which the guard is negative: half-open interval (t0, t1], so that an event fires once
        t_ns = native.epoch + max(0, ceil((native["t0"] + native["hi"] * native["h0"]) * 1e9))
        self.before = native.X.copy()
        # repeated as a forced step: its end is a mesh point and not a value of the dense output
        self._integrator.take_back()
        solved = self._integrator.forced(native.local(t_ns))
        if solved and (fallen := self._below()):
            self.fallen, self.t_ns = fallen, t_ns
        # the step to the nanosecond is another one than the tentative step, and may differ by its error
        else:  # the true solution crosses a moment later, or is approached in shorter steps
            self.before = None

    def forget(self) -> None:
        """Discard the located event, without undoing the step."""
        self.before, self.fallen, self.t_ns = None, [], FOREVER_NS

    def take_back(self) -> None:
        """Undo the tentative step and return to its start."""
        if self.before is not None:
            self._native.X[:] = self.before
            self.forget()
        if self._native["tentative"] > 0.0:
            self._integrator.take_back()

    def take(self) -> tuple[list[int], int]:
        """Commit the step up to the located event; return negative guards and time. Raises KernelError for too many
        events."""
        fallen, t_ns = self.fallen, self.t_ns
        self.forget()
        self._integrator.commit()
        self.instant = self.instant + 1 if t_ns == self._native.epoch else 0
        if self.patience.crowded(t_ns) or self.instant > CHATTER:
            raise self._chatter(fallen, t_ns)
        return fallen, t_ns

    def preview(self) -> list[StateChange]:
        """Return the state changes of force laws that the located event would cause, without changing anything."""
        P, X = self._native.P.copy(), self._native.X.copy()
        events = self.switch(self.fallen, self.t_ns)
        self._native.P[:], self._native.X[:] = P, X
        return events

    def switch(self, fallen: list[int], t_ns: int) -> list[StateChange]:
        """Switch the laws whose guards are negative, then rigid ropes and contacts; return the state changes."""
        native, guards = self._native, self._native.program.guards
        # one row for all laws, so that no law sees the switched state of another
        row = native.row()
        limits = [guards[i][1] for i in fallen if guards[i][0] == "bending"]
        bending = [pass_limit(native, name, t_ns) for name in limits]
        parting = {guards[i][1] for i in fallen if guards[i][0] == "support"}
        # a pad that opens has no friction left to slip
        gone = {("bending", name) for name in limits} | {("rub", name) for name in parting}  # what opens does not slip
        fallen = [i for i in fallen if guards[i] not in gone]
        # contacts and rigid ropes exchange impulses and can be solved together only
        together = [i for i in fallen if guards[i][0] in ("rigid", *KINDS)]
        try:
            events = [self._switches.fire(i, row) for i in fallen if i not in together]
        except LawBreakdown as ended:
            raise ended.at(t_ns * 1e-9) from None
        self.heat(row)
        if together:
            events += self._held.resolve(fallen, t_ns)
        return bending + events

    def heat(self, before: SimpleNamespace) -> None:
        # a switch keeps coordinates and velocities; elastic energy that a law forgets becomes its heat
        """Count as heat the stored energy that laws have lost by switching; `before`: sample row before the switch."""
        native = self._native
        first = native.program.nq + native.program.nv
        stored = native.method.row_layout.at["stored"]
        native.state[first : first + len(before.stored)] += before.stored - native.raw()[stored]

    def hear(self, events: list[StateChange], t_ns: int) -> None:
        """Log events, add a note when a beam reaches its first deflection limit, and damp rattling elastic ropes."""
        native = self._native
        self.log += [(t_ns, e) for e in events]
        for e in events:
            if e.what == "bent":
                native.notes.append(bent(native, e.name, t_ns))
            if e.what == "taut" and e.name in self._elastic and (hertz := self.rattling.hear(e.name, t_ns)):
                self._calm(e.name, t_ns, hertz)

    def _calm(self, rope: str, t_ns: int, hertz: float) -> None:
        """Continue a rope without events, with critical damping."""
        # critical damping for the mass that the rope moves: the rattle dies out within one period
        native, p, i = self._native, self._switches.rope_numbers(rope), self._elastic.index(rope)
        nq = native.program.nq
        mass = moved_mass(p, i, slice(nq, nq + native.program.nv), native.state.copy(), native.rate)
        p[RopeAt.DAMPING] = max(p[RopeAt.DAMPING], critical(p[RopeAt.EA], float(native.row().length[i]), mass))
        native.calm |= {rope}
        native.use(native.program.locked)
        self.log.append((t_ns, StateChange(rope, "chatter", hertz)))
        message = (
            f"rope '{rope}' at {t_ns * 1e-9:.3f} s: it goes slack and taut at {hertz:.3g} Hz, faster than events can "
            f"resolve; it goes on without events, damped with {p[RopeAt.DAMPING]:.3g} N s/m, until it is hooked anew"
        )
        native.notes.append(Note(t_ns, message))

    def _chatter(self, fallen: list[int], t_ns: int) -> KernelError:
        guards = [self._native.program.guards[i] for i in fallen]
        ropes = [name for kind, name in guards if kind == "rigid"]
        if ropes and (message := self._held.torn(ropes[0])):
            return KernelError(f"rope '{ropes[0]}' at {t_ns * 1e-9:.9f} s: {message}")
        names = ", ".join(sorted({name for _, name in guards}))
        touching = any(kind in KINDS for kind, _ in guards)
        cure = "let a support with stiffness take the contact's place" if touching else "soften or damp the law"
        where = f"contact '{names}'" if touching else names
        return KernelError(f"{where} at {t_ns * 1e-9:.9f} s: states switch without end; {cure}")
