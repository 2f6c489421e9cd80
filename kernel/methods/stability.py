"""Guards of fixed steps: a step that the fastest mode does not allow, and energy out of nothing, are refused.

Before the run and after every event the scene is linearised (central differences) and the spectral radius of what one
step does to it must not exceed what the motion itself grows by.  Between events the balance kinetic + potential +
stored - work + heat must hold: an unstable step makes energy at every step.
That implicit methods take energy out of modes too fast for the step is their purpose.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..errors import KernelError
from .method import Method

__all__ = ["Balance", "check_step", "jacobian"]

DIFFERENCE = 1e-6  # of a central difference, relative to 1 + |y|
MARGIN = 1e-3  # growth in one step beyond that of the motion, which differences can feign
HALVINGS = 30  # of the bracket around the longest stable step
MADE = 0.5  # of the energy turned over: more of it out of nothing is no motion any more
ROUND_OFF = 1e-9  # of all energies


def jacobian(rate: Callable[[np.ndarray], np.ndarray], y: np.ndarray, n: int) -> np.ndarray:
    """(n, n) derivative of the first n components of `rate` at y (ny,)."""
    J = np.zeros((n, n))
    for j in range(n):
        d = DIFFERENCE * (1.0 + abs(y[j]))
        there, back = y.copy(), y.copy()
        there[j], back[j] = y[j] + d, y[j] - d
        J[:, j] = (rate(there)[:n] - rate(back)[:n]) / (2.0 * d)
    return J


def check_step(method: Method, J: np.ndarray, step: float, nq: int, t: float) -> None:
    """Raises KernelError if a fixed step [s] makes the scene, linearised at time t [s], unstable."""
    if not np.isfinite(J).all():
        return  # the run itself says what is not finite
    modes = np.linalg.eigvals(J)
    growth = max(0.0, float(modes.real.max()))

    def stable(h: float) -> bool:
        G = method.amplification(J, h, nq)
        if not np.isfinite(G).all():
            return False
        return bool(np.abs(np.linalg.eigvals(G)).max() <= np.exp(growth * h) + MARGIN)

    if stable(step):
        return
    low, high = 0.0, step
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    fastest = float(np.abs(modes).max()) / (2.0 * np.pi)
    raise KernelError(
        f"step {step:g} s at {t:.3f} s: too long for method '{method.name}', since the scene has a mode of "
        f"{fastest:.3g} Hz; choose at most {0.9 * low:.2g} s, or method radau5"
    )


class Balance:
    """The energies of a stretch of fixed steps between two events, from sample to sample."""

    def __init__(self) -> None:
        self._start: tuple[float, np.ndarray] | None = None  # kinetic energy; the others
        self._turned = 0.0

    def restart(self) -> None:
        """After an event or a command."""
        self._start, self._turned = None, 0.0

    def check(
        self, t: float, step: float, kinetic: float, potential: float, stored: float, accounts: np.ndarray
    ) -> None:
        """Raises KernelError if more energy has come out of nothing since the start than was turned over [J].

        accounts: heats, and works with the opposite sign.
        """
        parts = np.array([potential, stored, *accounts])
        if self._start is None:
            self._start = kinetic, parts
        before, held = self._start
        made = kinetic - before + float((parts - held).sum())
        self._turned = max(self._turned, kinetic + float(np.abs(parts - held).sum()))
        if not made <= MADE * self._turned + ROUND_OFF * (kinetic + float(np.abs(parts).sum())):
            raise KernelError(
                f"step {step:g} s at {t:.3f} s: {made:.3g} J have come out of nothing since the last event, more than "
                f"half of what was turned over; choose a shorter step, or method radau5"
            )
