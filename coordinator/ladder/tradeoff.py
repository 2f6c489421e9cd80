"""The whole ladder of a scene as a table: cost and errors of each candidate; one sentence of advice.

Errors are differences to the finest model level, whose own errors are reported, too: those of its steps by looser ones,
that of its level by the coarser level before it. One run at a time on one core, without a recording; times are CPU
time.
"""

import shlex
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import ceil, inf

from heavylift.coordinator.record.in_memory import CUT
from heavylift.kernel.errors import HeavyliftError, SceneError
from heavylift.nodes.plan.fidelity import ASKABLE, MEANT, USUAL, Asked, percent
from heavylift.nodes.scene import LoadedScene

from .measuring import Errors, Measuring
from .model_levels import DECADE, Ladder, ModelLevel

REFERENCE = 3  # steps of the finest model level: so many times a tenth of the loosest


@dataclass(frozen=True)
class Row:
    """A row of the trade-off table: errors of all quantities and CPU time [s] at one model level and time step."""

    level: str
    how: str
    errors: dict[Asked, float]
    start_s: float = 0.0
    run_s: float = 0.0
    command: str = ""
    reason: str = ""  # why it could not run

    @property
    def worst(self) -> float:
        """The largest relative error of the requested quantities; infinite if the run failed."""
        return max(self.errors.values(), default=inf)

    def __str__(self) -> str:
        return f"{self.level}, {self.how}"


@dataclass(frozen=True)
class Held:
    """Numerical damping of two coupled bodies, each with its own solver, that exchange the coupling force every `h`
    [s]."""

    pair: str
    omega: float
    h: float
    measured: float  # damping ratio
    law: float  # damping ratio of theory
    one_percent: float  # `h` [s] with which the motion grows by 1 % during the run


@dataclass(frozen=True)
class Distributed:
    """Cost of running a scene in several processes.

    Placement of processes, benefit, simulated and wall seconds, seconds of the kernel and of start and end, CPU
    seconds, grants, recording size, digest.
    """

    where: str
    buys: str
    simulated_s: float
    wall_s: float
    kernel_s: float
    around_s: float
    cpu_s: float
    grants: int
    recorded_bytes: int
    digest: str

    @property
    def per_grant(self) -> float:
        """Wall time per grant [s] spent outside the kernel: on models, messages, waiting and recording."""
        return max(0.0, self.wall_s - self.around_s - self.kernel_s) / self.grants


@dataclass(frozen=True)
class MeasuredLadder:
    """Measured errors and run times of a scene at all model levels and time steps, and the recommended combination.

    Rows by level, cheapest first; the reference and its error; number of candidates that did not fit into the time
    budget; cost of processes.
    """

    scene: str
    ask: tuple[Asked, ...]
    limit: float
    budget: float
    spent: float
    rows: list[Row]
    pick: Row | None
    advice: str
    reference: str
    worth: dict[str, dict[Asked, float]]
    left_out: int
    held: list[Held] = field(default_factory=list)
    distributed: list[Distributed] = field(default_factory=list)


def measure(
    scene: LoadedScene, ask: str = "", limit: float | None = None, budget: float = 300.0,
    say: Callable[[str], None] = lambda message: None,
) -> MeasuredLadder:  # fmt: skip
    """Measure errors and run times of a scene at all model levels and time steps, within `budget` [s] of wall time.

    `ask`: quantities (default: those of the scene, else the usual ones); `limit` of their errors (default: the scene's
    accuracy, else 1 %).

    Raises SceneError for a quantity that cannot be requested, and for a budget too small for the finest model level.
    """
    began = time.perf_counter()
    wanted = _asked(ask, scene.facts.ask)
    limit = (scene.facts.accuracy if scene.facts.ask else USUAL) if limit is None else limit
    ladder = Ladder(scene.plan, [name for name in scene.facts.named if name == "method"])

    def left() -> float:
        return budget - (time.perf_counter() - began)

    measuring = Measuring(wanted, left, say)
    finest = ladder.candidates(ladder.full[-1])[::DECADE]
    true = finest[min(REFERENCE, len(finest) - 1)]
    try:
        while not measuring.read_well(true, limit):
            pass
    except HeavyliftError as error:
        if CUT not in str(error):
            raise
        message = f"--budget {budget:.3g} s: too little, a run of the finest model level takes longer"
        raise SceneError(
            f"{message}; give --budget {ceil(4.0 * budget):g} or more, or let the scene end earlier (--set end=...)"
        ) from None
    quantity = {f.name: f.quantity for f in measuring.figures(true).values()}
    if missing := [q for q in wanted if q not in quantity.values() and ask]:
        able = [q for q in dict.fromkeys(quantity.values())]
        raise SceneError(
            f"--ask '{missing[0]}': this run does not have that quantity; ask for {', '.join(able) or 'something else'}"
        )
    if not quantity:
        message = "its run has no quantity by which model levels can be compared, such as a rope tension"
        raise SceneError(f"{scene.path.name}: {message}")
    rows, out = list[Row](), 0
    for candidate in (
        r for level in ladder.compared for r in ladder.candidates(level)[::DECADE][: REFERENCE + 1] if r.key != true.key
    ):
        row = _row(scene, candidate, true, quantity, measuring) if left() > 0.0 else None
        out += row is None
        rows += [row] if row else []
    worth = _worth(ladder, true, finest, quantity, measuring)
    pick, advice = _advice(rows, limit)
    shown = tuple(q for q in wanted if q in quantity.values())
    return MeasuredLadder(
        scene.plan.name, shown, limit, budget, budget - left(), rows, pick, advice, true.name, worth, out
    )


def _asked(words: str, own: tuple[Asked, ...]) -> tuple[Asked, ...]:
    """Read quantities from a list such as "rope tension, swing"; raises SceneError for an unknown one."""
    wanted = [word.strip() for word in words.strip("[] ").split(",") if word.strip()]
    for word in wanted:
        if word not in ASKABLE:
            raise SceneError(f"--ask '{word}' is not a known quantity; ask for {', '.join(ASKABLE)}")
    return tuple(q for q in ASKABLE if q in (wanted or own or MEANT))


def _row(
    scene: LoadedScene, candidate: ModelLevel, true: ModelLevel, quantity: dict[str, Asked], measuring: Measuring
) -> Row | None:
    """Return the table row of a candidate; None if the time budget is used up before."""
    try:
        errors = _by(quantity, measuring.apart(candidate, true))
    except HeavyliftError as error:
        return (
            None if CUT in str(error) else Row(candidate.level, candidate.how, {}, reason=" ".join(str(error).split()))
        )
    spent = measuring.spent[candidate.key]
    sets = [x for setting in (*scene.settings, *candidate.settings) for x in ("--set", setting)]
    command = shlex.join(["heavylift", "run", scene.typed, *sets])
    return Row(candidate.level, candidate.how, errors, spent.start_s, spent.cpu_s, command)


def _by(quantity: dict[str, Asked], errors: Errors) -> dict[Asked, float]:
    """Return the largest error of each quantity."""
    return {
        q: max((e for name, e in errors.items() if quantity.get(name) == q), default=inf)
        for q in dict.fromkeys(quantity.values())
    }


def _worth(
    ladder: Ladder, true: ModelLevel, finest: Sequence[ModelLevel], quantity: dict[str, Asked], measuring: Measuring
) -> dict[str, dict[Asked, float]]:
    """Return the step error and level error of the reference, as far as the runs that measure them were made."""
    looser = finest[max(0, min(REFERENCE, len(finest) - 1) - 1)]
    others = {"its steps": looser} | ({"its level": true.on(ladder.poorer)} if ladder.poorer else {})
    known = {
        what: candidate
        for what, candidate in others.items()
        if candidate.key in measuring.spent and candidate.key != true.key
    }
    return {what: _by(quantity, measuring.apart(true, candidate)) for what, candidate in known.items()}


def _advice(rows: Sequence[Row], limit: float) -> tuple[Row | None, str]:
    """Return the cheapest row within the limit, and a sentence that recommends it and names the next cheaper one."""
    passing = sorted((r for r in rows if r.worst <= limit), key=lambda r: r.run_s)
    if not passing:
        best = min(rows, key=lambda r: r.worst, default=None)
        near = f"; the nearest is {best}: {percent(best.worst)}" if best and best.worst < inf else ""
        return None, f"None of {len(rows)} candidates keeps {percent(limit)}{near}."
    pick = passing[0]
    message = (
        f"Use {pick}: {pick.run_s:.2g} s of the kernel, worst error {percent(pick.worst)} (limit {percent(limit)})"
    )
    cheaper = [r for r in rows if r.run_s < pick.run_s and limit < r.worst < inf]
    after = max(cheaper, key=lambda r: r.run_s, default=None)
    return pick, message + (f"; {after}, {after.run_s:.2g} s, fails by {percent(after.worst)}." if after else ".")
