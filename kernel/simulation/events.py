"""Events: located inside a step, looked at beforehand, then taken: the laws behind fallen guards switch in fixed order.

A guard that falls stops the run; the step is done again up to the next whole nanosecond, where it is seen what has
fallen.  Until `fire` all of that can be taken back.
"""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.description.notes import Note
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.force_law import Ended
from heavylift.kernel.forces.ropes import RopeAt
from heavylift.kernel.model.switching import StateEvent
from heavylift.kernel.simulation.assembly.causes import torn
from heavylift.kernel.simulation.impacts.active_sets import KINDS
from heavylift.kernel.simulation.native.peaks import last
from heavylift.kernel.simulation.safeguards.chatter import RESOLVED, Rattling, critical, moved_mass
from heavylift.kernel.simulation.safeguards.deflection_check import bent, pass_limit
from heavylift.kernel.simulation.safeguards.progress_limit import Patience

from .call_order import STOPPED
from .commands import Commanded
from .stepper import FOREVER_NS

__all__ = ["Eventful"]

CHATTER = 200  # events at one instant, after which the laws contradict each other


class Eventful(Commanded):
    """A commanded stepper whose events can be located and fired; `subscribed`: names of laws whose events stop `run`.

    The other arguments are those of `Stepper`.
    """

    def __init__(self, subscribed: frozenset[str], system: System, *options: Any) -> None:
        super().__init__(system, *options)
        self.subscribed = subscribed
        self._fallen: list[int] = []
        self._event_ns = FOREVER_NS
        self._instant = 0  # events in a row at the same nanosecond
        self._elastic = [r.name for r in system.ropes]
        self._rattling = Rattling(max(self._step, RESOLVED))
        self._patience = Patience(round(RESOLVED * 1e9))
        self._snapshot: np.ndarray | None = None

    @property
    def event(self) -> bool:
        """Whether `next_ns` is an event that somebody subscribed to."""
        return not self.subscribed.isdisjoint(self.falling)

    def _restore(self) -> None:
        """Back to the start of the tentative step."""
        if self._snapshot is not None:
            self.X[:] = self._snapshot
            self._forget()
        if self["tentative"] > 0.0:
            self._to_start()

    def _locate(self) -> None:
        """A guard fell inside the tentative step: integrate to the next nanosecond and see what has fallen there."""
        t_ns = self.epoch + max(0, ceil((self["t0"] + self["hi"] * self["h0"]) * 1e9))
        self._snapshot = self.X.copy()
        self._to_start()
        self._forced(self._local(t_ns))
        fallen = np.flatnonzero(self.X[self._at["G"]] < 0.0)
        if len(fallen):
            self._fallen, self._event_ns = [int(i) for i in fallen], t_ns
        else:  # the true solution crosses a moment later
            self._snapshot = None

    def _admit(self, what: str) -> None:
        """A command may undo an event of its instant: `settle` looks again."""
        super()._admit(what)
        self._forget()

    def _forget(self) -> None:
        self._snapshot, self._fallen, self._event_ns = None, [], FOREVER_NS

    @property
    def falling(self) -> list[str]:
        """Names of the laws whose event is at `next_ns`."""
        return [self.program.guards[i][1] for i in self._fallen]

    @property
    def fallen(self) -> bool:
        """Whether `next_ns` is an event at all, heard or not."""
        return bool(self._fallen)

    def preview(self) -> list[StateEvent]:
        """What `fire` will return; changes nothing."""
        self.order.check_settled("preview", self.epoch)
        P, X = self.P.copy(), self.X.copy()
        events = self._switch(self._fallen, self._event_ns)
        self.P[:], self.X[:] = P, X
        return events

    def _switch(self, fallen: list[int], t_ns: int) -> list[StateEvent]:
        """Switch the laws behind fallen guards in fixed order, then all rigid ropes and contacts together."""
        row = self.row()
        limits = [self.program.guards[i][1] for i in fallen if self.program.guards[i][0] == "bending"]
        bending = [pass_limit(self, name, t_ns) for name in limits]
        parting = {self.program.guards[i][1] for i in fallen if self.program.guards[i][0] == "support"}
        gone = {("bending", name) for name in limits} | {("rub", name) for name in parting}  # what opens does not slip
        fallen = [i for i in fallen if self.program.guards[i] not in gone]
        kinds = [self.program.guards[i][0] for i in fallen]
        together = ("rigid", *KINDS)
        try:
            events = [self.switches.fire(i, row) for i, kind in zip(fallen, kinds, strict=True) if kind not in together]
        except Ended as ended:
            raise ended.at(t_ns * 1e-9) from None
        self._heat(row)
        if any(kind in together for kind in kinds):
            events += self._resolve_rows(fallen, t_ns)
        return bending + events

    def fire(self) -> list[StateEvent]:
        """Integrate to the located event and switch all laws whose guards have fallen there, in fixed order."""
        if not self._fallen:
            self.order.check_settled("fire", self.epoch)
            raise KernelError("no event has been located; run first")
        self.order.phase = STOPPED
        fallen, t_ns = self._fallen, self._event_ns
        self._forget()
        self._commit()
        self._instant = self._instant + 1 if t_ns == self.epoch else 0
        if self._patience.crowded(t_ns) or self._instant > CHATTER:
            raise self._chatter(fallen, t_ns)
        last(self)
        self._end_balance()
        self._new_stretch(t_ns)
        events = self._switch(fallen, t_ns)
        self.log += [(t_ns, e) for e in events]
        for e in events:
            self._listen(e, t_ns)
        return events

    def _listen(self, e: StateEvent, t_ns: int) -> None:
        """A beam at its first limit is noted; a rope that rattles goes on without events, damped, and is noted."""
        if e.what == "bent":
            self.notes.append(bent(self, e.name, t_ns))
        if e.what != "taut" or e.name not in self._elastic or not (hertz := self._rattling.hear(e.name, t_ns)):
            return
        p, i = self.switches.rope_numbers(e.name), self._elastic.index(e.name)
        nq = self.program.nq
        mass = moved_mass(p, i, slice(nq, nq + self.program.nv), self.state.copy(), self._rate)
        p[RopeAt.DAMPING] = max(p[RopeAt.DAMPING], critical(p[RopeAt.EA], float(self.row().length[i]), mass))
        self._calm |= {e.name}
        self._use(self.program.locked)
        self.log.append((t_ns, StateEvent(e.name, "chatter", hertz)))
        told = (
            f"rope '{e.name}' at {t_ns * 1e-9:.3f} s: it goes slack and taut at {hertz:.3g} Hz, faster than events can "
            f"resolve; it goes on without events, damped with {p[RopeAt.DAMPING]:.3g} N s/m, until it is hooked anew"
        )
        self.notes.append(Note(t_ns, told))

    def _may_move(self, rope: str) -> bool:
        """Whether a rigid rope can move anything."""
        row = len(self.program.constraints.of) + [r.name for r in self.program.system.rigid_ropes].index(rope)
        return bool(self.instant().constraint_rows().movable[row])

    def _chatter(self, fallen: list[int], t_ns: int) -> KernelError:
        touching = any(self.program.guards[i][0] in KINDS for i in fallen)
        names = ", ".join(sorted({self.program.guards[i][1] for i in fallen}))
        if ropes := [self.program.guards[i][1] for i in fallen if self.program.guards[i][0] == "rigid"]:
            told = torn(self.program, ropes[0], self._may_move(ropes[0]), self._moving())
            if told:
                return KernelError(f"rope '{ropes[0]}' at {t_ns * 1e-9:.9f} s: {told}")
        cure = "let a support with stiffness take the contact's place" if touching else "soften or damp the law"
        where = f"contact '{names}'" if touching else names
        return KernelError(f"{where} at {t_ns * 1e-9:.9f} s: states switch without end; {cure}")
