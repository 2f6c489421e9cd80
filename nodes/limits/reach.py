"""Radius and utilisation of the chart in each stage: when a load is first on the hook, at the largest utilisation, and
last."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np
from heavylift.nodes.plan.limit import RatedLimit, Reach
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.statics.state import StaticState

from .reading import axis_of, read
from .signals import SignalColumns, signals_of

WHEN = ("begins", "most", "ends")


class HookReach:
    """Reached radii of hooks with a radius chart, over successive parts of a path or run."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._limits = [x for x in plan.limits if x.quantity == "hook load" and x.over == "radius"]
        self._found: dict[tuple[str, str], list[Reach]] = {}

    def see(self, signals: SignalColumns) -> SignalColumns:
        """Add the samples of the next part, and return them."""
        for limit in self._limits:
            reading, radii = read(self._plan, limit, signals), axis_of(self._plan, limit, signals)
            if reading is None or radii is None:
                continue
            for k in np.flatnonzero(np.isfinite(reading.values + radii)).tolist():
                self._add(limit, signals, float(signals.t[k]), float(radii[k]), float(reading.values[k]), k)
            if reading.exact and signals.t[0] <= reading.exact[1] <= signals.t[-1]:
                load, t = reading.exact
                self._add(limit, signals, t, float(np.interp(t, signals.t, radii)), load, None)
        return signals

    def see_path(self, states: Sequence[StaticState]) -> tuple[Reach, ...]:
        """Evaluate an equilibrium path."""
        self.see(signals_of(states))
        return self.found

    def _add(
        self, limit: RatedLimit, signals: SignalColumns, t: float, radius: float, load: float, k: int | None
    ) -> None:
        stage = signals.stage_at(t, k)
        one = Reach(hook=limit.subject, stage=stage, t=t, radius=radius, load=load, capacity=limit.at(radius))
        first, most, last = self._found.setdefault((limit.subject, stage), [one] * 3)
        self._found[limit.subject, stage] = [
            one if t < first.t else first, one if one.use > most.use else most, one if t >= last.t else last
        ]  # fmt: skip

    @property
    def found(self) -> tuple[Reach, ...]:
        """The three radii of each hook and stage, in order of time."""
        each = sorted(self._found.values(), key=lambda three: three[0].t)
        return tuple(
            msgspec.structs.replace(x, when=when) for three in each for when, x in zip(WHEN, three, strict=True)
        )
