"""Largest tensions that lie between the ends of steps: found from those, then integrated to, never interpolated.

Three tensions at the ends of two accepted steps show that a rope's tension has a hill between them; before the first
step of a stretch its rate stands for the third one.  If the hill may be the highest of the run, the run stops when the
step is committed and looks for it: a step of the method from the start of the step in question to where the rate should
vanish, and again from there, until nothing more is to be gained.  The state is not touched.  A parabola through three
points of a sine sees at least a third of what is missing (steps of up to two radians).
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import KernelError
from .methods.method import Rate, inside
from .symbol import any_of, maximum, select

if TYPE_CHECKING:
    from .stepper import Stepper

__all__ = ["POINTS", "STATES", "begin", "climb", "last", "remember", "watch"]

POINTS = ("Ta", "Tb", "top")  # (n_ropes,) at the starts of the last two steps; highest so far
STATES = ("ya", "fa")  # (ny,) state and derivative at the start of the step before the last one
LAST = ("t0", "d0", "f0")  # start of the last one
SLIGHT = 1e-4  # of the highest tension: what is not looked for
SEEN = 3.0  # times what a parabola sees
AHEAD = 1e-6  # [s] to where a rate is measured
AT_ONCE, SEARCHES = 64.0, 1.0 / 2048.0  # searches that are free, and further ones per step
ROUNDS = 6
SETTLED = 1e-7  # of the tension: a gain that is none


def begin(s: SimpleNamespace, rate: Rate) -> None:
    """At the start of a stretch: a point before it, on the tangent."""
    ahead = rate(s.t + AHEAD, inside(s), s.y + AHEAD * s.f).T
    s.ta, s.t0, s.Tb, s.Ta = s.t - AHEAD, s.t, s.T, 2.0 * s.T - ahead
    s.ya = s.d0 = s.y
    s.fa = s.f0 = s.f
    s.peaking = 0.0


def remember(s: SimpleNamespace) -> None:
    """Before an attempt: the last step, if it was taken, becomes the one before it."""
    taken = s.t > s.t0
    s.ta, s.Ta, s.Tb = select(taken, s.t0, s.ta), select(taken, s.Tb, s.Ta), select(taken, s.T, s.Tb)
    s.ya, s.fa = select(taken, s.d0, s.ya), select(taken, s.f0, s.fa)


def watch(s: SimpleNamespace, ok: Any) -> None:
    """After an attempt: whether it shows a hill that may be the highest."""
    allowed = s.searched < AT_ONCE + SEARCHES * s.accepted
    s.peaking = select(ok & any_of(_higher(s, select(ok, s.t, s.t0 + 1.0))) & allowed, 1.0, 0.0)


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


class _Step:
    """One accepted step: its start, and where it ends."""

    def __init__(self, run: Stepper, start: tuple[str, str, str], end: str) -> None:
        """`start`: names of its time, state and derivative in the block."""
        t, y, f = (run._at[name] for name in start)
        self._run, self.t, self.end = run, float(run.X[t]), run[end]
        self._y, self._f = run.X[y].copy(), run.X[f].copy()

    def tensions(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """At a time in the step, by a step of the method: tensions and their rates."""
        run = self._run
        if t > self.t:
            for name, value in (("t", self.t), ("t0", self.t), ("y", self._y), ("f", self._f)):
                run.X[run._at[name]] = value
            run._set(tentative=0.0, **({"warm": 0.0} if "warm" in run._at else {}))
            run._forced(t)
            return self.rates(t, run.state.copy())
        return self.rates(t, self._y)

    def rates(self, t: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of a state at a time in the step."""
        among = 0.5 * (self.t + self.end)
        f, T = self._run.rate_at(t, among, y)
        _, ahead = self._run.rate_at(t + AHEAD, among, y + AHEAD * f)
        return T, (ahead - T) / AHEAD


def climb(run: Stepper) -> None:
    """Look for the hills that the last two steps, just committed, have shown; they count among the peaks."""
    names = ("t", "t0", "ta", "Ta", "Tb", "T", "top")
    seen = SimpleNamespace(**{name: run.X[run._at[name]] for name in names})
    higher = np.array(_higher(seen, seen.t), dtype=bool)
    first, second = _Step(run, ("ta", *STATES), "t0"), _Step(run, LAST, "t")
    _search(run, np.flatnonzero(higher), second, first)


def last(run: Stepper) -> None:
    """Before an event or a command: hills in the last step, after which nothing more would show them."""
    at = run._at
    if "top" not in at or not run["t"] > run["t0"]:
        return
    T, Tb, top = (run.X[at[name]].copy() for name in ("T", "Tb", "top"))
    near = (Tb <= T) & (top < 2.0 * T)
    if not near.any():
        return
    step = _Step(run, LAST, "t")
    _, slope = step.rates(step.end, run.state.copy())
    high = near & (slope < 0.0) & (T - 0.25 * slope * (step.end - step.t) > (1.0 + SLIGHT) * np.maximum(top, T))
    if high.any():
        _search(run, np.flatnonzero(high), step)


def _search(run: Stepper, hills: np.ndarray, step: _Step, first: _Step | None = None) -> None:
    """Raise the peaks of ropes to the tops of their hills, in `step` or in the one before it; all else stays."""
    X, M, y = run.X.copy(), None if run.M is None else run.M.copy(), run.state.copy()
    found: list[tuple[int, float, float]] = []
    try:
        low, end = step.tensions(step.t), step.rates(step.end, y)
        for i in hills:
            if first and low[1][i] <= 0.0:
                found.append((i, *_top(int(i), first, first.tensions(first.t), low)))
            else:
                found.append((i, *_top(int(i), step, low, end)))
    except KernelError:
        pass  # an implicit step without a solution: the ends of the steps remain
    run.X[:] = X
    if run.M is not None:
        run.M[:] = M
    top, peak, when = (run.X[run._at[name]] for name in ("top", "peak", "peak_time"))
    for i, T, t in found:
        top[i] = max(top[i], T)
        if peak[i] < T:
            peak[i], when[i] = T, t
    run._set(peaking=0.0, searched=run["searched"] + 1.0)


Ends = tuple[np.ndarray, np.ndarray]


def _top(i: int, step: _Step, low: Ends, high: Ends) -> tuple[float, float]:
    """Largest tension of rope i in a step, and when: cubics through tensions and rates say where to look next."""
    (a, Ta, da), (b, Tb, db) = (step.t, low[0][i], low[1][i]), (step.end, high[0][i], high[1][i])
    best = max((float(Ta), a), (float(Tb), b))
    for _ in range(ROUNDS):
        if not da > 0.0 > db:
            break
        x, expected = _highest(a, Ta, da, b, Tb, db)
        if expected <= best[0] * (1.0 + SETTLED):
            break
        T, rate = (values[i] for values in step.tensions(x))
        best = max(best, (float(T), x))
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
