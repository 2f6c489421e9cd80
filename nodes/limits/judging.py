"""Judges the table of limits on what happened or would happen: the worst of each row, and what is beyond it.

Two judgements stand apart: loads against what may be carried (working load or chart), and the largest tension of a run
against the breaking force over the product of partial factors; a path at rest has no such peak.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .findings import Finding
from .limit import Limit, Use
from .reading import Reading, axis_of, read
from .signals import Signals, signals_of
from .telling import finding_of, sorted_findings

if TYPE_CHECKING:
    from heavylift.nodes.scene.plan import Plan
    from heavylift.nodes.statics.state import StaticState

__all__ = ["judge", "judge_path", "judge_run", "limits_of", "uses_of", "uses_of_run", "uses_on_path"]

SAME = 1e-6  # of the worst value: what comes so close to it came to it first
YIELDS = dict.fromkeys(("hook height", "rope length", "rails", "girder"), 0.05)  # [m] of servos, stretch and bounces
ELSEWHERE = ("clearance",)  # judged by who looks at shapes


def limits_of(plan: Plan) -> tuple[Limit, ...]:
    """The table of limits of a scene."""
    return plan.limits


def uses_on_path(plan: Plan, states: Sequence[StaticState]) -> list[Use]:
    """The worst of each limit on the equilibrium path."""
    return uses_of(plan, signals_of(states))


def uses_of_run(plan: Plan, signals: Signals) -> list[Use]:
    """The worst of each limit in a run."""
    return uses_of(plan, signals)


def judge_path(plan: Plan, states: Sequence[StaticState]) -> list[Finding]:
    """What would be beyond its limit at rest, worst first."""
    return judge(plan, uses_on_path(plan, states), dynamic=False)


def judge_run(plan: Plan, signals: Signals) -> list[Finding]:
    """What was beyond its limit in a run, worst first."""
    return judge(plan, uses_of_run(plan, signals), dynamic=True)


def judge(plan: Plan, uses: Sequence[Use], *, dynamic: bool) -> list[Finding]:
    """The findings of uses, worst first; of several subjects with the same trouble all are told."""
    return sorted_findings([told for use in uses if (told := finding_of(plan, use, dynamic=dynamic)) is not None])


def uses_of(plan: Plan, signals: Signals) -> list[Use]:
    """The worst of each limit; a limit that nothing could be read of has a Use without a value."""
    peaks = ("sling peak", "rope peak")
    return [
        _use(plan, limit, signals)
        for limit in plan.limits
        if limit.quantity not in ELSEWHERE and (signals.dynamic or limit.quantity not in peaks)
    ]


def _use(plan: Plan, limit: Limit, signals: Signals) -> Use:
    reading = read(plan, limit, signals)
    if reading is None or not (len(reading.values) or reading.exact):
        return Use(limit, None)
    bounds = axis_of(plan, limit, signals) if limit.chart else None
    if bounds is not None:
        return _by_chart(limit, signals, reading, bounds)
    k, value = _worst(limit, reading)
    if k is None and reading.exact is None:
        return Use(limit, None)
    t = float(signals.t[k]) if k is not None else 0.0
    if reading.exact and (k is None or _worse(limit, reading.exact[0], value)):
        value, t, k = *reading.exact, None
    use = limit.use(value) if limit.known else None
    tolerance = YIELDS.get(limit.quantity, 0.0) if signals.dynamic or limit.quantity == "hook height" else 0.0
    return Use(limit, value, t, signals.stage_at(t, k), use, _action(signals, k), tolerance=tolerance)


def _worst(limit: Limit, reading: Reading) -> tuple[int | None, float]:
    """Where the worst value is met first, and that value."""
    values = reading.values
    finite = np.isfinite(values)
    if not finite.any():
        return None, 0.0
    how = -values if limit.least else values
    if limit.between is not None:
        how = np.abs(2.0 * values - sum(limit.between))
    most = float(how.max() if finite.all() else how[finite].max())
    k = int(np.argmax(how >= most - SAME * abs(most)))  # nan is never as much
    return k, float(values[k])


def _worse(limit: Limit, a: float, b: float) -> bool:
    return a < b if limit.least else a > b


def _by_chart(limit: Limit, signals: Signals, reading: Reading, xs: np.ndarray) -> Use:
    """The largest use along a chart."""
    uses = np.array([limit.use(float(v), float(x)) for v, x in zip(reading.values, xs, strict=True)])
    k = int(np.nanargmax(uses))
    value, t, use, bound = float(reading.values[k]), float(signals.t[k]), float(uses[k]), limit.at(float(xs[k]))
    if reading.exact:
        x = float(np.interp(reading.exact[1], signals.t, xs))
        if limit.use(reading.exact[0], x) > use:
            value, t = reading.exact
            return Use(limit, value, t, signals.stage_at(t), limit.use(value, x), 0, limit.at(x))
    return Use(limit, value, t, signals.stage_at(t, k), use, _action(signals, k), bound)


def _action(signals: Signals, k: int | None) -> int:
    return signals.actions[k] if k is not None and len(signals.actions) else 0
