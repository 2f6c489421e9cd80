"""How far two runs of one lift are apart, in each quantity that a scene can ask.

rope tension    largest relative difference of a hook's peak
swing           of the block about what it hangs from: largest excursion, and frequency after the last move if a
                tenth of that is left, relative
position        of the block when each stage begins, and at the end, relative to the longest way that it goes
lift-off time   of the end of each stage that lifts it, relative to its duration or half a second, whichever is longer
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from heavylift.nodes.fidelity import drive_name, lift_of
from heavylift.nodes.plan import SHORTEST, VERBS, Move

STANDS = "up"  # the first stage in which the block hangs
LIFTS = "lift"  # begins the name of a stage that lifts it
LEFT = 0.1  # of the largest excursion, for its frequency to be seen


class Seen:
    """What one run showed: peaks (n_hooks,) [N], stage -> begin [s], times (n,) [s], places of the block (n, 3) [m],
    and what it cost [evaluations x states]."""

    def __init__(self, plan, peaks, began, times, places, cost) -> None:
        self.plan, self.peaks, self.began, self.cost = plan, np.asarray(peaks), dict(began), cost
        self.times, first = np.unique(times, return_index=True)
        self.places = np.asarray(places)[first]

    @classmethod
    def of(cls, scene, run) -> Seen:
        """Of a run by `lifted`."""
        return cls(scene.plan, run.peaks, run.began, run.times, run.places, run.evaluations * run.states)

    def at(self, t: float) -> np.ndarray:
        """Place of the block, by cubics through four samples [m]."""
        i = int(np.clip(np.searchsorted(self.times, t) - 2, 0, len(self.times) - 4))
        x = self.times[i : i + 4]
        weights = [np.prod([(t - x[m]) / (x[k] - x[m]) for m in range(4) if m != k]) for k in range(4)]
        return np.array(weights) @ self.places[i : i + 4]

    def sway(self) -> tuple[np.ndarray, np.ndarray]:
        """Times from the first move sideways, or from when it hangs, and how far the block is from where the moves of
        what it hangs from want it (n, 2) [m]."""
        moves = list(self._sideways())
        begin = self.began[moves[0][0] if moves else STANDS]
        chosen = self.times >= begin
        t, xy = self.times[chosen], self.places[chosen, :2] - self.at(begin)[:2]
        for stage, order, part in moves:
            axis = 1 if VERBS[order.verb].along == "y" else 0
            xy[:, axis] -= [part * _way(s - self.began[stage], order) for s in t]
        return t, xy

    def _sideways(self):
        """Stage, move, part of the hooks that it moves."""
        hung = [(c, hook) for c in lift_of(self.plan).cranes for hook in c.hooks if hook.rope in self._ropes]
        drives = [drive_name(c.name, which) for c, hook in hung for which in ("gantry", hook.trolley)]
        for action in self.plan.actions:
            for order in action.orders:
                if isinstance(order, Move) and VERBS[order.verb].along and order.actuator in drives:
                    yield action.stage, order, drives.count(order.actuator) / len(hung)

    @property
    def _ropes(self) -> list[str]:
        return [r.name for r in lift_of(self.plan).rig.hook_ropes]

    def lifting(self) -> list[tuple[float, float]]:
        """Begin and end of the stages that lift the block [s]."""
        return [(self.began[a], self.began[b]) for a, b in pairwise(self.began) if a.startswith(LIFTS)]

    def swings(self, like: Seen | None = None) -> tuple[float, float, float]:
        """Largest excursion [m]; angular frequency [rad/s] and size [m] of what is left after the last move, on the
        axis on which most is left, of this run or of another."""
        t, xy = self.sway()
        free = t >= self.began["swing"]
        seen, way = (like or self).sway()
        axis = int(np.argmax(np.ptp(way[seen >= (like or self).began["swing"]], axis=0)))
        largest = float(np.sqrt((xy**2).sum(axis=1)).max())
        return largest, _frequency(t[free], xy[free, axis]), float(np.ptp(xy[free, axis])) / 2.0


def apart(one: Seen, true: Seen) -> dict[str, float]:
    """Quantity -> how far the first run is from the second."""
    (size, omega, _), (size0, omega0, left) = one.swings(true), true.swings()
    ways = np.array([true.at(t) for t in true.began.values()])
    gone = np.array([one.at(one.began[stage]) for stage in true.began])
    longest = np.linalg.norm(np.diff(ways, axis=0), axis=1).max()
    lifts = zip(one.lifting(), true.lifting(), strict=True)
    late = [abs(b - a - (d - c)) / max(SHORTEST, d - c) for (a, b), (c, d) in lifts]
    return {
        "rope tension": float(np.abs(one.peaks / true.peaks - 1.0).max()),
        "swing": max(abs(size / size0 - 1.0), abs(omega / omega0 - 1.0) if left > LEFT * size0 else 0.0),
        "position": float(np.linalg.norm(gone - ways, axis=1).max() / longest),
        "lift-off time": max(late),
    }


def _way(t: float, order) -> float:
    """Of a trapezoid of speed, t after its begin [m]."""
    if t <= 0.0:
        return 0.0
    way, a = abs(order.by), order.accel
    v = min(abs(order.speed), np.sqrt(a * way))
    ramp, whole = v / a, way / v + v / a
    t = min(t, whole)
    gone = a * min(t, ramp) ** 2 / 2.0 + v * max(0.0, min(t, whole - ramp) - ramp)
    if t > whole - ramp:
        s = t - (whole - ramp)
        gone += v * s - a * s * s / 2.0
    return float(np.sign(order.by) * gone)


def _frequency(t: np.ndarray, x: np.ndarray) -> float:
    """The one whose sine fits best."""

    def left(omega: float) -> float:
        basis = np.stack([np.ones_like(t), np.cos(omega * (t - t[0])), np.sin(omega * (t - t[0]))], 1)
        return float(np.linalg.norm(x - basis @ np.linalg.lstsq(basis, x, rcond=None)[0]))

    grid = np.linspace(0.2, 1.5, 131)
    best = float(grid[int(np.argmin([left(w) for w in grid]))])
    a, b = best - 0.01, best + 0.01
    for _ in range(40):
        c, d = b - 0.618034 * (b - a), a + 0.618034 * (b - a)
        a, b = (a, d) if left(c) < left(d) else (c, b)
    return (a + b) / 2.0
