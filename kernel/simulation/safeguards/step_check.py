"""A fixed step that is unstable or blind to a mode: looked for at events, and when a rope has become much shorter.

A step that bends most of what moves out of shape is refused, for what it would show is not the scene's motion.  The
scene is linearised; each oscillation has the amplitude that the present state gives it about the place where it would
rest.  What of the energy is in oscillations that the step does not follow, weighed with how wrong each is after
RADIANS, or after it has died away if that is sooner, but at least after a step, must not exceed WRONG.  Below that, a
note says what is missed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from heavylift.kernel.description.findings import Note
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.method import Method
from heavylift.kernel.methods.stability import bent, check_step, missed, unresolved
from heavylift.kernel.model.kinetic_energy import KineticShares
from heavylift.kernel.simulation.native.native_state import NativeState

from .fastest_mode import told_fastest

RADIANS = 30.0  # five swings
WRONG = 0.25
CALM = 1e-3  # [m/s] what moves no faster is at rest
HALVINGS = 30  # of the bracket around the longest step that would do
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
        _check_followed(self._native, J, self._step, t, told)
        blind, swings = unresolved(method, J, self._step)
        if blind and not self.missed:
            self.missed = True
            seen = (
                f"step {self._step:g} s at {t:.3f} s: method '{method.name}' is out of step by a tenth of a swing "
                f"{f'after {swings:.0f} swings' if swings > 1.0 else 'at once'} with oscillations from {blind:.3g} Hz "
                f"upwards, {told()}: do not trust what depends on those; choose a shorter step to see them"
            )
            self._native.notes.append(Note(t_ns, seen))


def _check_followed(native: NativeState, J: np.ndarray, step: float, t: float, told: Callable[[], str]) -> None:
    """Raises KernelError if a fixed step [s] leaves too much of what moves at time t [s]; `told`: the fastest mode."""
    method = native.method.method
    if not np.isfinite(J).all() or not any(bent(method, s, step) for s in np.linalg.eigvals(J)):
        return
    modes = _energies(native, J)
    if not _wrong(method, modes, step) > WRONG:
        return
    low, high = 0.0, step
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _wrong(method, modes, middle) > WRONG else (middle, high)
    share = sum(e for s, e in modes if bent(method, s, step))
    raise KernelError(
        f"step {step:g} s at {t:.3f} s: method '{method.name}' does not follow {100.0 * share:.0f} % of the energy of "
        f"what moves, {told()}; choose at most {0.9 * low:.2g} s, or leave the step out"
    )


def _energies(native: NativeState, J: np.ndarray) -> list[tuple[complex, float]]:
    """Eigenvalues of the oscillations and their parts of the energy."""
    p, y = native.program, native.state.copy()
    n, speeds = p.nq + p.nv, slice(p.nq, p.nq + p.nv)
    rate = native.rate(native.state.copy())[0][:n]
    s, V = np.linalg.eig(J)
    amplitudes = np.linalg.lstsq(V, rate.astype(complex), rcond=None)[0]
    kinetic = KineticShares(p, native.P, y[: p.nq])
    rest, found = y[speeds].astype(complex), list[tuple[complex, float]]()
    for k in np.flatnonzero(s.imag > 0.0):
        shape = 2.0 * amplitudes[k] / s[k] * V[speeds, k]
        found.append((complex(s[k]), kinetic.energy(shape)))
        rest -= shape.real
    total = sum(e for _, e in found) + kinetic.energy(rest) + sum(b.mass for b in p.system.bodies) * CALM**2
    return [(x, e / total) for x, e in found]


def _wrong(method: Method, modes: list[tuple[complex, float]], step: float) -> float:
    """Part of the energy that is in the wrong place after a while."""

    def error(s: complex) -> float:
        lasts = max(min(RADIANS, abs(s) / max(-s.real, 1e-300)), abs(s) * step)
        return min(1.0, missed(method, s, step) * lasts)

    return sum(e * error(s) for s, e in modes if bent(method, s, step))
