"""Largest tensions that lie between the ends of steps: found from those, then integrated to, never interpolated.

Three tensions at the ends of two accepted steps show that a rope's tension has a hill between them; before the first
step of a stretch its rate stands for the third one.  If the hill may be the highest of the run, the run stops when the
step is committed and looks for it: a step of the method from the start of the step in question to where the rate should
vanish, and again from there, until nothing more is to be gained.  The state is not touched.  A parabola through three
points of a sine sees at least a third of what is missing (steps of up to two radians).

There is no end to the searches of a rope as long as its hills differ.  Where three that were looked for are the same,
the next few are skipped: hills that lie on a parabola, at -1, 0 and 1 on it as high to SAME, gain no more than SLIGHT
between two that are FEW + 1 apart.
"""

from __future__ import annotations

from functools import cached_property
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from heavylift.kernel.compiler.symbol import any_of, maximum, select
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.method import Rate, inside
from heavylift.kernel.model.running import Running

__all__ = ["POINTS", "STATES", "begin", "climb", "last", "remember", "watch"]

POINTS = ("Ta", "Tb", "top", "hill", "older", "skips")  # (n_ropes,) at the starts of the last two steps;
# highest so far; the last two hills that were looked for in this stretch, and how many of the next ones are skipped
STATES = ("ya", "fa")  # (ny,) state and derivative at the start of the step before the last one
BEFORE, LAST, NOW = ("ta", "ya", "fa", "Ta"), ("t0", "d0", "f0", "Tb"), ("t", "y", "f", "T")  # ends of the two steps
SLIGHT = 1e-4  # of the highest tension: what is not looked for
SEEN = 3.0  # times what a parabola sees
FEW = 7.0  # hills that are skipped after the same three
SAME = SLIGHT / (0.5 * (FEW + 1.0)) ** 2  # of the tension: by how much those differ
AHEAD = 1e-6  # [s] to where a rate is measured
ROUNDS = 6
SETTLED = 1e-7  # of the tension: a gain that is none


def begin(s: SimpleNamespace, rate: Rate) -> None:
    """At the start of a stretch: a point before it, on the tangent."""
    ahead = rate(s.t + AHEAD, inside(s), s.y + AHEAD * s.f).T
    s.ta, s.t0, s.Tb, s.Ta = s.t - AHEAD, s.t, s.T, 2.0 * s.T - ahead
    s.ya = s.d0 = s.y
    s.fa = s.f0 = s.f
    s.peaking, s.hill, s.older, s.skips = 0.0, 0.0 * s.T, 0.0 * s.T, 0.0 * s.T


def remember(s: SimpleNamespace) -> None:
    """Before an attempt: the last step, if it was taken, becomes the one before it."""
    taken = s.t > s.t0
    s.ta, s.Ta, s.Tb = select(taken, s.t0, s.ta), select(taken, s.Tb, s.Ta), select(taken, s.T, s.Tb)
    s.ya, s.fa = select(taken, s.d0, s.ya), select(taken, s.f0, s.fa)


def watch(s: SimpleNamespace, ok: Any) -> None:
    """After an attempt: whether it shows a hill that may be the highest and is not skipped."""
    higher = [ok & h for h in _higher(s, select(ok, s.t, s.t0 + 1.0))]
    due = [h & (n <= 0.0) for h, n in zip(higher, s.skips, strict=True)]
    s.skips = np.array([select(h, n - 1.0, n) for h, n in zip(higher, s.skips, strict=True)], dtype=object)
    s.peaking = select(any_of(due), 1.0, 0.0)


def _higher(s: SimpleNamespace, end: Any) -> list[Any]:
    """Of each rope, whether the last two steps, to time `end`, show a hill that may be the highest."""
    before, after, whole = 1.0 / (s.t0 - s.ta), 1.0 / (end - s.t0), 1.0 / (end - s.ta)
    higher = []
    for a, b, c, top in zip(s.Ta, s.Tb, s.T, s.top, strict=True):
        up, down = (b - a) * before, (b - c) * after
        slope = (up * (end - s.t0) - down * (s.t0 - s.ta)) * whole
        more = slope * slope / (4.0 * maximum((up + down) * whole, 1e-30))
        hill = (up >= 0.0) & (down >= 0.0)
        higher.append(hill & (b + SEEN * more > (1.0 + SLIGHT) * maximum(top, maximum(b, c))))
    return higher


class _Point(NamedTuple):
    """One end of a step, or a time within it: local time, and tensions of all ropes with their rates."""

    t: float
    T: np.ndarray
    rate: np.ndarray


class _Step:
    """One accepted step between two ends, each given by the names of its time, state, derivative and tensions."""

    def __init__(self, run: Running, start: tuple[str, ...], end: tuple[str, ...]) -> None:
        self._run, self._ends = run, tuple([run.X[run._at[name]].copy() for name in names] for names in (start, end))
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
        run = self._run
        start, y, f, _ = self._ends[0]
        for name, value in (("ta", start - AHEAD), ("t0", start), ("t", start), ("y", y), ("f", f)):
            run.X[run._at[name]] = value
        run._set(tentative=0.0, **({"warm": 0.0} if "warm" in run._at else {}))
        run._forced(t)
        return self._point(*(run.X[run._at[name]].copy() for name in NOW))

    def _point(self, t: np.ndarray, y: np.ndarray, f: np.ndarray, T: np.ndarray) -> _Point:
        _, ahead = self._run.rate_at(float(t) + AHEAD, self._among, y + AHEAD * f)
        return _Point(float(t), T, (ahead - T) / AHEAD)


def climb(run: Running) -> None:
    """Look for the hills that the last two steps, just committed, have shown; they count among the peaks."""
    names = ("t", "t0", "ta", "Ta", "Tb", "T", "top", "skips")
    seen = SimpleNamespace(**{name: run.X[run._at[name]] for name in names})
    due = np.array(_higher(seen, seen.t), dtype=bool) & (seen.skips < 0.0)
    _search(run, np.flatnonzero(due), _Step(run, LAST, NOW), _Step(run, BEFORE, LAST))


def last(run: Running) -> None:
    """Before an event or a command: hills in the last step, after which nothing more would show them."""
    at = run._at
    if "top" not in at or not run["t"] > run["t0"]:
        return
    T, Tb, top = (run.X[at[name]].copy() for name in ("T", "Tb", "top"))
    near = (Tb <= T) & (top < 2.0 * T)
    if not near.any():
        return
    step = _Step(run, LAST, NOW)
    slope = step.end.rate
    high = near & (slope < 0.0) & (T - 0.25 * slope * (run["t"] - run["t0"]) > (1.0 + SLIGHT) * np.maximum(top, T))
    if high.any():
        _search(run, np.flatnonzero(high), step)


def _search(run: Running, hills: np.ndarray, step: _Step, first: _Step | None = None) -> None:
    """Raise the peaks of ropes to the tops of their hills, in `step` or in the one before it; all else stays."""
    X, M = run.X.copy(), None if run.M is None else run.M.copy()
    found: list[tuple[int, float, float]] = []
    try:
        for i in hills:
            where = first if first and step.start.rate[i] <= 0.0 else step
            found.append((i, *_top(int(i), where)))
    except KernelError:
        pass  # an implicit step without a solution: the ends of the steps remain
    run.X[:] = X
    if run.M is not None:
        run.M[:] = M
    names = ("top", "peak", "peak_time", "hill", "older", "skips")
    top, peak, when, hill, older, skips = (run.X[run._at[name]] for name in names)
    skips[hills] = 0.0
    for i, T, t in found:
        three = (T, hill[i], older[i])
        skips[i] = FEW * (max(three) - min(three) <= SAME * T)
        hill[i], older[i] = T, hill[i]
        top[i] = max(top[i], T)
        if peak[i] < T:
            peak[i], when[i] = T, t
    run._set(peaking=0.0, searched=run["searched"] + 1.0)


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
