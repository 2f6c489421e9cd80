"""Which setting to use: for which one waits least of all that keep every error asked for within the limit, and the next
faster that fails.  Of those that differ by less than their timings are worth, the most exact.

Pure functions of the table, whose rows are what was measured.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf

from heavylift.nodes.plan.fidelity import Asked

LIMITS = (0.1, 0.05, 0.01, 1e-3, 1e-4, 1e-5, 1e-6)  # to which each quantity alone is judged
NOISE = 0.1  # relative difference of times that says nothing, or their spread if that is more


@dataclass(frozen=True)
class Row:
    """One setting: errors of what was asked, relative (empty if the run failed, then `reason` says why), the largest
    distance of a place from the true one [m or rad], seconds (`start_s`: of CPU time before the run, compiled code kept
    from before), `spread` of the CPU times of `runs` repetitions, and what the kernel had to say."""

    rung: str
    method: str
    how: str
    errors: dict[Asked, float]
    reason: str = ""
    position: float = 0.0
    simulated_s: float = 0.0
    start_s: float = 0.0
    wall_s: float = 0.0
    cpu_s: float = 0.0
    messages: int = 0
    energy: float = 0.0
    drift: float | None = None
    runs: int = 1
    spread: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def waits_s(self) -> float:
        """Time that a user waits on a core of its own: start and run [s]."""
        return self.start_s + self.cpu_s

    @property
    def speed(self) -> float:
        """Real-time factor: simulated seconds per second that a user waits."""
        return self.simulated_s / self.waits_s if self.waits_s > 0.0 else 0.0

    def faster(self, other: Row) -> bool:
        """Whether one waits less by more than noise."""
        return self.waits_s * (1.0 + max(NOISE, self.spread, other.spread)) < other.waits_s

    @property
    def worst(self) -> float:
        """The largest error of what was asked; infinite for a run that failed."""
        return inf if self.reason else max(self.errors.values(), default=inf)

    def passes(self, limit: float) -> bool:
        """Whether every quantity asked is right within the limit."""
        return self.worst <= limit

    def __str__(self) -> str:
        return f"{self.rung}, {self.method} at {self.how}"


@dataclass(frozen=True)
class Verdict:
    """The row to use and the slowest of the faster ones that fail; None: there is none.  `sentence`: the answer;
    `more`: what takes as long, and what fails next."""

    pick: Row | None
    next_faster: Row | None
    sentence: str
    more: str = ""


def judge(rows: list[Row], limit: float, unit: str = "m") -> Verdict:
    """The verdict on a table for one limit of all quantities; `unit` of places."""
    passing = [row for row in rows if row.passes(limit)]
    if not passing:
        best = min(rows, key=lambda row: row.worst, default=None)
        told = f"; the nearest is the setting {best}: {_told(best, limit, unit)}" if best and best.worst < inf else ""
        return Verdict(None, None, f"None of {len(rows)} settings keeps {percent(limit)}{told}.")
    fastest = min(passing, key=lambda row: row.waits_s)
    equal = [row for row in passing if not fastest.faster(row)]
    pick = min(equal, key=lambda row: row.worst)
    failing = [row for row in rows if not row.reason and not row.passes(limit) and row.faster(pick)]
    following = max(failing, key=lambda row: row.waits_s, default=None)
    waits = f"{_seconds(pick.waits_s)} to wait, {_seconds(pick.start_s)} of them to start"
    sentence = f"Use the setting {pick}: {waits}, {_told(pick, limit, unit)}."
    more = f"{len(equal) - 1} more keep {percent(limit)} in a time equal within noise. " if len(equal) > 1 else ""
    if following is None:
        more += "No faster setting fails: a looser one may do."
    else:
        why = ", ".join(f"{quantity} {percent(e)}" for quantity, e in following.errors.items() if e > limit)
        more += f"Next faster setting that fails: {following}, {_seconds(following.waits_s)} ({why})."
    return Verdict(pick, following, sentence, more)


def front(rows: list[Row]) -> list[Row]:
    """Rows that no other beats in both speed and worst error (Pareto), the most exact first."""
    out: list[Row] = []
    for row in sorted((r for r in rows if r.worst < inf), key=lambda r: (r.worst, r.waits_s)):
        if not out or row.waits_s < out[-1].waits_s:
            out.append(row)
    return out


def percent(x: float) -> str:
    """A relative number as people read it."""
    if x == inf:
        return "never comes to it"
    return f"{100 * x:.2g} %" if x < 0.995 else f"{100 * x:.0f} %"


def _told(row: Row, limit: float, unit: str) -> str:
    (first, error), *rest = sorted(row.errors.items(), key=lambda item: -item[1])
    told = [f"worst {first} error {percent(error)} (limit {percent(limit)})"]
    told += [f"{quantity} {percent(e)}" for quantity, e in rest]
    scale, small = (1e3, f"m{unit}") if unit in ("m", "rad") else (1.0, unit)
    return ", ".join([*told, f"places within {row.position * scale:.3g} {small}"])


def _seconds(x: float) -> str:
    return f"{x:.2g} s" if x < 100.0 else f"{x:.0f} s"


@dataclass(frozen=True)
class Answer:
    """The fastest setting that keeps one quantity within a limit, with that error alone; None if none does."""

    quantity: Asked
    limit: float
    row: Row | None


def answers(ask: Sequence[Asked], rows: Sequence[Row]) -> Iterator[Answer]:
    """The verdict on every quantity asked alone, loosest limit first."""
    for quantity in ask:
        alone = [replace(r, errors={q: e for q, e in r.errors.items() if q == quantity}) for r in rows]
        for limit in LIMITS:
            yield Answer(quantity, limit, judge(alone, limit).pick)
