"""Checks of steps: refusal of a fixed step that is unstable for the fastest mode, and of steps that create energy.

Before the run, after every event and where a rope has become much shorter, the scene is linearised (central
differences), and the spectral radius of a fixed step must not exceed the growth of the motion itself. Between events
the balance kinetic + potential + stored - work + heat must hold for all methods: an unstable step creates energy.
Implicit methods may take energy out of modes too fast for the step, which is their purpose; this is reported.
"""

from collections.abc import Callable
from math import isfinite
from typing import Any

import numpy as np
from heavylift.kernel.errors import KernelError

from .method import Method

DIFFERENCE = 1e-6  # of a central difference, relative to 1 + |y|
MARGIN = 1e-3  # growth in one step beyond that of the motion, which differences can feign
HALVINGS = 30  # of the bracket around the longest stable step
MADE = 0.5  # of the energy turned over: more of it out of nothing is no motion any more
STRAYED = 0.05  # of it, made or lost under error control; whole lifts at the loosest tolerance stay below 1e-3
ROUND_OFF = 1e-9  # of all energies
FOLLOWED = 3e-4  # error per radian of an oscillation: after 500 of them it is not that oscillation any more
LEAST = 1e-6  # [rad/s] of an oscillation


def jacobian(rate: Callable[[np.ndarray], np.ndarray], y: np.ndarray, n: int) -> np.ndarray:
    """Return the Jacobian (n, n) of the first n components of `rate` at y (ny,), by central differences."""
    J = np.zeros((n, n))
    for j in range(n):
        # relative to 1 + |y|, as the tolerance is: coordinates near zero are metres or radians
        d = DIFFERENCE * (1.0 + abs(y[j]))
        there, back = y.copy(), y.copy()
        there[j], back[j] = y[j] + d, y[j] - d
        with np.errstate(invalid="ignore"):  # where forces are not finite
            J[:, j] = (rate(there)[:n] - rate(back)[:n]) / (2.0 * d)
    return J


def check_step(method: Method, J: np.ndarray, step: float, nq: int, t: float, message: Callable[[], str]) -> None:
    """Raise KernelError if a fixed step [s] is unstable for the scene linearised at t [s]; `message`: fastest mode."""
    if not np.isfinite(J).all():
        return  # the run itself says what is not finite
    modes = np.linalg.eigvals(J)
    # an unstable motion of the scene itself, such as a falling rod, may grow as fast as it does
    growth = max(0.0, float(modes.real.max()))

    def stable(h: float) -> bool:
        G = method.amplification(J, h, nq)
        if not np.isfinite(G).all():
            return False
        # MARGIN, since differences can turn an undamped mode into a slightly growing one
        return bool(np.abs(np.linalg.eigvals(G)).max() <= np.exp(growth * h) + MARGIN)

    if stable(step):
        return
    # bisection assumes one stable interval from zero, which holds for all methods offered here
    low, high = 0.0, step
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    raise KernelError(
        f"step {step:g} s at {t:.3f} s is too long for method '{method.name}', since {message()}; "
        # 0.9 leaves room for stiffness that grows in the course of the run
        f"choose at most {0.9 * low:.2g} s, or method radau5"
    )


def unresolved(method: Method, J: np.ndarray, step: float) -> tuple[float, float]:
    """Return the lowest frequency [Hz] that a stable fixed step distorts, and the number of periods until this shows.

    After so many periods, the most distorted one is a tenth of a period out of phase or half damped.
    """
    if not np.isfinite(J).all():
        return 0.0, np.inf
    bends = [(abs(s), missed(method, s, step)) for s in np.linalg.eigvals(J) if bent(method, s, step)]
    return min((w for w, _ in bends), default=0.0) / (2.0 * np.pi), 0.1 / max((e for _, e in bends), default=0.0001)


def bent(method: Method, s: complex, step: float) -> bool:
    """Return whether a fixed step distorts the oscillation with eigenvalue s [1/s]."""
    return s.imag > LEAST and missed(method, s, step) > FOLLOWED


def missed(method: Method, s: complex, step: float) -> float:
    """Return the relative error that a step causes in an oscillation with eigenvalue s [1/s], per radian of phase."""
    # one oscillator y'' = 2 Re(s) y' - |s|^2 y with this eigenvalue stands for the mode
    J = np.array([[0.0, 1.0], [-(abs(s) ** 2), 2.0 * s.real]])
    got = np.linalg.eigvals(method.amplification(J, step, 1))
    want = np.exp(s * step)
    # per radian, so that the limit is a phase error accumulated over a fixed angle and not over a time
    return float(np.abs(got - want).min()) / (abs(s) * step)


class Balance:
    """Energy balance of a run: kinetic + potential + stored - work + heat must stay constant.

    The works and heats of the laws are integrated with the state, so that energy created or lost in any step stays in
    the sum and is seen at every reading. Energy changed by switches and commands is added to the balance. `controlled`:
    tolerance of the steps, 0 if they are fixed; `implicit`: steps may lose energy of fast motions.
    """

    def __init__(self, controlled: float, implicit: bool) -> None:
        self._tolerance, self._implicit = controlled, implicit
        self._start: tuple[float, np.ndarray] = 0.0, np.zeros(1)  # kinetic energy; the others
        self._carried = self._turned = 0.0  # [J] made before the last event; most that was turned over at once
        self.loose = 0.0  # part of what was turned over that a loose tolerance has let come or go, where ropes pull
        self.lost = 0.0  # [J] by an implicit or fixed method, more than half of what was turned over

    @property
    def strict(self) -> bool:
        """Whether steps may neither create nor lose energy."""
        return self._tolerance > 0.0 and not self._implicit

    def begin(self, kinetic: float, parts: np.ndarray) -> None:
        """Restart the energy balance after an event or command, from the kinetic energy and the other `parts` [J]."""
        self._start = kinetic, parts

    def end(self, kinetic: float, parts: np.ndarray) -> None:
        """Close the energy balance before an event or command, at the kinetic energy and the other `parts` [J]."""
        before, start = self._start
        changes = parts - start
        # energy that vanished before a switch stays in the sum, or many small losses would pass
        self._carried += kinetic - before + float(changes.sum())
        self._turned = max(self._turned, kinetic + float(np.abs(changes).sum()))

    def strayed(self, held: float) -> float:
        """Return the relative energy error when it first becomes too large; 0 before and afterwards.

        `held`: largest energy of a rope so far [J].
        """
        self._turned = max(self._turned, held)
        if self.loose or not self._tolerance or abs(self._carried) <= STRAYED * self._turned or not held:
            return 0.0
        self.loose = abs(self._carried) / self._turned
        return self.loose

    def see(self, kinetic: np.ndarray, parts: np.ndarray) -> None:
        """Add n readings of the kinetic energy (n,) and the other energies (n, parts) [J] to the energy balance."""
        turned = kinetic + np.abs(parts - self._start[1]).sum(axis=1)
        self._turned = float(np.fmax.reduce(turned, initial=self._turned))

    def fine(self, kinetic: np.ndarray, parts: np.ndarray, slip: np.ndarray, held: np.ndarray) -> bool:
        """Return whether n energy readings are in balance, as `check` requires; if so, add them to the balance."""
        before, start = self._start
        changes = parts - start
        turned = np.fmax(kinetic + np.abs(changes).sum(axis=1), held)
        made = self._carried + (kinetic - before + changes.sum(axis=1))
        # a maximum over time, since energy at rest is zero and any error would be infinite relative to it
        turned = np.fmax.accumulate(np.fmax(turned, self._turned))
        allowed = self._share * turned + self._noise(kinetic, np.abs(parts).sum(axis=1), slip)
        known = (made < 0.0) & (not self.strict and self.lost > 0.0)
        if not (np.isfinite(allowed) & ((np.abs(made) <= allowed) | known)).all():
            return False
        self._turned = float(turned[-1])
        self.lost = max([self.lost, *-made[known]])
        return True

    def _noise(self, kinetic: Any, others: Any, slip: Any) -> Any:
        # errors of size one tolerance in every step explain `slip`; round-off grows with the energies, not with their
        # changes
        return ROUND_OFF * (kinetic + others) + self._tolerance * slip

    @property
    def _share(self) -> float:
        return STRAYED if self.strict else MADE

    def check(self, where: str, kinetic: float, parts: np.ndarray, slip: float, held: float) -> None:
        """Raise KernelError if a reading of energies shows that energy was created, or lost without heat.

        parts (parts,): potential, stored, heats, and works with the opposite sign [J]; slip: energy [J] explained by an
        error of size one in every step; held: largest energy of a rope since the last reading [J], since a bounce may
        lie between two readings without motion; where: start of the message.
        """
        size = float(np.abs(parts).sum())
        if not isfinite(kinetic + size):
            raise KernelError(f"{where}: its energies are not finite; check masses, forces and initial speeds")
        before, start = self._start
        changes = parts - start
        self._turned = max(self._turned, kinetic + float(np.abs(changes).sum()), held)
        made = self._carried + (kinetic - before + float(changes.sum()))
        allowed = self._share * self._turned + self._noise(kinetic, size, slip)
        if abs(made) <= allowed:
            return
        # numerical damping of stiff modes is the purpose of implicit methods; it is reported, not refused
        if made < 0.0 and not self.strict:
            self.lost = max(self.lost, -made)
            return
        message = f"{made:.3g} J were created from nothing" if made > 0.0 else f"{-made:.3g} J were lost without heat"
        raise KernelError(
            f"{where}: the energy balance is broken, {message}, more than {100 * self._share:.0f} "
            f"% of the largest energy exchanged so far; {self._cure}"
        )

    @property
    def _cure(self) -> str:
        return "choose a smaller tolerance" if self._tolerance else "choose a shorter step, or method radau5"
