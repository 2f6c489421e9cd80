"""Runs one compiled system in integer time: steps, located events, samples.

Local time is float seconds since the last event or command (the epoch); event times are rounded up to the next
nanosecond and the state is integrated to that nanosecond.  Steps depend on the history of commands and state events
only: `run(until)` never cuts a step, the one that passes `until` stays tentative, and a command inside it discards it.

    next_ns        when something is known to happen: a located event, or the end of the tentative step
    run(until)     commit steps up to `until`; stops at an event that somebody subscribed to
    fire()         take the located event: integrate to it, switch the laws, return what happened
    interrupt(t)   integrate to t, so that commands (see `commands`) can be given
    settle()       after events and commands: new derivative, guards that the jump has made true
"""

from __future__ import annotations

from collections.abc import Callable
from math import ceil
from typing import Any

import numpy as np
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.small_motions import rounded, scale_of
from heavylift.kernel.multibody.continuous_angles import starting
from heavylift.kernel.simulation.native.native_state import ROWS
from heavylift.kernel.simulation.native.peaks import last
from heavylift.kernel.simulation.native.steps import EVENT, FAILED, RUNNING, STILL
from heavylift.kernel.simulation.safeguards.deflection_check import LASTING, check_compression
from heavylift.kernel.simulation.safeguards.failures import too_slow

from .call_order import GOING, PAUSED, SETTLED, STOPPED, check_present, check_time, passed_by
from .events import Eventful
from .shared_loads import note_shared_loads
from .snapshots import go_on, kept
from .stepper import FOREVER_NS, NEVER

__all__ = ["FOREVER_NS", "Simulation"]

SPELL = 4000  # attempted steps in one native call at most: 25 ms
TOO_SHORT = 1e-6  # [m] by which a rigid rope may be too short by rounding


class Simulation(Eventful):
    """`tolerance`: of a step, relative to 1 + |y|; `sample_ns`: period of samples; `subscribed`: names of laws whose
    events stop `run`; `native=False` runs the same text on floats (slow oracle); `method`: one of
    `kernel.methods.METHODS`; `step`: fixed steps of so many seconds; `formulation`: one of
    `kernel.multibody.formulations.FORMULATIONS`; `fused`: products are added unrounded, a little faster, with bits
    that depend on the processor.  Raises KernelError."""

    def __init__(
        self,
        system: System,
        tolerance: float = 1e-7,
        sample_ns: int = 500_000_000,
        subscribed: frozenset[str] = frozenset(),
        h_max: float = 0.1,
        native: bool = True,
        opt: int = 1,
        cache: bool = True,
        method: str = "dopri5",
        step: float | None = None,
        formulation: str = "recursive",
        fused: bool = False,
    ) -> None:
        options = (tolerance, sample_ns, h_max, native, opt, cache, method, step, formulation, fused)
        super().__init__(subscribed, system, *options)
        self._still = False
        self._rested: tuple[int, int, np.ndarray] | None = None
        """A rest that is over: its first sample without a row [ns], what it ends before [ns], its row."""
        self._sets_of_ropes: set[frozenset[str]] = set()  # whose loads were looked at

    # ---- life ---------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Find the discrete states of the initial pose, take the first sample; raises KernelError the second time."""
        self.order.check_new(self.epoch)
        self.references.write(0)
        self._assemble()
        self._begin_angles()
        self._set(peak_time=0.0)
        self._call("refresh")
        for i, guard in enumerate(self.program.guards):
            found = self.program.of_guard.get(guard)
            if found and found.law.initial and self.X[self._at["G"]][i] < 0.0:
                self.switches.fire(i, self.row())
        self._check_ropes()
        if self.program.contacts.sites:
            self._contacts.check_start(self.state)
        if self.program.contacts.sites or self.program.system.rigid_ropes:
            self._resolve_rows([], 0)
        self._new_stretch(0)
        self.order.phase = STOPPED
        self.settle()

    def _begin_angles(self) -> None:
        """Count angles from the turns of their joints."""
        joints = [self.program.turned_at_start(label) for label in self.program.angles]
        self._angles[:] = [starting(float(x), y) for x, y in zip(self.row().turned, joints, strict=True)]

    def _check_ropes(self) -> None:
        """Raises KernelError for a rigid rope that is hooked and too short at the start."""
        for r, slack in zip(self.program.system.rigid_ropes, self.row().slack, strict=True):
            if r.hooked and slack < -TOO_SHORT:
                raise KernelError(
                    f"rope '{r.name}': it is rigid and {-slack * 1e3:.3g} mm too short for its ends; "
                    "make it longer or bring them closer"
                )

    @property
    def next_ns(self) -> int:
        """Time of the located event, or of the end of the tentative step; FOREVER_NS if nothing moves any more."""
        if self._fallen:
            return self._event_ns
        if self._still:
            return FOREVER_NS
        return self.epoch + ceil(self["t"] * 1e9)

    @property
    def present_ns(self) -> int:
        """First time at which commands can still be given; steps until then are history."""
        X = self.X if self._snapshot is None else self._snapshot
        t = float(X[self._at["t0" if X[self._at["tentative"]] > 0.0 else "t"]])
        present = self.epoch + max(0, ceil(t * 1e9) - 1)
        return present if self._local(present) >= t else present + 1

    @property
    def now(self) -> float:
        """Time up to which steps have been taken [s]."""
        return self.epoch * 1e-9 + self["t"]

    def run(self, until_ns: int, pause: Callable[[], None] = lambda: None) -> None:
        """Commit steps that end by `until_ns`, none if that is past; `pause` is called every 25 ms of work."""
        if self.order.phase == PAUSED:  # without a command in between
            self.settle()
        self.order.check_settled("run", self.epoch)
        check_time(until_ns)
        self.order.phase = GOING
        while not self._still:
            if self._fallen:
                if self.event or self._event_ns > until_ns:
                    return
                self.fire()
                self.settle()
                self.order.phase = GOING
                continue
            horizon = self._local(until_ns)
            if self["t"] > horizon and self["tentative"] > 0.0:
                return
            if self["t"] >= self["t_stop"]:
                self._pass_break()
            elif "top" in self._at and self["peaking"] > 0.0:
                self._commit()
            done = self._attempts % SPELL
            if not done:
                self._check_pace()
            rows = len(self.rows)
            self._set(run=1.0, status=RUNNING, budget=SPELL - done, until=horizon)
            self._call("advance")
            self._drain()
            self._check_rows()
            status = self["status"]
            if status == FAILED or not np.isfinite(self["t"]):
                raise self._failure()
            if status != EVENT and len(self.rows) > rows and self._balance.strict:
                self._check_energy(self._raw(), self.epoch * 1e-9 + self["t"])
            if status == EVENT:
                self._locate()
            elif status == STILL:
                self._restore()
                self._still = True
            pause()

    def _accelerations(self, q: np.ndarray) -> np.ndarray:
        nq, y = self.program.nq, self.state.copy()
        y[:nq] = q
        return self._rate(y)[0][nq : nq + self.program.nv]

    @property
    def _attempts(self) -> float:
        return self["accepted"] + self["rejected"]

    def _check_pace(self) -> None:
        """Raises KernelError if the run stops making progress."""
        t = self.epoch * 1e-9 + self["t"]
        if self._patience.ends(self._attempts, t):
            mode = self._fastest()
            raise too_slow(self.method.method.name, t, self["h0"], mode.told if mode else "")

    def _pass_break(self) -> None:
        """Between two pieces of a profile or history: commit, and a new derivative, since forces may jump."""
        self._commit()
        self.references.histories.write(self.epoch, self["t"])
        self._set(t_stop=next(iter(self.references.breaks(self.epoch, self["t"])), NEVER))
        self._call("refresh")

    # ---- stops --------------------------------------------------------------------------------------------

    def interrupt(self, t_ns: int, pause: Callable[[], None] = lambda: None) -> None:
        """Integrate to t_ns, so that commands can be given there; `pause` is called now and then, as in `run`.

        Raises KernelError for a time before steps that are committed, or behind an event that somebody subscribed to.
        """
        self.order.check_begun()
        check_time(t_ns)
        if self.order.phase in (PAUSED, STOPPED) and t_ns == self.epoch:
            return
        self.order.check_settled("interrupt", self.epoch)
        check_present(t_ns, self.present_ns)
        self.run(t_ns, pause)  # what ends or happens unheard by then comes first
        if self.event and self._event_ns < t_ns:
            raise passed_by(t_ns, self._event_ns, self.falling)
        self._restore()
        if self._still:
            self._rest(t_ns, pause)
        else:
            self._led(self._local(t_ns))
        self._commit()
        last(self)
        self._end_balance()
        self._new_stretch(t_ns)
        self._forget()
        self._instant = 0
        self.order.phase = PAUSED

    def _rest(self, t_ns: int, pause: Callable[[], None]) -> None:
        """Samples of a scene at rest up to t_ns: nothing is integrated, all are one row."""
        self._still = False
        self._note_peaks()
        if (first := self._samples * self._sample_ns) <= t_ns:
            self._keep(first, np.array(self.method.row_layout.pack(self.row())))
            self._rested = first, t_ns + 1, self.rows.pop()[1]
            self._samples = t_ns // self._sample_ns + 1
            try:
                self._check_rest(range(first, t_ns + 1, self._sample_ns), self._rested[2])
            finally:
                self._show_rest(pause)
        self._set(t=self._local(t_ns))

    def _check_rest(self, times: range, row: np.ndarray) -> None:
        """Raises KernelError for compression that lasts; the samples of the rest end before that."""
        for t_ns in times[1:] if self.program.axial else ():
            try:
                check_compression(self, row, t_ns)
            except KernelError:
                self._rested = times[0], t_ns, row
                raise
            if t_ns - times[0] > LASTING * 1e9:
                return

    def _show_rest(self, pause: Callable[[], None]) -> None:
        while self.unroll():
            pause()

    def unroll(self, start_ns: int = 0) -> bool:
        """Turn the next of a rest's samples from a time on into rows; whether that is not all of them."""
        if self._rested is None:
            return False
        first, end, row = self._rested
        times = range(max(first, start_ns), end, self._sample_ns)
        self.rows += [(t, row) for t in times[:ROWS]]
        self._rested = (times[ROWS], end, row) if len(times) > ROWS else None
        return self._rested is not None

    def settle(self) -> None:
        """Derivative and guards after a jump; a guard that is below zero now is an event at once."""
        self.order.check_standing("settle", self.epoch)
        self.references.write(self.epoch)
        self._set(
            t_stop=next(iter(self.references.breaks(self.epoch)), NEVER),
            t_rest=self.references.rest(self.epoch),
        )
        speeds = self.state[self.program.nq : self.program.nq + self.program.nv]
        self._set(scale=float(scale_of(self["scale"], speeds)))
        self._call("refresh")
        if self["scale"] < 1.0:
            self._set(**rounded(self._accelerations, self.state[: self.program.nq].copy(), self["tol"]))
        self._note_peaks()  # of a rope that a jump has tightened, and where no step lies between two samples
        row = self._raw().copy()
        self._angles[:] = row[self.method.row_layout.at["turned"]]  # without the error of their integrals
        self._balance.begin(*self._energies(row))
        if self.fixed:
            self._check_step(self.epoch, row)
        self._keep(self.epoch, row)
        self.X[self._at["peak"]] = 0.0
        note_shared_loads(self, self._sets_of_ropes)
        fallen = np.flatnonzero(self.X[self._at["G"]] < 0.0)
        self._fallen = [int(i) for i in fallen]
        self._event_ns = self.epoch if len(fallen) else FOREVER_NS
        self.order.phase = SETTLED

    def snapshot(self) -> dict[str, Any]:
        """All that the future depends on (see `snapshots`); raises KernelError for a method of SciPy."""
        self.order.check_begun()
        return kept(self)

    def restore(self, snapshot: dict[str, Any]) -> None:
        """Go on from the snapshot of a simulation of the same system and options, bit for bit; start this one first."""
        self.order.check_begun()
        go_on(self, snapshot)
