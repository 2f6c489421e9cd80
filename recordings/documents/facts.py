"""What the tables of a report read: verdict and peaks as they are recorded, loads and stages from the samples.

A crane's load is the sum of its hook tensions.  The dynamic factor of a stage is the largest such sum over the larger
one of the sums at rest before and at the end of the stage.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format import machines
from heavylift.recordings.format.samples import REEVING, reeved
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.signal import Signal
from heavylift.recordings.read.verdict import RecordedVerdict, recorded_peaks, recorded_verdict
from heavylift.recordings.write.sink import Peak
from numpy.typing import NDArray

from .loads import Loads, loads_of

EMPTY = 1.1  # times what always hangs on its hooks: with less a crane carries nothing
SETTLED = 0.05  # last part of a stage over which its resting load is taken
Floats = NDArray[np.float64]


class StageUse(NamedTuple):
    """A stage with begin and end [s], governing rope and utilisation, dynamic factor of each crane; for a block its
    lowest point [m], smallest and largest tilt [rad], and centre of mass at the end [m]."""

    name: str
    start: float
    end: float
    rope: str
    use: float
    dynamic: dict[str, float]
    lowest: float | None = None
    tilt: tuple[float, float] | None = None
    com: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Facts:
    """A recording with its verdict, if any, and its plan as plain data."""

    rec: Recording
    verdict: RecordedVerdict | None
    plan: dict[str, Any] = field(repr=False)

    @cached_property
    def loads(self) -> Loads:
        """What lugs, slings and supports bore."""
        return loads_of(self.rec, self.plan)

    @cached_property
    def peaks(self) -> dict[str, Peak]:
        """Peak tension of each rope in its result."""
        return recorded_peaks(self.rec)

    @property
    def gravity(self) -> float:
        """[m/s2]"""
        return float(self.plan.get("gravity", 9.80665))

    @cached_property
    def _begins(self) -> list[tuple[float, str]]:
        """Begin of each stage [s], and its name."""
        return [(t, name) for t, name in self.rec.stages()]

    def stage_at(self, t: float) -> str:
        """Name of the stage at a time [s]."""
        return next((name for at, name in reversed(self._begins) if at <= t), "")

    @cached_property
    def stages(self) -> list[StageUse]:
        """All stages in order."""
        borne, tension = self.loads, self._tensions()
        end = tension.t[-1] if len(tension.t) else 0.0
        spans = pairwise([*((name, t) for t, name in self._begins), ("", end)])
        return [_of_block(self._stage(name, a, b, tension), borne) for (name, a), (_, b) in spans]

    def _tensions(self) -> Signal:
        """Tension of every rope; over sheaves that of its most loaded part."""
        signals = [self.rec.signal(name) for name in ("rope/tension", REEVING) if name in self.rec.signals()]
        found: dict[str, Floats] = {}
        for signal in signals:
            for i, column in enumerate(signal.names):
                name, x = reeved(column) if signal.name == REEVING else column, signal.values[:, i]
                found[name] = np.maximum(found[name], x) if name in found else x
        t = signals[0].t if signals else np.zeros(0)
        return Signal(t, np.column_stack([*found.values()]) if found else np.zeros((len(t), 0)), [*found], "N")

    def _stage(self, name: str, start: float, end: float, tension: Signal) -> StageUse:
        """Loads of a stage; cranes with empty hooks have no dynamic factor."""
        inside = (tension.t >= start) & (tension.t <= end)
        late, dynamic = inside & (tension.t >= end - SETTLED * (end - start)), {}
        rated = self.rec.fact("rated", {})
        most = {x: float(np.max(tension.values[inside, i], initial=0.0)) for i, x in enumerate(tension.names)}
        uses = {rope: most.get(rope, 0.0) / limit for rope, limit in rated.items()}
        rope = max(uses, key=lambda r: uses[r], default="")
        for crane in machines.cranes(self.plan):
            columns = [tension.names.index(rope) for rope in crane.dead if rope in tension.names]
            load, dead = tension.values[:, columns].sum(axis=1), sum(crane.dead.values())
            if late.any() and columns:
                rest = max(float(load[inside][0]), float(np.mean(load[late])))
                if rest > EMPTY * dead * self.gravity:
                    dynamic[crane.name] = float(np.max(load[inside])) / rest
        return StageUse(name, start, end, rope, uses.get(rope, 0.0), dynamic)


def facts(rec: Recording, verdict: RecordedVerdict | None = None) -> Facts:
    """Facts of a recording; `verdict`: replaces a missing one. Raises RecordingError for a DEVS model."""
    with rec.reading():
        if "model" in rec.run:
            raise RecordingError(
                f"{rec.path}: a DEVS model lifts nothing to report; `heavylift info` prints its results"
            )
        return Facts(rec, verdict or recorded_verdict(rec), machines.plan_of(rec.attachments))


def _of_block(stage: StageUse, borne: Loads) -> StageUse:
    """The same with the motion of the block."""
    inside = (borne.t >= stage.start) & (borne.t <= stage.end)
    if not inside.any():
        return stage
    tilt, com = borne.tilt[inside], borne.com[inside][-1]
    x, y, z = map(float, com)
    return stage._replace(
        lowest=float(borne.lowest[inside].min()), tilt=(float(tilt.min()), float(tilt.max())), com=(x, y, z)
    )
