"""What is done to the native blocks between events: steps, commits, samples, checks of step and energy, stretches.

Local time is float seconds since the last event or command (the epoch); a new *stretch* begins at each of them, so
precision does not fade in long runs.  Samples lie on a grid of integer nanoseconds and are numbered.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from heavylift.kernel.constraints.rigid_ropes import RigidAt
from heavylift.kernel.description.notes import Note
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.peers import PeerCode
from heavylift.kernel.methods.stability import check_step, unresolved
from heavylift.kernel.model.switching import StateEvent
from heavylift.kernel.simulation.assembly.assembly import assemble, locked, lost
from heavylift.kernel.simulation.impacts.rope_impacts import resolve
from heavylift.kernel.simulation.native.native_state import FOREVER_NS, NEVER, ROWS, Blocks
from heavylift.kernel.simulation.native.peaks import climb
from heavylift.kernel.simulation.safeguards.deflection_check import check_compression
from heavylift.kernel.simulation.safeguards.failures import (
    check_lengths,
    check_sliders,
    given_up,
    too_small,
    undefined,
    unsolved,
)
from heavylift.kernel.simulation.safeguards.fastest_mode import fastest
from heavylift.kernel.simulation.safeguards.resolution_check import check_followed

__all__ = ["FOREVER_NS", "NEVER", "Stepper"]

APART = 1e-6  # [m, rad, m/s, rad/s] by which rows gape that drives tear
HALVINGS = 20  # of a forced step that has no solution
SHORTER = 0.8  # of its length: a rope that much shorter is a quarter stiffer


class Stepper(Blocks):
    """Steps that are tentative until they are committed, and the samples of those that are."""

    def _assemble(self) -> None:
        """Close the loops of the initial pose; raises KernelError if they cannot be closed or leave no freedom."""
        if len(self.program.constraints):
            y = self.state.copy()
            self.X[self._at["y"]], told = assemble(self.program, y, self.P, self._close)
            self.notes += [Note(0, sentence) for sentence in told]
            self._pivots = self.X[self._at["pivot"]].copy()
            self.X[self._at["gap"]] = 0.0

    def _resolve(self) -> list[StateEvent]:
        """Impulses of rigid ropes and loops, and the ropes that are taut then; what has changed."""
        ropes, at = self.program.system.rigid_ropes, self.program.parameters.at
        after = resolve(self.program, self["t"], self._among(), self.state.copy(), self.P)
        slots = [self.P[at["rigid", r.name]] for r in ropes]
        before = [p[RigidAt.TAUT] > 0.0 for p in slots]
        for p, may in zip(slots, after.may, strict=True):
            p[RigidAt.TAUT] = float(may)
        nq, first = self.program.nq, self.program.nq + self.program.nv
        y = self.state.copy()
        y[:nq] = self._close(y)[0][:nq]  # the nanometre by which a rope was too long
        y[nq:first] = after.v
        for p, r, taut, heat, work in zip(slots, ropes, after.taut, after.heat, after.work, strict=True):
            p[RigidAt.TAUT] = float(taut)
            y[first + self.program.accounts.index(("heat", r.name))] += heat
            if r.winch:
                y[first + self.program.accounts.index(("work", r.name))] += work
        self.X[self._at["y"]], self.X[self._at["gap"]] = y, 0.0
        changes = zip(ropes, before, after.taut, after.impulse, strict=True)
        return [StateEvent(r.name, "taut" if b else "slack", x) for r, a, b, x in changes if a != b]

    def _check_rows(self) -> None:
        """Raises KernelError if a constraint has been lost in the steps that count."""
        if error := lost(self.program, self.X[self._at["gap"]], self.epoch * 1e-9 + self["t"], self._moving()):
            raise error

    def _commit(self) -> None:
        hill = "top" in self._at and self["tentative"] > 0.0 and self["peaking"] > 0.0
        self._call("commit")
        if hill:
            climb(self)
        if self.method.method.completes and self["due"] > 0.0:
            self._call("complete")
        while self["due"] > 0.0:
            self._call("sample")
            if self["row"] >= ROWS:
                self._drain()
        self._drain()

    def _drain(self) -> None:
        for i in range(int(self["row"])):
            row = self._table[i].copy()
            self._balance.see(*self._energies(row))
            self._keep(self._samples * self._sample_ns, row)
            self._samples += 1
        self._set(row=0.0)
        if "passing" in self._at and self["passing"] > 0.0:
            t_ns = self.epoch + round((self["passing"] - 1.0) * 1e9)
            self._set(passing=-1.0)
            told = (
                f"step {self._step:g} s at {t_ns * 1e-9:.3f} s: what moves so fast can pass through what it meets "
                f"within a step of method '{self.method.method.name}', unseen; choose a shorter one, or leave it out"
            )
            self.notes.append(Note(t_ns, told))

    def _keep(self, t_ns: int, row: np.ndarray) -> None:
        """Take a row of the native table as a sample; raises KernelError if a rope is used up."""
        at = self.method.row_layout.at
        check_lengths(self.program, t_ns * 1e-9, row[at["length"]])
        check_sliders(self.program, t_ns * 1e-9, row[at["q"]])
        if self.program.axial:
            check_compression(self, row, t_ns)
        row[at["peak_time"]] += self.epoch * 1e-9
        if not self._balance.strict:
            self._check_energy(row, t_ns * 1e-9)
        if self.fixed and (row[at["length"]] < SHORTER * self._checked).any():
            self._check_step(t_ns, row)
        self.rows.append((t_ns, row))

    def _energies(self, row: np.ndarray) -> tuple[float, np.ndarray]:
        """Of a row of the native table: kinetic energy; potential, stored, heats, works with the opposite sign [J]."""
        parts = row[self._parts]
        parts *= self._signs
        return float(row[self._kinetic]), parts

    def _check_energy(self, row: np.ndarray, t: float) -> None:
        """Raises KernelError if energy has come out of nothing, or gone there, since the last event; t: of the run."""
        kinetic, parts = self._energies(row)
        mass = self._mass
        size = (
            kinetic + float(np.abs(parts).sum()) + sqrt(2.0 * kinetic * mass) + abs(self.program.system.gravity) * mass
        )
        what = f"step {self._step:g} s" if self.fixed else f"method '{self.method.method.name}'"
        before = self._balance.lost
        steps = float(row[self.method.row_layout.at["steps"]])
        held = self._held(row, row[self.method.row_layout.at["peak"]])
        self._balance.check(f"{what} at {t:.3f} s", kinetic, parts, steps * size, held)
        if self._balance.lost > 0.0 and not before:
            told = (
                f"{what} at {t:.3f} s: {self._balance.lost:.3g} J, more than half of what was turned over, "
                "are gone with motions too fast for the steps; choose shorter ones to see those"
            )
            self.notes.append(Note(round(t * 1e9), told))

    def _held(self, row: np.ndarray, highest: np.ndarray) -> float:
        """Most energy that an elastic rope holds at its highest tension [J]; row: of the native table."""
        T = highest[: len(self._softness)]
        return float((T * T * row[self.method.row_layout.at["length"]] * self._softness).max(initial=0.0))

    def _end_balance(self) -> None:
        """Before an event or a command."""
        row, t = self._raw(), self.epoch * 1e-9 + self["t"]
        self._balance.end(*self._energies(row))
        highest = self.X[self._at["top" if "top" in self._at else "peak"]]
        if part := self._balance.strayed(self._held(row, highest)):
            told = (
                f"method '{self.method.method.name}' at {t:.3f} s: {100.0 * part:.0f} % of the energy turned over has "
                "come or gone with the errors that its tolerance allows; do not trust tensions, or choose a smaller one"
            )
            self.notes.append(Note(round(t * 1e9), told))

    def _check_step(self, t_ns: int, row: np.ndarray) -> None:
        """Raises KernelError if the fixed step is unstable for the scene of a row; a note if it misses a mode."""
        at, nq, nv, now = self.method.row_layout.at, self.program.nq, self.program.nv, self.X.copy()
        self._checked = row[at["length"]].copy()
        self.state[:nq], self.state[nq : nq + nv] = row[at["q"]], row[at["v"]]
        self._set(t=self._local(t_ns))
        try:
            self._judge_step(t_ns)
        finally:
            self.X[:] = now

    def _judge_step(self, t_ns: int) -> None:
        t, method = t_ns * 1e-9, self.method.method
        J = self._jacobian()

        def told() -> str:
            mode = fastest(self, J)
            return mode.told if mode else "the scene is unstable"

        check_step(method, J, self._step, self.program.nq, t, told)
        check_followed(self, J, self._step, t, told)
        missed, swings = unresolved(method, J, self._step)
        if missed and not self._missed:
            self._missed = True
            seen = (
                f"step {self._step:g} s at {t:.3f} s: method '{method.name}' is out of step by a tenth of a swing "
                f"{f'after {swings:.0f} swings' if swings > 1.0 else 'at once'} with oscillations from {missed:.3g} Hz "
                f"upwards, {told()}: do not trust what depends on those; choose a shorter step to see them"
            )
            self.notes.append(Note(t_ns, seen))

    def _note_peaks(self) -> None:
        """The present tensions count among the peaks."""
        T, peak, when = (self.X[self._at[name]] for name in ("T", "peak", "peak_time"))
        higher = peak < T
        peak[higher], when[higher] = T[higher], self["t"]
        if "top" in self._at:
            top = self.X[self._at["top"]]
            np.maximum(top, T, out=top)

    def _led(self, t: float) -> None:
        """From the committed state to local time t in forced steps: one, or halves where the method solves no more."""
        ends = [t]
        while ends:
            if self._solved(ends[-1]):
                ends.pop()
                if ends:
                    self._commit()
            elif len(ends) > HALVINGS:
                raise unsolved(self.method.method.name, self.epoch * 1e-9 + t)
            else:
                ends.append(0.5 * (self["t"] + ends[-1]))

    def _forced(self, t: float) -> None:
        """One step from the committed state to local time t, accepted as it is; step control is not touched."""
        if not self._solved(t):
            raise unsolved(self.method.method.name, self.epoch * 1e-9 + t)

    def _solved(self, t: float) -> bool:
        """Whether there is such a step; if not, all is as it was."""
        h, error, t_stop = self["h"], self["error"], self["t_stop"]
        if t <= self["t"]:
            return True
        for _ in range(2):  # the second time with a new Jacobian, if there is one
            self._set(h=NEVER, forced=1.0, t_stop=t)
            self._call("step")
            self._set(h=h, forced=0.0, error=error, t_stop=t_stop, locate=0.0)
            if "sound" not in self._at or self["sound"] > 0.0:
                if not np.isfinite(self.state).all() or self._given_up:
                    raise self._failure()
                return True
            self._to_start()
        return False

    def _to_start(self) -> None:
        """Back to the start of the tentative step."""
        for name, old in (("t", "t0"), ("y", "d0"), ("f", "f0")):
            self.X[self._at[name]] = self.X[self._at[old]]
        self._set(tentative=0.0)

    def _new_stretch(self, t_ns: int) -> None:
        """Local time starts again at t_ns."""
        shift = (t_ns - self.epoch) * 1e-9
        self.X[self._at["peak_time"]] -= shift
        self.epoch = t_ns
        base = (self._samples * self._sample_ns - t_ns) * 1e-9
        self._set(t=0.0, t_base=base, t_out=base, dt_out=self._sample_ns * 1e-9, count=0.0, tentative=0.0)
        self.references.write(t_ns)

    @property
    def _given_up(self) -> str:
        """Why SciPy has found no next step, if it takes them."""
        return self._code.failed if isinstance(self._code, PeerCode) else ""

    def _moving(self) -> list[str]:
        """Names of the prescribed drives that move now."""
        prescribed = [d.name for d in self.program.system.drives if d.kind == "prescribed"]
        return [name for name in prescribed if self.references.moves(name, self.epoch + round(self["t"] * 1e9))]

    def _failure(self) -> KernelError:
        """Why there is no next step."""
        p, t = self.program, self.epoch * 1e-9 + self["t"]
        if self.fixed:
            if "sound" in self._at and not self["sound"] > 0.0:
                return unsolved(self.method.method.name, t)
            self._set(forced=1.0)  # what the step would have led to
            self._call("step")
        nq, end = p.nq, p.nq + p.nv
        if why := self._given_up:
            mode = self._fastest()
            return given_up(self.method.method.name, t, why, mode.told if mode else "")
        if error := undefined(p, t, self.row(), self.state[nq:end]):
            return error
        if len(p.constraints):
            _, gap, slip, pivot = self._close(self.state.copy())
            apart = float(np.abs(np.append(gap, slip)).max()) > APART
            if error := locked(p, self._pivots, pivot, t, self._moving() if apart else []):
                return error
        mode = self._fastest()
        return too_small(p, t, self.X[self._at["f"]][nq:end], mode.told if mode else "", self.method.method.name)
