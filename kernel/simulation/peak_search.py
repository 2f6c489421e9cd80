"""The largest tension of a run where it is: found from the ends of steps, then integrated to, never interpolated.

Where the last two steps show a hill (`native.peaks`), a step of the method from the start of the step in question leads
to where the rate should vanish, and again from there, until nothing more is to be gained.  The state is not touched.

There is no end to the searches of a rope as long as its hills differ.  Where three that were looked for are the same,
the next few are skipped: hills that lie on a parabola, at -1, 0 and 1 on it as high to SAME, gain no more than SLIGHT
between two that are FEW + 1 apart.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.step_state import StepState
from heavylift.kernel.simulation.native.native_state import NativeState
from heavylift.kernel.simulation.native.peaks import AHEAD, SLIGHT, higher

__all__ = ["Forced", "PeakSearch"]

BEFORE, LAST, NOW = ("ta", "ya", "fa", "Ta"), ("t0", "d0", "f0", "Tb"), ("t", "y", "f", "T")  # ends of the two steps
FEW = 7.0  # hills that are skipped after the same three
SAME = SLIGHT / (0.5 * (FEW + 1.0)) ** 2  # of the tension: by how much those differ
ROUNDS = 6
SETTLED = 1e-7  # of the tension: a gain that is none

Forced = Callable[[float], None]  # takes one step of the method to a local time


class _Point(NamedTuple):
    """One end of a step, or a time within it: local time, and tensions of all ropes with their rates."""

    t: float
    T: np.ndarray
    rate: np.ndarray


class _Step:
    """One accepted step between two ends, each given by the names of its time, state, derivative and tensions."""

    def __init__(self, native: NativeState, forced: Forced, start: tuple[str, ...], end: tuple[str, ...]) -> None:
        self._native, self._forced = native, forced
        self._ends = tuple([native.X[native.at[name]].copy() for name in names] for names in (start, end))
        self._among = 0.5 * float(self._ends[0][0] + self._ends[1][0])

    @cached_property
    def start(self) -> _Point:
        """With rates, as `end`."""
        return self._point(*self._ends[0])

    @cached_property
    def end(self) -> _Point:
        """The state is the one that was committed."""
        return self._point(*self._ends[1])

    def at(self, t: float) -> _Point:
        """At a time in the step, by a step of the method from its start."""
        native = self._native
        start, y, f, _ = self._ends[0]
        for name, value in (("ta", start - AHEAD), ("t0", start), ("t", start), ("y", y), ("f", f)):
            native.X[native.at[name]] = value
        native.set(tentative=0.0, **({"warm": 0.0} if "warm" in native.at else {}))
        self._forced(t)
        return self._point(*(native.X[native.at[name]].copy() for name in NOW))

    def _point(self, t: np.ndarray, y: np.ndarray, f: np.ndarray, T: np.ndarray) -> _Point:
        _, ahead = self._native.rate_at(float(t) + AHEAD, self._among, y + AHEAD * f)
        return _Point(float(t), T, (ahead - T) / AHEAD)


class PeakSearch:
    """Raises peaks of tensions to the tops of their hills; `forced` takes the steps."""

    def __init__(self, native: NativeState, forced: Forced) -> None:
        self._native, self._forced = native, forced

    def _step(self, start: tuple[str, ...], end: tuple[str, ...]) -> _Step:
        return _Step(self._native, self._forced, start, end)

    def climb(self) -> None:
        """Look for the hills that the last two steps, just committed, have shown; they count among the peaks."""
        native = self._native
        names = ("t", "t0", "ta", "Ta", "Tb", "T", "top", "skips")
        seen = StepState(**{name: native.X[native.at[name]] for name in names})
        due = np.array(higher(seen, seen.t), dtype=bool) & (seen.skips < 0.0)
        self._search(np.flatnonzero(due), self._step(LAST, NOW), self._step(BEFORE, LAST))

    def last(self) -> None:
        """Before an event or a command: hills in the last step, after which nothing more would show them."""
        native = self._native
        at = native.at
        if "top" not in at or not native["t"] > native["t0"]:
            return
        T, Tb, top = (native.X[at[name]].copy() for name in ("T", "Tb", "top"))
        near = (Tb <= T) & (top < 2.0 * T)
        if not near.any():
            return
        step = self._step(LAST, NOW)
        slope = step.end.rate
        hill = T - 0.25 * slope * (native["t"] - native["t0"])
        high = near & (slope < 0.0) & (hill > (1.0 + SLIGHT) * np.maximum(top, T))
        if high.any():
            self._search(np.flatnonzero(high), step)

    def _search(self, hills: np.ndarray, step: _Step, first: _Step | None = None) -> None:
        """Raise the peaks of ropes to the tops of their hills, in `step` or in the one before it; all else stays."""
        native = self._native
        X, M = native.X.copy(), None if native.M is None else native.M.copy()
        found: list[tuple[int, float, float]] = []
        try:
            for i in hills:
                where = first if first and step.start.rate[i] <= 0.0 else step
                found.append((i, *_top(int(i), where)))
        except KernelError:
            pass  # an implicit step without a solution: the ends of the steps remain
        native.X[:] = X
        if native.M is not None:
            native.M[:] = M
        names = ("top", "peak", "peak_time", "hill", "older", "skips")
        top, peak, when, hill, older, skips = (native.X[native.at[name]] for name in names)
        skips[hills] = 0.0
        for i, T, t in found:
            three = (T, hill[i], older[i])
            skips[i] = FEW * (max(three) - min(three) <= SAME * T)
            hill[i], older[i] = T, hill[i]
            top[i] = max(top[i], T)
            if peak[i] < T:
                peak[i], when[i] = T, t
        native.set(peaking=0.0, searched=native["searched"] + 1.0)


def _top(i: int, step: _Step) -> tuple[float, float]:
    """Largest tension of rope i in a step, and when: cubics through tensions and rates say where to look next."""
    (a, Ta, da), (b, Tb, db) = ((p.t, float(p.T[i]), float(p.rate[i])) for p in (step.start, step.end))
    best = max((Ta, a), (Tb, b))
    for _ in range(ROUNDS):
        if not da > 0.0 > db:
            break
        x, expected = _highest(a, Ta, da, b, Tb, db)
        if expected <= best[0] * (1.0 + SETTLED):
            break
        p = step.at(x)
        T, rate = float(p.T[i]), float(p.rate[i])
        best = max(best, (T, x))
        a, Ta, da, b, Tb, db = (x, T, rate, b, Tb, db) if rate > 0.0 else (a, Ta, da, x, T, rate)
    return best


def _highest(a: float, Ta: float, da: float, b: float, Tb: float, db: float) -> tuple[float, float]:
    """Where the cubic with these values and slopes at a and b is highest, da > 0 > db, and how high it is there."""
    h = b - a
    s = (Tb - Ta) / h
    c2, c3 = (3.0 * s - 2.0 * da - db) / h, (da + db - 2.0 * s) / h**2
    # da + 2 c2 x + 3 c3 x^2 = 0, the root where the slope falls
    root = np.sqrt(max(c2 * c2 - 3.0 * c3 * da, 0.0))
    x = float(np.clip(da / (root - c2) if root > c2 else 0.5 * h, 0.02 * h, 0.98 * h))
    return a + x, Ta + x * (da + x * (c2 + x * c3))
