"""Evaluation of the table of limits on an equilibrium path or a run: the highest utilisation of each row, and
violations.

Two checks are made separately: loads against working loads or charts, and the largest tension of a run against the
breaking force divided by the product of the partial factors. An equilibrium path has no such peak.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from heavylift.nodes.plan.limit import IN_WIND, TOUCHING, RatedLimit, Use
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.statics.state import StaticState

from .checks import SAME
from .factors import product
from .messages import NOISE
from .reading import axis_of, read
from .signals import SignalColumns, signals_of

YIELDS = dict.fromkeys(("hook height", "rope length", "rails", "girder"), 0.05)  # [m] of servos, stretch and bounces
YIELDS |= dict.fromkeys(TOUCHING, 1e-10)  # [m/s] of lengths of up to 100 m, rounded, over a millisecond
ELSEWHERE = ("clearance",)  # checked by who looks at shapes


def uses_on_path(plan: Plan, states: Sequence[StaticState]) -> list[Use]:
    """Return the highest utilisation of each limit on the equilibrium path."""
    return uses_of(plan, [signals_of(states)])


def uses_of(plan: Plan, parts: Iterable[SignalColumns]) -> list[Use]:
    """Return the highest utilisation of each limit over the samples; for a limit without data, a Use without a value.

    `parts` are successive intervals of time, each of which begins with the last instant of the one before."""
    peaks = ("sling peak", "rope peak")
    found: list[_Worst] = []
    carried: dict[object, object] = {}
    for i, signals in enumerate(parts):
        signals.carried.update(carried)
        if i == 0:
            left = ELSEWHERE if signals.dynamic else (*ELSEWHERE, *peaks)
            found = [_Worst(limit, signals.dynamic) for limit in plan.limits if limit.quantity not in left]
        for one in found:
            one.see(plan, signals)
        carried = signals.carried
    return [one.use() for one in found]


class _Worst:
    """Search for the highest utilisation of a limit, and the place where it first occurs."""

    def __init__(self, limit: RatedLimit, dynamic: bool) -> None:
        self._limit, self._dynamic = limit, dynamic
        self._tolerance = YIELDS.get(limit.quantity, 0.0) if dynamic or limit.quantity == "hook height" else 0.0
        self._exact: Use | None = None
        self._inside = False  # what was seen when it occurred
        self._source, self._known = "", False
        self._most, self._load = -np.inf, -np.inf  # of uses, and its value: uses beyond a chart are infinite
        self._first: list[tuple[float, Use]] = []  # how bad, rising: each may come near enough to the worst

    def see(self, plan: Plan, signals: SignalColumns) -> None:
        """Update the highest utilisation of the limit with the samples of the next interval of time."""
        limit = self._limit
        reading = read(plan, limit, signals)
        if reading is None:
            return
        self._source, self._known = reading.source, True
        xs = axis_of(plan, limit, signals) if limit.chart else None
        if reading.exact:
            value, t = reading.exact
            x = None if xs is None else float(np.interp(t, signals.t, xs))
            exact, inside = self._made(signals, value, t, None, x), signals.t[0] <= t <= signals.t[-1]
            if self._exact is None or (inside and not (self._inside and self._exceeds(self._exact, exact))):
                self._exact, self._inside = exact, inside
        if xs is not None:
            self._see_chart(signals, reading.values, xs)
        else:
            self._see_values(signals, reading.values)

    def _see_chart(self, signals: SignalColumns, values: np.ndarray, xs: np.ndarray) -> None:
        uses = np.array([self._limit.use(float(v), float(x)) for v, x in zip(values, xs, strict=True)])
        uses[np.isnan(xs)] = np.nan
        if np.isnan(uses).all():
            return
        k = int(np.lexsort((values, np.nan_to_num(uses, nan=-1.0, posinf=np.inf)))[-1])
        if (uses[k], values[k]) > (self._most, self._load):
            self._most, self._load = float(uses[k]), float(values[k])
            self._first = [(self._most, self._made(signals, float(values[k]), float(signals.t[k]), k, float(xs[k])))]

    def _see_values(self, signals: SignalColumns, values: np.ndarray) -> None:
        finite = np.isfinite(values)
        if not finite.any():
            return
        how = self._how(values)
        self._most = max(self._most, float(how.max() if finite.all() else how[finite].max()))
        least = self._most - max(SAME * abs(self._most), NOISE.get(self._limit.unit, 0.0))
        near = np.flatnonzero(how >= least)
        highest = np.maximum.accumulate(np.append(self._first[-1][0] if self._first else -np.inf, how[near]))
        new = near[how[near] > highest[:-1]].tolist()
        self._first = [x for x in self._first if x[0] >= least]
        self._first += [(float(how[k]), self._made(signals, float(values[k]), float(signals.t[k]), k)) for k in new]

    def _how(self, values: np.ndarray) -> np.ndarray:
        if self._limit.between is not None:
            return np.abs(2.0 * values - sum(self._limit.between))
        return -values if self._limit.least else values

    def _made(self, signals: SignalColumns, value: float, t: float, k: int | None, x: float | None = None) -> Use:
        """Return the Use for `value` at time t [s], sample k (None between samples) and argument x of the limit's
        chart."""
        limit = self._limit
        if x is not None:
            action = _action(signals, k)
            return Use(limit, value, t, signals.stage_at(t, k), limit.use(value, x), action, limit.at(x))
        use = limit.use(value) if limit.known else None
        return Use(
            limit, value, t, signals.stage_at(t, k), use, _action(signals, k), None, self._tolerance, self._source
        )

    def use(self) -> Use:
        """Return the highest utilisation of the limit in all samples so far."""
        exact, found = self._exact, self._first[0][1] if self._first else None
        if (rest := self._limit.rest) and self._limit.quantity in (IN_WIND, "wind"):
            use = self._limit.use(rest.value) if self._limit.known else None
            stated = Use(self._limit, rest.value, None, rest.stage, use)
            return max((x for x in (stated, exact, found) if x), key=lambda x: x.value or 0.0)
        if (rest := self._limit.rest) and self._dynamic:
            value = rest.value * product(self._limit, dynamic=False)
            use = value / rest.bound if rest.bound else None
            required = Use(self._limit, value, None, rest.stage, use, bound=rest.bound or None)
            return max((x for x in (required, exact, found) if x), key=lambda x: x.use or x.value or 0.0)
        if exact is None or found is None:
            return exact or found or Use(self._limit, None, missing=not self._known)
        return exact if self._exceeds(exact, found) else found

    def _exceeds(self, a: Use, b: Use) -> bool:
        assert a.value is not None
        assert b.value is not None
        if b.bound is not None:
            return (a.use or 0.0, a.value) > (b.use or 0.0, b.value)
        return a.value < b.value if self._limit.least else a.value > b.value


def _action(signals: SignalColumns, k: int | None) -> int:
    return signals.actions[k] if k is not None and len(signals.actions) else 0
