"""The whole ladder of a scene as a table: what each rung costs, and what it is wrong by; one sentence of advice.

Errors are differences to the finest rung, whose own are told beside it: its steps by looser ones, its level by the
poorer one before it.  One run at a time on one core, without a recording; times are CPU time.
"""

from __future__ import annotations

import shlex
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import ceil, inf

from heavylift.kernel.errors import HeavyliftError, SceneError
from heavylift.nodes.plan.fidelity import ASKABLE, MEANT, USUAL, Asked, percent
from heavylift.nodes.scene import LoadedScene

from .in_memory import CUT
from .measuring import Errors, Measuring
from .model_levels import DECADE, Ladder, ModelLevel

REFERENCE = 3  # steps of the finest rung: so many times a tenth of the loosest


@dataclass(frozen=True)
class Row:
    """One rung: largest relative error of each quantity, empty if it made no run, then `reason` says why; CPU seconds
    to start and to run; what a user types to run the scene so."""

    level: str
    how: str
    errors: dict[Asked, float]
    start_s: float = 0.0
    run_s: float = 0.0
    command: str = ""
    reason: str = ""

    @property
    def worst(self) -> float:
        """The largest error of what was asked; infinite without a run."""
        return max(self.errors.values(), default=inf)

    def __str__(self) -> str:
        return f"{self.level}, {self.how}"


@dataclass(frozen=True)
class Held:
    """A pair with forces held over `h` [s]: damping ratio as measured and by its law, and the h [s] that would let the
    amplitude grow by 1 % over the run of the scene."""

    pair: str
    omega: float
    h: float
    measured: float
    law: float
    one_percent: float


@dataclass(frozen=True)
class Distributed:
    """A run of the product: where, and what that buys; simulated and wall seconds, of which the kernel's and those of
    starting and leaving, and of processors; grants, each answered by one DONE; size of the recording; digest."""

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
        """Wall seconds between grants that are no work of the kernel: models, messages, waiting, recording."""
        return max(0.0, self.wall_s - self.around_s - self.kernel_s) / self.grants


@dataclass(frozen=True)
class MeasuredLadder:
    """All that is told of a scene: rows, cheapest first in each level; the reference and what it is worth; the advice;
    how many rungs did not fit into the budget; what processes would cost."""

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
    say: Callable[[str], None] = lambda told: None,
) -> MeasuredLadder:  # fmt: skip
    """Measure a scene within `budget` seconds; `ask`: quantities, by default the scene's own or the usual ones; `limit`
    of their errors: by default the scene's accuracy if it asks, else 1 %.

    Raises SceneError for what cannot be asked of it, and for a budget that is too small for the finest rung.
    """
    began = time.perf_counter()
    wanted = _asked(ask, scene.facts.ask)
    limit = (scene.facts.accuracy if scene.facts.ask else USUAL) if limit is None else limit
    ladder = Ladder(scene.plan, [name for name in scene.facts.named if name == "method"])

    def left() -> float:
        return budget - (time.perf_counter() - began)

    measuring = Measuring(wanted, left, say)
    finest = ladder.rungs(ladder.full[-1])[::DECADE]
    true = finest[min(REFERENCE, len(finest) - 1)]
    try:
        while not measuring.read_well(true, limit):
            pass
    except HeavyliftError as error:
        if CUT not in str(error):
            raise
        told = f"--budget {budget:.3g} s: too small, the finest rung does not come to its end"
        raise SceneError(
            f"{told}; give it {ceil(4.0 * budget):g} s or more, or a scene that ends earlier (--set end=...)"
        ) from None
    quantity = {f.name: f.quantity for f in measuring.figures(true).values()}
    if missing := [q for q in wanted if q not in quantity.values() and ask]:
        able = [q for q in dict.fromkeys(quantity.values())]
        raise SceneError(f"--ask '{missing[0]}': the run shows none; ask {', '.join(able) or 'something else'}")
    if not quantity:
        raise SceneError(f"{scene.path.name}: nothing in it moves that a rung could be judged by")
    rows, out = list[Row](), 0
    for rung in (
        r for level in ladder.full for r in ladder.rungs(level)[::DECADE][: REFERENCE + 1] if r.key != true.key
    ):
        row = _row(scene, rung, true, quantity, measuring) if left() > 0.0 else None
        out += row is None
        rows += [row] if row else []
    worth = _worth(ladder, true, finest, quantity, measuring)
    pick, advice = _advice(rows, limit)
    shown = tuple(q for q in wanted if q in quantity.values())
    return MeasuredLadder(
        scene.plan.name, shown, limit, budget, budget - left(), rows, pick, advice, true.name, worth, out
    )


def _asked(words: str, own: tuple[Asked, ...]) -> tuple[Asked, ...]:
    """The quantities of a list such as "rope tension, swing"; SceneError for one that does not exist."""
    wanted = [word.strip() for word in words.strip("[] ").split(",") if word.strip()]
    for word in wanted:
        if word not in ASKABLE:
            raise SceneError(f"--ask '{word}': a scene cannot be asked this; ask {', '.join(ASKABLE)}")
    return tuple(q for q in ASKABLE if q in (wanted or own or MEANT))


def _row(
    scene: LoadedScene, rung: ModelLevel, true: ModelLevel, quantity: dict[str, Asked], measuring: Measuring
) -> Row | None:
    """The row of a rung; None if the budget ends before its run does."""
    try:
        errors = _by(quantity, measuring.apart(rung, true))
    except HeavyliftError as error:
        return None if CUT in str(error) else Row(rung.level, rung.how, {}, reason=" ".join(str(error).split()))
    spent = measuring.spent[rung.key]
    sets = [x for setting in (*scene.settings, *rung.settings) for x in ("--set", setting)]
    command = shlex.join(["heavylift", "run", scene.typed, *sets])
    return Row(rung.level, rung.how, errors, spent.start_s, spent.cpu_s, command)


def _by(quantity: dict[str, Asked], errors: Errors) -> dict[Asked, float]:
    """The largest error of each quantity."""
    return {
        q: max((e for name, e in errors.items() if quantity.get(name) == q), default=inf)
        for q in dict.fromkeys(quantity.values())
    }


def _worth(
    ladder: Ladder, true: ModelLevel, finest: Sequence[ModelLevel], quantity: dict[str, Asked], measuring: Measuring
) -> dict[str, dict[Asked, float]]:
    """What the reference itself changed by, where these runs were made."""
    looser = finest[max(0, min(REFERENCE, len(finest) - 1) - 1)]
    others = {"its steps": looser} | ({"its level": true.on(ladder.poorer)} if ladder.poorer else {})
    known = {what: rung for what, rung in others.items() if rung.key in measuring.spent and rung.key != true.key}
    return {what: _by(quantity, measuring.apart(true, rung)) for what, rung in known.items()}


def _advice(rows: Sequence[Row], limit: float) -> tuple[Row | None, str]:
    """The cheapest row that keeps the limit, in a sentence, and the next cheaper one that does not."""
    passing = sorted((r for r in rows if r.worst <= limit), key=lambda r: r.run_s)
    if not passing:
        best = min(rows, key=lambda r: r.worst, default=None)
        near = f"; the nearest is {best}: {percent(best.worst)}" if best and best.worst < inf else ""
        return None, f"None of {len(rows)} rungs keeps {percent(limit)}{near}."
    pick = passing[0]
    told = f"Use {pick}: {pick.run_s:.2g} s of the kernel, worst error {percent(pick.worst)} (limit {percent(limit)})"
    cheaper = [r for r in rows if r.run_s < pick.run_s and limit < r.worst < inf]
    after = max(cheaper, key=lambda r: r.run_s, default=None)
    return pick, told + (f"; {after}, {after.run_s:.2g} s, fails by {percent(after.worst)}." if after else ".")
