"""A fixed step that bends most of what moves out of shape: refused, for what it would show is not the scene's motion.

The scene is linearised; each oscillation has the amplitude that the present state gives it about the place where it
would rest.  What of the energy is in oscillations that the step does not follow, weighed with how wrong each is after
RADIANS, or after it has died away if that is sooner, but at least after a step, must not exceed WRONG.  Below that, a
note says what is missed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.method import Method
from heavylift.kernel.methods.stability import bent, missed
from heavylift.kernel.model.kinetic_energy import KineticShares
from heavylift.kernel.simulation.native.native_state import NativeState

__all__ = ["check_followed"]

RADIANS = 30.0  # five swings
WRONG = 0.25
CALM = 1e-3  # [m/s] what moves no faster is at rest
HALVINGS = 30  # of the bracket around the longest step that would do


def check_followed(native: NativeState, J: np.ndarray, step: float, t: float, told: Callable[[], str]) -> None:
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
