"""The energy balance of a run, read from its sample rows: what is made or lost is refused or noted."""

from __future__ import annotations

from math import sqrt

import numpy as np
from heavylift.kernel.description.notes import Note
from heavylift.kernel.methods.stability import Balance
from heavylift.kernel.simulation.native.native_state import NativeState

__all__ = ["EnergyCheck"]


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

    def energies(self, row: np.ndarray) -> tuple[float, np.ndarray]:
        """Of a row of the native table: kinetic energy; potential, stored, heats, works with the opposite sign [J]."""
        return float(row[self._kinetic]), row[self._parts] * self._signs

    def begin(self, row: np.ndarray) -> None:
        """After an event or a command."""
        self.balance.begin(*self.energies(row))

    def see(self, row: np.ndarray) -> None:
        """On the way."""
        self.balance.see(*self.energies(row))

    def check(self, row: np.ndarray, t: float) -> None:
        """Raises KernelError if energy has come out of nothing, or gone there, since the last event; t: of the run."""
        kinetic, parts = self.energies(row)
        gravity, mass = abs(self._native.program.system.gravity), self._mass
        size = kinetic + float(np.abs(parts).sum()) + sqrt(2.0 * kinetic * mass) + gravity * mass
        before = self.balance.lost
        steps = float(row[self._at["steps"]])
        held = self._held(row, row[self._at["peak"]])
        self.balance.check(f"{self._what} at {t:.3f} s", kinetic, parts, steps * size, held)
        if self.balance.lost > 0.0 and not before:
            told = (
                f"{self._what} at {t:.3f} s: {self.balance.lost:.3g} J, more than half of what was turned over, "
                "are gone with motions too fast for the steps; choose shorter ones to see those"
            )
            self._native.notes.append(Note(round(t * 1e9), told))

    def end(self, t: float) -> None:
        """Before an event or a command."""
        native = self._native
        row = native.raw()
        self.balance.end(*self.energies(row))
        highest = native.part("top" if "top" in native.at else "peak")
        if part := self.balance.strayed(self._held(row, highest)):
            told = (
                f"{self._what} at {t:.3f} s: {100.0 * part:.0f} % of the energy turned over has "
                "come or gone with the errors that its tolerance allows; do not trust tensions, or choose a smaller one"
            )
            native.notes.append(Note(round(t * 1e9), told))

    def _held(self, row: np.ndarray, highest: np.ndarray) -> float:
        """Most energy that an elastic rope holds at its highest tension [J]."""
        T = highest[: len(self._softness)]
        return float((T * T * row[self._at["length"]] * self._softness).max(initial=0.0))
