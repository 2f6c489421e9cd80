"""A fixed step that is unstable or blind to a mode: looked for at events, and when a rope has become much shorter."""

from __future__ import annotations

import numpy as np
from heavylift.kernel.description.notes import Note
from heavylift.kernel.methods.stability import check_step, unresolved
from heavylift.kernel.simulation.native.native_state import NativeState

from .fastest_mode import told_fastest
from .resolution_check import check_followed

__all__ = ["StepCheck"]

SHORTER = 0.8  # of its length: a rope that much shorter is a quarter stiffer


class StepCheck:
    """`step` [s]; `lengths` of ropes at the last look [m]; `missed`: whether a mode that is missed has been noted."""

    def __init__(self, native: NativeState, step: float) -> None:
        self._native, self._step = native, step
        self.lengths = np.zeros(len(native.program.system.ropes))
        self.missed = False

    def see(self, t_ns: int, row: np.ndarray) -> None:
        """Of a row of the native table on the way."""
        if (row[self._native.method.row_layout.at["length"]] < SHORTER * self.lengths).any():
            self.check(t_ns, row)

    def check(self, t_ns: int, row: np.ndarray) -> None:
        """Raises KernelError if the step is unstable for the scene of a row; a note if it misses a mode."""
        native, at = self._native, self._native.method.row_layout.at
        nq, nv, now = native.program.nq, native.program.nv, native.X.copy()
        self.lengths = row[at["length"]].copy()
        native.state[:nq], native.state[nq : nq + nv] = row[at["q"]], row[at["v"]]
        native.set(t=native.local(t_ns))
        try:
            self._judge(t_ns)
        finally:
            native.X[:] = now

    def _judge(self, t_ns: int) -> None:
        t, method, J = t_ns * 1e-9, self._native.method.method, self._native.jacobian()

        def told() -> str:
            return told_fastest(self._native, J) or "the scene is unstable"

        check_step(method, J, self._step, self._native.program.nq, t, told)
        check_followed(self._native, J, self._step, t, told)
        missed, swings = unresolved(method, J, self._step)
        if missed and not self.missed:
            self.missed = True
            seen = (
                f"step {self._step:g} s at {t:.3f} s: method '{method.name}' is out of step by a tenth of a swing "
                f"{f'after {swings:.0f} swings' if swings > 1.0 else 'at once'} with oscillations from {missed:.3g} Hz "
                f"upwards, {told()}: do not trust what depends on those; choose a shorter step to see them"
            )
            self._native.notes.append(Note(t_ns, seen))
