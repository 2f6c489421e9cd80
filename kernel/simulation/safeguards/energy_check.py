"""The energy balance of a run, read from its sample rows: what is made or lost is refused or noted."""

from __future__ import annotations

import numpy as np
from heavylift.kernel.description.findings import Note
from heavylift.kernel.methods.stability import Balance
from heavylift.kernel.simulation.native.native_state import NativeState


class EnergyCheck:
    """Compares the energies of a row with those at the last event; `step`: a fixed one [s], or None."""

    def __init__(self, native: NativeState, tolerance: float, step: float | None) -> None:
        self._native = native
        name = native.method.method.name
        self._what = f"method '{name}'" if step is None else f"step {step:g} s"
        self.balance = Balance(tolerance if step is None else 0.0, native.method.method.implicit)
        p, self._at = native.program, native.method.row_layout.at
        columns = np.arange(native.method.columns)
        self._kinetic = int(columns[self._at["kinetic"]])
        self._parts = np.concatenate([np.ravel(columns[self._at[k]]) for k in ("potential", "stored", "accounts")])
        works = [what == "work" for what, _ in p.accounts]
        self._signs = np.where([False] * (1 + len(p.stores)) + works, -1.0, 1.0)
        self._mass = sum(b.mass for b in p.system.bodies)
        self._softness = np.array([0.5 / r.EA for r in p.system.ropes])  # of a metre: energy of a tension squared

    def energies(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of (n, columns) of the native table: kinetic; potential, stored, heats, works with the opposite sign [J]."""
        return rows[:, self._kinetic], rows.take(self._parts, axis=1) * self._signs

    def begin(self, row: np.ndarray) -> None:
        """After an event or a command."""
        self.balance.begin(float(row[self._kinetic]), row.take(self._parts) * self._signs)

    def see(self, rows: np.ndarray) -> None:
        """On the way, (n, columns)."""
        self.balance.see(*self.energies(rows))

    def check(self, row: np.ndarray, t: float) -> None:
        """Raises KernelError if energy has come out of nothing, or gone there, since the last event; t: of the run."""
        before = self.balance.lost
        self.balance.check(f"{self._what} at {t:.3f} s", *self._reading(row[None]))
        if self.balance.lost > 0.0 and not before:
            told = (
                f"{self._what} at {t:.3f} s: {self.balance.lost:.3g} J, more than half of what was turned over, "
                "are gone with motions too fast for the steps; choose shorter ones to see those"
            )
            self._native.notes.append(Note(round(t * 1e9), told))

    def fine(self, rows: np.ndarray) -> bool:
        """Whether there is nothing to say of (n, columns); they count as seen then."""
        if self.balance.strict:
            self.see(rows)
            return True
        return self.balance.fine(*self._reading(rows))

    def _reading(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Energies as in `energies`; what errors of steps may make up, and the most that a rope has held (n,) [J]."""
        kinetic, parts = self.energies(rows)
        gravity, mass = abs(self._native.program.system.gravity), self._mass
        size = kinetic + np.abs(parts).sum(axis=1) + np.sqrt(2.0 * kinetic * mass) + gravity * mass
        return kinetic, parts, rows[:, self._at["steps"]] * size, self._held(rows, rows[:, self._at["peak"]])

    def end(self, t: float) -> None:
        """Before an event or a command."""
        native = self._native
        row = native.raw()
        self.balance.end(float(row[self._kinetic]), row.take(self._parts) * self._signs)
        highest = native.part("top" if "top" in native.at else "peak")
        if part := self.balance.strayed(float(self._held(row[None], highest[None])[0])):
            told = (
                f"{self._what} at {t:.3f} s: {100.0 * part:.0f} % of the energy turned over has "
                "come or gone with the errors that its tolerance allows; do not trust tensions, or choose a smaller one"
            )
            native.notes.append(Note(round(t * 1e9), told))

    def _held(self, rows: np.ndarray, highest: np.ndarray) -> np.ndarray:
        """(n,) most energy that an elastic rope holds at its highest tension (n, ropes) [J]."""
        T = highest[:, : len(self._softness)]
        held: np.ndarray = (T * T * rows[:, self._at["length"]] * self._softness).max(axis=1, initial=0.0)
        return held
