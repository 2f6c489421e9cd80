"""Detection of rattling ropes, which become slack and taut faster than a run can resolve: they are counted, then
damped, and noted.

In a steel rope 10 cm long, a wave travels to and fro in 40 us; no massless rope has events closer than that, and each
costs a run more than a hundred steps. When a rope has become taut MANY times in a row, each within RESOLVED (or a fixed
step) of the one before, it continues without events (`RopeLaw`, calm), with at least critical damping for the mass that
its ends move, so that the rattle dies out. It stays so until it is hooked again.

The module also detects a run that stops making progress: too many steps for a second of simulated time, or too many
events too close together. Both are counted, not timed, so that all runs of a scene end alike. With steps of a
microsecond, a second of work advances the scene by a tenth of a second or less; no law of a lift needs that.
"""

from collections.abc import Callable
from math import sqrt

import numpy as np
from heavylift.kernel.forces.ropes import ROPE_HEAD, ROPE_LINE, RopeAt

RESOLVED = 5e-5  # [s] between two events, below which they are a rattle
MANY = 50  # times in a row that a rope becomes taut

Rate = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


class Rattling:
    """Detects rattling ropes by counting the rapidly repeated events of each rope."""

    def __init__(self, resolved: float) -> None:
        self._resolved_ns = round(resolved * 1e9)
        self.counts: dict[str, tuple[int, int, int]] = {}  # how many, when the first and the last came [ns]

    def hear(self, name: str, t_ns: int) -> float:
        """Register that a rope became taut; return the frequency of its rattle [Hz], 0 if it does not rattle."""
        n, first, last = self.counts.get(name, (0, t_ns, t_ns))
        # a pause longer than the resolution begins a new rattle
        n, first = (n + 1, first) if t_ns - last <= self._resolved_ns else (0, t_ns)
        self.counts[name] = n, first, t_ns
        if n < MANY:
            return 0.0
        del self.counts[name]
        return 0.5 * n / max(t_ns - first, 1) * 1e9  # two events make one oscillation


def critical(EA: float, L0: float, mass: float) -> float:
    """Return the critical damping [N s/m] of a mass on a rope; zero if the rope moves no finite mass."""
    return 2.0 * sqrt(EA / L0 * mass) if mass < np.inf else 0.0


def moved_mass(p: np.ndarray, i: int, velocities: slice, y: np.ndarray, rate: Rate) -> float:
    """Return the effective mass [kg] that moves along rope i, 1/(J H^-1 J^T); infinite if the rope moves nothing.

    p: the rope's numbers, restored at the end; `rate(y)`: derivative and tensions with these numbers.
    """
    before, c = p.copy(), float(p[RopeAt.EA])
    # the weight of a heavy rope, last in its numbers, would accelerate its ends without any tension
    if (len(p) - ROPE_HEAD) % ROPE_LINE:
        p[-1] = 0.0  # its own weight moves nothing along it
    p[RopeAt.TAUT] = 0.0
    free, _ = rate(y)
    # no strain counts, so that the tension is the given speed times the damping alone
    p[RopeAt.DAMPING : RopeAt.TAUT + 1] = c, 1.0, 1.0  # so many newtons per m/s, whatever the strain
    pulled, T = rate(y)
    mass = np.inf
    if T[i] > 0.0:
        kick = (pulled - free)[velocities] / T[i]
        there = y.copy()
        # velocities changed by the kick, scaled to 1 m/s at most
        there[velocities] -= kick / max(float(np.abs(kick).max()), 1e-300)
        _, more = rate(there)
        # 1 / m = J H^-1 J^T: speed of the ends per unit of impulse along the rope
        faster = (more[i] - T[i]) / c * float(np.abs(kick).max())
        mass = 1.0 / faster if faster > 0.0 else np.inf
    p[:] = before
    return float(mass)


STEPS = 1_000_000  # attempted for one second of the scene
CROWD = 2000  # events in a row, each so close to the last that no rope or support could distinguish them, or in a spell
SPELL_NS = 10_000_000  # of the scene


class StepBudget:
    """Limits on the number of steps per simulated second and on the number of events in quick succession.

    `since`: attempts and time [s] at the beginning of the present second; `crowd`: consecutive events, time of the
    last; `spell`: number of events, beginning [ns].
    """

    def __init__(self, resolved_ns: int) -> None:
        self._resolved_ns = resolved_ns
        self.since = 0.0, 0.0
        self.crowd = 0, 0
        self.spell = 0, 0

    def ends(self, attempts: float, t: float) -> bool:
        """Return whether the run has taken too many steps per second of simulated time up to the time t [s]."""
        before, start = self.since
        # counted per simulated second, not by a clock: every run of the scene ends at the same step
        if t - start >= 1.0:
            self.since = attempts, t
            return False
        return attempts - before >= STEPS

    def crowded(self, t_ns: int) -> bool:
        """Register an event at t_ns; return whether too many events follow each other too quickly."""
        count, since = self.spell
        self.spell = (count + 1, since) if t_ns - since <= SPELL_NS else (1, t_ns)
        n, last = self.crowd
        self.crowd = (n + 1 if t_ns - last <= self._resolved_ns else 0), t_ns
        return self.crowd[0] > CROWD or self.spell[0] > CROWD
