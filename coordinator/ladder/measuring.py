"""Runs of rungs, each once, and how far two are apart in the figures that are asked.

The samples of these runs are as dense as the figures that are read from them need; the steps do not depend on them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from typing import NamedTuple

import msgspec
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.plan.fidelity import Asked, Fidelity

from .figures import AskedFigure, figures
from .in_memory import CUT, play
from .model_levels import ModelLevel

DENSER, MOST = 4.0, 60_000  # times the samples, where a figure may be misread; at most of them in a run
WITNESSED = 2.0  # times the difference to its witness, a run may be wrong by
Errors = dict[str, float]  # relative, by figure
Key = tuple[Fidelity, str, float, float | None]  # of a rung


class Spent(NamedTuple):
    """What a run took [s]: of CPU time before it and in it, of wall time from its begin to its end."""

    start_s: float
    cpu_s: float
    wall_s: float


class Measuring:
    """Runs of the rungs of one plan.  `limit`: seconds that each may take, by the clock when it begins."""

    def __init__(
        self, ask: Sequence[Asked], limit: Callable[[], float] = lambda: inf,
        say: Callable[[str], None] = lambda told: None,
    ) -> None:  # fmt: skip
        self.ask, self._limit, self._say = ask, limit, say
        self.factor = 1.0  # times the samples of the scene
        self.spent: dict[Key, Spent] = {}
        self._samples = 0
        self._failed: dict[Key, HeavyliftError] = {}
        self._slackening: dict[Key, bool] = {}
        self._read: dict[Key, dict[str, AskedFigure]] = {}
        self.limits: dict[Key, dict[str, AskedFigure]] = {}  # uses of limits, of each rung that was run

    @property
    def seen(self) -> dict[str, AskedFigure]:
        """Figures that any run has shown."""
        return {name: f for read in self._read.values() for name, f in read.items()}

    def figures(self, rung: ModelLevel) -> dict[str, AskedFigure]:
        """Of the run of a rung; raises HeavyliftError if it has none."""
        if rung.key in self._failed:
            raise self._failed[rung.key]
        if rung.key not in self._read:
            dense = msgspec.structs.replace(rung.plan, samples_hz=self.factor * rung.plan.samples_hz)
            try:
                run = play(dense, self._limit())
            except HeavyliftError as error:
                if CUT not in str(error):
                    self._failed[rung.key] = error
                raise
            self.spent[rung.key] = Spent(run.start_s, run.cpu_s, run.prepared_s + run.wall_s)
            self._slackening[rung.key] = run.slackens
            self._read[rung.key] = {f.name: f for f in figures(run, self.ask)}
            self.limits[rung.key] = (
                {f.name: f for f in figures(run, ["limits", "clearance"])} if rung.plan.limits else {}
            )
            self._samples = len(run.t)
            self._say(f"{rung.name}: {run.cpu_s:.2g} s")
        return self._read[rung.key]

    def slackens(self, rung: ModelLevel) -> bool:
        """Whether a hook rope does in the run of a rung."""
        self.figures(rung)
        return self._slackening[rung.key]

    def misread(self, rung: ModelLevel) -> Errors:
        """What the figures of a rung may be misread by."""
        return {f.name: f.misread / f.scale for f in self.figures(rung).values()}

    def read_well(self, rung: ModelLevel, accuracy: float) -> bool:
        """Whether no figure may be misread by more than a quarter of an accuracy; else, as long as denser samples can
        help, all is to be run again with them."""
        if max(self.misread(rung).values(), default=0.0) <= 0.25 * accuracy or DENSER * self._samples > MOST:
            return True
        self.factor *= DENSER
        self._read.clear()
        return False

    def apart(self, rung: ModelLevel, other: ModelLevel) -> Errors:
        """Relative differences; infinite of what only one of them shows."""
        mine, others = self.figures(rung), self.figures(other)
        return {
            name: abs(mine[name].value - others[name].value) / max(mine[name].scale, others[name].scale)
            if name in mine and name in others else inf
            for name in {**mine, **others}
        }  # fmt: skip


def added(*errors: Errors) -> Errors:
    """The sum of several, figure by figure."""
    return {name: sum(e.get(name, 0.0) for e in errors) for name in dict.fromkeys(x for e in errors for x in e)}


def most(*errors: Errors) -> Errors:
    """The largest of several, figure by figure."""
    return {name: max(e.get(name, 0.0) for e in errors) for name in dict.fromkeys(x for e in errors for x in e)}


def times(factor: float, errors: Errors) -> Errors:
    """So many times as much."""
    return {name: factor * e for name, e in errors.items()}


def largest(errors: Errors) -> float:
    """Of all figures."""
    return max(errors.values(), default=0.0)
