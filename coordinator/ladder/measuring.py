"""Runs of candidates, each made once, and the differences between their requested figures.

These runs are sampled as densely as the evaluation of the figures requires; the integration steps do not depend on the
sampling.
"""

from collections.abc import Callable, Sequence
from math import inf
from typing import NamedTuple

import msgspec
from heavylift.coordinator.participants.compiling import Ahead, in_thread
from heavylift.coordinator.record.in_memory import CUT, Judge, play
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.plan.fidelity import Asked, Fidelity

from .figures import AskedFigure, figures, judged
from .model_levels import ModelLevel

DENSER, MOST = 4.0, 60_000  # times the samples, where a figure may be misread; at most of them in a run
WITNESSED = 2.0  # times the difference to its witness, a run may be wrong by
Errors = dict[str, float]  # relative, by figure
Key = tuple[Fidelity, str, float, float | None]  # of a candidate


class Spent(NamedTuple):
    """Time that a run has taken [s]: CPU time before the run and during it, and wall time from its beginning to its
    end."""

    start_s: float
    cpu_s: float
    wall_s: float


class Measuring:
    """Runs a plan at different model levels and time steps, each only once, and compares the figures of these runs."""

    def __init__(
        self, ask: Sequence[Asked], limit: Callable[[], float] = lambda: inf,
        say: Callable[[str], None] = lambda message: None, ahead: Ahead = in_thread,
    ) -> None:  # fmt: skip
        self.ask, self._limit, self._report, self._compile = ask, limit, say, ahead
        self.factor = 1.0  # times the samples of the scene
        self.spent: dict[Key, Spent] = {}
        self._samples = 0
        self._failed: dict[Key, HeavyliftError] = {}
        self._slack: dict[Key, frozenset[str]] = {}
        self._read: dict[Key, dict[str, AskedFigure]] = {}
        self._judges: dict[Key, Judge] = {}
        self._ahead: dict[Fidelity, Callable[[], None]] = {}

    @property
    def seen(self) -> dict[str, AskedFigure]:
        """All figures of the runs made so far, by name."""
        return {name: f for read in self._read.values() for name, f in read.items() if f.asked}

    def prepare(self, candidate: ModelLevel) -> None:
        """Begin to compile the machine code for a later run, while another run goes on."""
        if not any(key[0] == candidate.plan.fidelity for key in self.spent):
            self._ahead[candidate.plan.fidelity] = self._compile(candidate.plan)

    def figures(self, candidate: ModelLevel) -> dict[str, AskedFigure]:
        """Return the figures of a run at this model level and time step; raises HeavyliftError if the run failed."""
        return {name: f for name, f in self.all_figures(candidate).items() if f.asked}

    def all_figures(self, candidate: ModelLevel) -> dict[str, AskedFigure]:
        """Return also the figures of a run that are too small to count."""
        if candidate.key in self._failed:
            raise self._failed[candidate.key]
        if candidate.key not in self._read:
            self._ahead.pop(candidate.plan.fidelity, lambda: None)()
            dense = msgspec.structs.replace(candidate.plan, samples_hz=self.factor * candidate.plan.samples_hz)
            try:
                run = play(dense, self._limit())
            except HeavyliftError as error:
                # a run cut by the clock says nothing about the candidate, and may be repeated
                if CUT not in str(error):
                    self._failed[candidate.key] = error
                raise
            self.spent[candidate.key] = Spent(run.start_s, run.cpu_s, run.prepared_s + run.wall_s)
            self._slack[candidate.key] = run.slack
            self._read[candidate.key] = {f.name: f for f in figures(run, self.ask)}
            if candidate.plan.limits:
                self._judges[candidate.key] = run.judge
            self._samples = len(run.t)
            self._report(f"{candidate.name}: {run.cpu_s:.2g} s")
        return self._read[candidate.key]

    def limits(self, candidate: ModelLevel, values: bool = False) -> dict[str, AskedFigure]:
        """Return, by name, the utilisations and the smallest clearance of an earlier run of this candidate; empty if
        there was none."""
        judge = self._judges.get(candidate.key)
        return {f.name: f for f in judged(judge, values=values)} if judge else {}

    def slack(self, candidate: ModelLevel, hooks: bool = False) -> bool:
        """Return whether any rope (if `hooks`: any hook rope) goes slack in a run at this model level and time step."""
        self.figures(candidate)
        found = self._slack[candidate.key]
        return any(hook.rope in found for m in candidate.plan.machines for hook in m.hooks) if hooks else bool(found)

    def misread(self, candidate: ModelLevel) -> Errors:
        """Return the relative reading errors of a run's figures, which arise because values are read from samples."""
        return {f.name: f.misread / f.scale for f in self.figures(candidate).values()}

    def read_well(self, candidate: ModelLevel, accuracy: float) -> bool:
        """Return whether a run's samples are dense enough to read its figures; if not, discard all runs and raise
        the sample rate.

        They are if all reading errors are below a quarter of the accuracy, or if denser samples cannot help.
        """
        # a quarter: reading errors are added to the others
        if max(self.misread(candidate).values(), default=0.0) <= 0.25 * accuracy or DENSER * self._samples > MOST:
            return True
        self.factor *= DENSER
        self._read.clear()
        return False

    def apart(self, candidate: ModelLevel, other: ModelLevel) -> Errors:
        """Return the relative differences between the figures of two runs, infinite for a figure that only one of them
        has."""
        mine, others = self.all_figures(candidate), self.all_figures(other)
        return {
            name: abs(mine[name].value - others[name].value) / max(mine[name].scale, others[name].scale)
            # a figure that only one of two runs shows, such as of a rope that carries in one only, is not comparable
            if name in mine and name in others else inf
            for name in {**mine, **others}
            if any(name in found and found[name].asked for found in (mine, others))
        }  # fmt: skip


def added(*errors: Errors) -> Errors:
    """Return, for each figure, the sum of its errors in several tables of errors."""
    return {name: sum(e.get(name, 0.0) for e in errors) for name in dict.fromkeys(x for e in errors for x in e)}


def most(*errors: Errors) -> Errors:
    """Return, for each figure, the largest of its errors in several tables of errors."""
    return {name: max(e.get(name, 0.0) for e in errors) for name in dict.fromkeys(x for e in errors for x in e)}


def times(factor: float, errors: Errors) -> Errors:
    """Return the errors of all figures multiplied by a factor."""
    return {name: factor * e for name, e in errors.items()}


def largest(errors: Errors) -> float:
    """Return the largest of the errors of all figures."""
    return max(errors.values(), default=0.0)
