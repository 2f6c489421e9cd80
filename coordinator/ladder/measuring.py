"""Runs of candidates, each made once, and the differences between their requested figures.

These runs are sampled as densely as the evaluation of the figures requires; the integration steps do not depend on the
sampling.
"""

from collections.abc import Callable, Sequence
from math import inf

import msgspec
from heavylift.coordinator.record.in_memory import CUT, play
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.plan.fidelity import Asked, Fidelity
from heavylift.nodes.plan.plan import Plan

from .beside import ALONE, Beside, Seen, Spent
from .figures import AskedFigure
from .model_levels import ModelLevel

DENSER, MOST = 4.0, 60_000  # times the samples, where a figure may be misread; at most of them in a run
WITNESSED = 2.0  # times the difference to its witness, a run may be wrong by
Errors = dict[str, float]  # relative, by figure
Key = tuple[Fidelity, str, float, float | None]  # of a candidate


class Measuring:
    """Runs a plan at different model levels and time steps, each only once, and compares the figures of these runs."""

    def __init__(
        self, ask: Sequence[Asked], limit: Callable[[], float] = lambda: inf,
        say: Callable[[str], None] = lambda message: None, beside: Beside = ALONE,
    ) -> None:  # fmt: skip
        self.ask, self._limit, self._report, self._beside = ask, limit, say, beside
        self.factor = 1.0  # times the samples of the scene
        self._samples = 0
        self._failed: dict[Key, HeavyliftError] = {}
        self._seen: dict[Key, Seen] = {}
        self._read: dict[Key, dict[str, AskedFigure]] = {}

    @property
    def spent(self) -> dict[Key, Spent]:
        """The time that each run has taken."""
        return {key: seen.spent for key, seen in self._seen.items()}

    @property
    def seen(self) -> dict[str, AskedFigure]:
        """All figures of the runs made so far, by name."""
        return {name: f for read in self._read.values() for name, f in read.items() if f.asked}

    def prepare(self, candidate: ModelLevel) -> None:
        """Begin to compile the machine code for a later run beside, while another run goes on."""
        if not any(key[0] == candidate.plan.fidelity for key in self._seen):
            self._beside.compile(candidate.plan)

    def begin(self, candidate: ModelLevel) -> bool:
        """Begin a later run beside, unless wall time is limited; return whether it runs there."""
        known = candidate.key in {**self._read, **self._failed} or self._limit() < inf
        return not known and self._beside.run(self._dense(candidate), self.ask)

    def _dense(self, candidate: ModelLevel) -> Plan:
        return msgspec.structs.replace(candidate.plan, samples_hz=self.factor * candidate.plan.samples_hz)

    def figures(self, candidate: ModelLevel) -> dict[str, AskedFigure]:
        """Return the figures of a run at this model level and time step; raises HeavyliftError if the run failed."""
        return {name: f for name, f in self.all_figures(candidate).items() if f.asked}

    def all_figures(self, candidate: ModelLevel) -> dict[str, AskedFigure]:
        """Return also the figures of a run that are too small to count."""
        if candidate.key in self._failed:
            raise self._failed[candidate.key]
        if candidate.key not in self._read:
            dense = self._dense(candidate)
            try:
                seen = self._beside.seen(dense) or self._run(dense)
            except HeavyliftError as error:
                # a run cut by the clock says nothing about the candidate, and may be repeated
                if CUT not in str(error):
                    self._failed[candidate.key] = error
                raise
            self._seen[candidate.key], self._samples = seen, seen.samples
            self._read[candidate.key] = {f.name: f for f in seen.figures}
            self._report(f"{candidate.name}: {seen.spent.cpu_s:.2g} s")
        return self._read[candidate.key]

    def _run(self, plan: Plan) -> Seen:
        self._beside.compiled(plan)
        return Seen.of(play(plan, self._limit()), self.ask)

    def limits(self, candidate: ModelLevel, values: bool = False) -> dict[str, AskedFigure]:
        """Return, by name, the utilisations and the smallest clearance of an earlier run of this candidate; empty if
        there was none."""
        seen = self._seen.get(candidate.key)
        return {f.name: f for f in seen.limits(values)} if seen else {}

    def slack(self, candidate: ModelLevel, hooks: bool = False) -> bool:
        """Return whether any rope (if `hooks`: any hook rope) goes slack in a run at this model level and time step."""
        self.figures(candidate)
        found = self._seen[candidate.key].slack
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
