"""The verdict of a lift in a random sea or wind: each limit against a quantile of the largest values over many seeds.

A worker runs one seed and returns the largest value of each limit. Their quantile, with its bound at 95 % confidence as
an error beside that of the computation, is checked like the value of a single run. What has no number, such as a
collision or an unfinished lift, counts with the worst of all seeds.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial
from math import hypot, inf, isfinite
from statistics import fmean

import msgspec
from heavylift.coordinator.ladder.choosing import level_of
from heavylift.coordinator.supervision.pool import Pool, cores
from heavylift.kernel.description.findings import NOT_CHECKED, Check, finding
from heavylift.kernel.errors import SceneError
from heavylift.nodes.limits.checks import SEA_STATE, checks_of, error_of, line_of, sea_of, state_of, table_of
from heavylift.nodes.limits.messages import shown
from heavylift.nodes.plan.limit import RatedLimit, Use
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.sea.extremes import FEWEST, Extreme, extreme, part_of
from heavylift.recordings.sheets.sheet import Cell, Sheet, Table, columns

from .axes import Variant
from .variant import Row, Task, governing_uses, judged

HEADS = columns("check", "of", "quantile", "at most, 95 %", "mean", "largest", "in seed .0", "found by")
LISTED = 30  # limits in the table of quantiles


class SeedRun(msgspec.Struct, frozen=True):
    """Results of the run with one random seed: row of the study, utilisations of limits, findings."""

    row: Row
    uses: tuple[Use, ...] = ()
    findings: tuple[Check, ...] = ()


@dataclass(frozen=True)
class SeedsVerdict:
    """The verdict on quantiles of the results of runs with different random seeds."""

    quantile: str
    seeds: Sequence[int]
    runs: Sequence[SeedRun]
    checks: Sequence[Check]
    uses: Sequence[Use]  # by the bounds of the quantiles
    numbers: Sequence[tuple[Cell, ...]]

    @property
    def state(self) -> str:
        """The most severe state of all checks in all runs."""
        return state_of(self.checks)

    @property
    def row(self) -> Row:
        """The verdict over all seeds as a row of a study, without a digest."""
        state = self.state
        row: Row = {"status": "red" if state == "red" else "done", "sentence": "", "state": state}
        row |= {"verdict": line_of(self.checks), "use": float("nan"), "limit": ""}
        used = [(x.use, name, x.stage) for name, x in governing_uses(self.uses).items() if x.use is not None]
        row |= {f"use/{name}": use for use, name, _ in used}
        if used:
            row["use"], row["limit"], row["limit stage"] = max(used)
            row["limit at [s]"] = None
        return row

    def sheet(self, name: str) -> Sheet:
        """Return the checks and the quantiles as tables."""
        title = f"{name}: {self.quantile} over {len(self.seeds)} seeds"
        note = f"seeds {self.seeds[0]} to {self.seeds[-1]}; `heavylift run --set seed=N` records one of them"
        quantiles = Table(f"{self.quantile} of the largest values", HEADS, tuple(self.numbers[:LISTED]), (note,))
        return Sheet(title, line_of(self.checks), self.state, (table_of(self.checks), quantiles))


def replicated(
    scene: LoadedScene, count: int, seed: int = 1, limit_s: float = 60.0, executor: Executor | None = None
) -> SeedsVerdict:
    """Run a scene for `count` random seeds and return the verdict on the quantile that its waves require; raises
    SceneError."""
    check_seeds(scene, count)
    scene = level_of(scene)
    task, seeds = Task.of(scene, limit_s, "none", True), range(seed, seed + count)
    with Pool(min(count, cores())) if executor is None else nullcontext(executor) as pool:
        runs = over_seeds(task, (), seeds, pool)
    return verdict_of_seeds(scene, seeds, runs)


@dataclass(frozen=True)
class SeaRuns:
    """Runs of a scene for the same random seeds under varying settings, in one process pool."""

    scene: LoadedScene
    seeds: Sequence[int]
    limit_s: float
    pool: Executor

    def row(self, settings: Sequence[str]) -> Row:
        """Run the scene for all seeds; return the verdict as a row of the study, or the row of the first failed run."""
        runs = over_seeds(Task.of(self.scene, self.limit_s, "none", True), settings, self.seeds, self.pool)
        bad = [run.row for run in runs if run.row["status"] not in ("done", "red")]
        return bad[0] if bad else verdict_of_seeds(self.scene, self.seeds, runs).row


def over_seeds(task: Task, settings: Sequence[str], seeds: Sequence[int], pool: Executor) -> list[SeedRun]:
    """Run a scene with additional settings once for each of several random seeds, and return the results."""
    work = [Variant(i, (*settings, f"seed={seed}"), ()) for i, seed in enumerate(seeds)]
    futures = [pool.submit(seed_run, task, variant) for variant in work]
    return [msgspec.msgpack.decode(x.result(), type=SeedRun) for x in futures]


def seed_run(task: Task, variant: Variant) -> bytes:
    """Run a scene with one random seed and return its encoded results."""
    row, verdict = judged(task, variant)
    uses, found = list[Use](), tuple[Check, ...]()
    if verdict is not None:
        checks = verdict[0].checks
        found = tuple(x for x in checks if x.found and not x.allowed)
        near = [x for x in checks if x.quantity == "clearance" and x.value is not None and x.allowed]
        uses = [*verdict[1], *(_clearance(min(near, key=lambda x: x.value or 0.0)) if near else ())]
    run = SeedRun({key: x for key, x in row.items() if key in REPORTED}, tuple(uses), found)
    return msgspec.msgpack.encode(run, enc_hook=lambda number: number.item())


def _clearance(x: Check) -> Iterator[Use]:
    limit = RatedLimit(
        subject=x.subject, quantity="clearance", unit="m", value=x.limit, least=True, source=x.basis, where=x.where
    )
    yield replace(limit.met(x.value, x.t), stage=x.stage)


REPORTED = ("status", "sentence", "digest", "simulated [s]", "verdict")


def verdict_of_seeds(scene: LoadedScene, seeds: Sequence[int], runs: Sequence[SeedRun]) -> SeedsVerdict:
    """Return the verdict on the quantiles over the runs of all seeds; raises SceneError if a run gave no result."""
    for seed, run in zip(seeds, runs, strict=True):
        if run.row["status"] not in ("done", "red"):
            raise SceneError(f"--replications: seed {seed} {run.row['status']}: {run.row['sentence']}")
    waves = scene.scene.waves
    quantile, duration, ramp = (waves.quantile, waves.duration, waves.ramp) if waves else ("P90", None, 0.0)
    length = max(1.0, fmean(run.row["simulated [s]"] for run in runs) - ramp)
    name = quantile + (f" in {duration / 3600:g} h" if duration else "")
    find = partial(extreme, part=part_of(quantile, length, duration))
    uses, errors, rows = list[Use](), dict[str, float](), list[tuple[float, tuple[Cell, ...]]]()
    bounds = list[Use]()
    others, how = _together(seeds, runs), dict[tuple[str, str], str]()
    tables = [{_key(x.limit): x for x in run.uses} for run in runs]
    for key in (key for key in tables[0] if all(key in table for table in tables)):
        seen = [table[key] for table in tables]
        found, use = _quantile(seen, find)
        uses.append(use)
        bounds.append(
            use if use.use is None else replace(use, use=use.use + _share(use, found.above) * max(1.0, use.use))
        )
        if use.use is None:
            continue
        limit, known = use.limit, error_of(use, scene.errors)
        if known is not None or found.above > -use.excess > -found.above:  # else its error stays unknown
            shares = _share(use, known or 0.0, of_value=True), _share(use, found.above)
            errors[f"use of {limit.subject} {limit.quantity}"] = hypot(*shares)
        if not isfinite(found.above):
            message = f"{limit.quantity} of {limit.subject}: {found.how}"
            others.append(finding("amber", limit.quantity, limit.subject, message, why=NOT_CHECKED, value=use.value))
        how[limit.quantity, limit.subject] = found.how if found.above else ""
        rows.append((use.use, _row(seen, use, found, seeds)))
    state = f"{name} over {len(seeds)} seeds; limits are checked with its bound at 95 % confidence"
    state += f"; {sea}" if (sea := sea_of(scene.plan)) else ""
    others.append(Check(quantity=SEA_STATE, subject="all", state="green", shown=name, basis=state, sentence=state))
    checks = [_named(x, name, how) for x in checks_of(scene.plan, uses, others, errors, ())]
    return SeedsVerdict(name, seeds, runs, checks, bounds, [row for _, row in sorted(rows, key=lambda x: -x[0])])


def check_seeds(scene: LoadedScene, count: int) -> None:
    """Raise SceneError if nothing in the scene is random, or if there are too few seeds."""
    keys = scene.scene
    if not ((keys.waves and keys.waves.seas) or (keys.wind and keys.wind.turbulence)):
        raise SceneError("--replications: nothing in the scene depends on its seed; give 'waves: {seas: ...}'")
    if count < FEWEST:
        raise SceneError(
            f"--replications {count}: give {FEWEST} or more; with 30 seeds every P90 has a confidence bound"
        )


def _key(limit: RatedLimit) -> str:
    subject = "" if limit.quantity == "clearance" else limit.subject  # of any pair
    return f"{subject} {limit.quantity} {limit.over} {limit.inputs}"


def _size(x: Use) -> float:
    """Return the quantity of a limit that is largest in the worst case: the utilisation for a chart or a range, else
    the value (negative for a lower limit)."""
    if x.value is None or x.use is None:
        return -inf
    if x.bound is not None or x.limit.between is not None:
        return x.use
    return -x.value if x.limit.least else x.value


def _quantile(seen: Sequence[Use], find: Callable[[list[float]], Extreme]) -> tuple[Extreme, Use]:
    """Return the quantile of a limit, and the utilisation by it, in the stage of the seed that comes nearest to it."""
    sizes = [_size(x) for x in seen]
    found = find(sizes)
    if not any(isfinite(x) for x in sizes):
        return found, max(seen, key=lambda x: -inf if x.value is None else x.value)
    near = seen[min(range(len(seen)), key=lambda i: abs(sizes[i] - found.value) if isfinite(sizes[i]) else inf)]
    near, limit = replace(near, t=None), near.limit
    if found.value == -inf:
        return found, replace(near, value=None, use=None)
    if limit.between is not None:
        middle, half = sum(limit.between) / 2.0, (limit.between[1] - limit.between[0]) / 2.0
        side = 1.0 if (near.value or 0.0) >= middle else -1.0
        return found, replace(near, value=middle + side * half * found.value, use=found.value)
    if near.bound is not None:
        return found, replace(near, value=found.value * near.bound if near.bound else near.value, use=found.value)
    value = -found.value if limit.least else found.value
    return found, replace(near, value=value, use=limit.use(value))


def _share(use: Use, above: float, *, of_value: bool = False) -> float:
    """Return the distance of the confidence bound from the quantile, or an error in the unit of the limit if
    `of_value`, as a relative error of the utilisation, the form that `error_of` reads."""
    value, of = abs(use.value or 0.0), use.use or 0.0
    if not of_value and (use.limit.between is not None or use.bound is not None):
        share = above
    elif use.limit.between is not None:
        share = 2.0 * above / (use.limit.between[1] - use.limit.between[0])
    else:
        share = above * of / value if value and of else above / abs(use.limit.at() or 1.0)
    return share / max(1.0, of) if isfinite(of) and isfinite(share) else 0.0


def _together(seeds: Sequence[int], runs: Sequence[SeedRun]) -> list[Check]:
    """Return each finding once, with the number of seeds in which it occurs."""
    first, count = dict[tuple[str, str, str], tuple[int, Check]](), Counter[tuple[str, str, str]]()
    for seed, run in zip(seeds, runs, strict=True):
        for key, x in {(x.quantity, x.subject, x.state): x for x in run.findings}.items():
            first.setdefault(key, (seed, x))
            count[key] += 1
    return [
        msgspec.structs.replace(x, sentence=f"{x.sentence} (seed {seed}; in {count[key]} of {len(runs)} seeds)")
        for key, (seed, x) in first.items()
    ]


def _named(check: Check, quantile: str, how: Mapping[tuple[str, str], str]) -> Check:
    """Return a check with the name of the quantile in its value, and the method by which the quantile was found in its
    basis."""
    by = how.get((check.quantity, check.subject), "")
    if not by or not check.allowed:
        return check
    message = check.sentence
    if check.state in ("red", "undecided"):
        message = f"{message.partition('; an accuracy')[0]}; {quantile} by {by}"
    message += "; more seeds narrow its bound" if check.state == "undecided" else ""
    found = {"shown": f"{quantile} {check.shown}", "basis": f"{check.basis}; {by}", "sentence": message}
    return msgspec.structs.replace(check, **found)


def _row(seen: Sequence[Use], use: Use, found: Extreme, seeds: Sequence[int]) -> tuple[Cell, ...]:
    """Return a row of the table of quantiles; of a chart or a range, it shows utilisations in per cent."""
    limit, sizes = use.limit, [_size(x) for x in seen]
    relative = use.bound is not None or limit.between is not None

    def text(size: float) -> str:
        if not isfinite(size):
            return ""
        return f"{100.0 * size:.1f} %" if relative else shown(limit, -size if limit.least else size)

    finite = [x for x in sizes if isfinite(x)]
    cells = text(found.value), text(found.value + found.above), text(fmean(finite)), text(max(finite))
    return limit.quantity, limit.subject, *cells, seeds[sizes.index(max(finite))], found.how
