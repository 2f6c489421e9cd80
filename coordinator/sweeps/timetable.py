"""Two timings of a lift beside each other: how long each stage takes, and what limits it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from heavylift.coordinator.ladder.in_memory import Played
from heavylift.nodes.models.parts.messages import Done
from heavylift.nodes.plan.actions import Action, Wait
from heavylift.nodes.scene import LoadedScene
from heavylift.recordings.sheets.sheet import Cell, Table, columns
from heavylift.recordings.sheets.terminal import table_text

from .timing import Step

HEADS = columns("stage", "before [h:min:s] .0", "after [h:min:s] .0", "what limits it")
Parts = dict[Step, float]  # how far each step is taken, of 1


@dataclass(frozen=True)
class FoundTiming:
    """A timing that was found: the scene before and after, its runs, how far each step is taken and what limits it;
    `wrong`: why there is none."""

    before: LoadedScene
    run_before: Played | None
    after: LoadedScene | None = None
    run_after: Played | None = None
    parts: Parts = field(default_factory=dict)
    why: Mapping[Step, str] = field(default_factory=dict)
    wrong: str = ""

    @property
    def gain(self) -> float:
        """How much sooner the last move ends [s]."""
        if self.run_before is None or self.run_after is None:
            return 0.0
        return done(self.run_before) - done(self.run_after)

    @property
    def told(self) -> list[str]:
        """Lines for people: the stages before and after, and the verdict."""
        assert self.run_before is not None
        assert self.run_after is not None
        ends = [done(run) for run in (self.run_before, self.run_after)]
        rows: list[tuple[Cell, ...]] = [*self.rows, ("all moves are done", *ends, f"{self.gain / ends[0]:.0%} sooner")]
        return [table_text(Table("Timing", HEADS, tuple(rows))), self.run_after.verdict.line]

    def data(self) -> dict[str, object]:
        """As plain data, SI units."""
        assert self.run_before is not None
        assert self.run_after is not None
        keys = ("stage", "before", "after", "why")
        return {
            "before": done(self.run_before),
            "after": done(self.run_after),
            "stages": [dict(zip(keys, row, strict=True)) for row in self.rows],
            "verdict": self.run_after.verdict.line,
            "digest": self.run_after.digest,
        }

    @property
    def rows(self) -> Iterator[tuple[str, float, float, str]]:
        """Of each stage: name, how long it takes before and after until the next begins [s], what limits it."""
        assert self.run_before is not None
        assert self.run_after is not None
        after = {number: lasts for number, _, lasts in _stages(self.run_after)}
        for number, name, lasts in _stages(self.run_before):
            told = [x for step, x in self.why.items() if step.action == number]
            yield name, lasts, after.get(number, 0.0), "; ".join(dict.fromkeys(told))


def last_wait(actions: Sequence[Action]) -> int:
    """The number of the first of the waits at the end."""
    n = len(actions)
    while n and all(isinstance(order, Wait) for order in actions[n - 1].orders):
        n -= 1
    return n


def _stages(run: Played) -> Iterator[tuple[int, str, float]]:
    """Number of the action, name and duration of each stage [s]."""
    ends = [t for t, _, _ in run.conduct.stages[1:]] + [run.end_ns * 1e-9]
    for (t, number, name), end in zip(run.conduct.stages, ends, strict=True):
        yield number, name, end - t


def done(run: Played) -> float:
    """When the last move of a run is done [s]."""
    return max((e.t for e in run.events if isinstance(e.value, Done)), default=0) * 1e-9
