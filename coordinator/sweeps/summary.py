"""Statistics of the rows of a study: counts by status, limits, and the effect of each input on each result.

Also the sampling designs, as quantiles, and the sensitivity indices from them: with SALib, from the extra `sweep`.

sobol   Saltelli's extension of a Sobol sequence: base rows A and B, and A with each column of B.  Gives first and total
        indices; A and B alone are independent draws.                          Saltelli et al. (2010)
lhs     a Latin hypercube; gives first indices by random balance designs.       Tarantola, Gatelli, Mara (2006)
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import nan

import numpy as np
from heavylift.kernel.errors import SceneError
from heavylift.nodes.plan.fidelity import percent
from numpy.typing import NDArray

from .study import INPUT, RESPONSE, Study

FEWEST = {"sobol": 16, "lhs": 100}  # rows that say something of an index: ten harmonics need several each
DESIGNS = tuple(FEWEST)
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Index:
    """First-order and total sensitivity index of an axis, with half-widths of their 95 % intervals."""

    axis: str
    first: float
    first_half: float
    total: float
    total_half: float


def drawn(design: str, count: int, axes: int, seed: int) -> Floats:
    """Return at most `count` sample points (count, axes), quantiles in (0, 1); raises SceneError if `count` is too
    small."""
    if design not in DESIGNS:
        raise SceneError(f"--design '{design}' is not a known design; choose {' or '.join(DESIGNS)}")
    problem = _problem([str(i) for i in range(axes)])
    if design == "lhs":
        from SALib.sample import latin

        return np.asarray(latin.sample(problem, count, seed=seed), np.float64)
    base = 1 << max(0, (count // (axes + 2)).bit_length() - 1)
    if count < axes + 2:
        raise SceneError(f"--sample {count}: a Sobol design of {axes} inputs needs at least {axes + 2} runs")
    from SALib.sample import sobol

    return np.asarray(sobol.sample(problem, base, calc_second_order=False, seed=seed), np.float64)


def base_rows(design: str, count: int, axes: int) -> Floats:
    """Return which rows of a sample (count,) are independent draws; a Sobol design also contains dependent ones."""
    independent = np.ones(count, bool)
    if design == "sobol":
        block = np.arange(count) % (axes + 2)
        independent = (block == 0) | (block == axes + 1)
    return independent


def indices(design: str, axes: Sequence[str], quantiles: Floats, result: Floats, seed: int) -> list[Index]:
    """Return the sensitivity indices of a result, largest total index first; empty if the result is constant or
    incomplete."""
    if (
        len(result) < FEWEST[design]
        or not np.isfinite(result).all()
        or not np.ptp(result) > 1e-12 * np.abs(result).max()
    ):
        return []
    problem = _problem(axes)
    if design == "sobol":
        from SALib.analyze import sobol

        scaled = (result - result.mean()) / result.std()
        found = sobol.analyze(problem, scaled, calc_second_order=False, seed=seed)
        rows = zip(axes, found["S1"], found["S1_conf"], found["ST"], found["ST_conf"], strict=True)
    else:
        from SALib.analyze import rbd_fast

        found = rbd_fast.analyze(problem, quantiles, result, seed=seed)
        rows = zip(axes, found["S1"], found["S1_conf"], [nan] * len(axes), [nan] * len(axes), strict=True)
    listed = [Index(name, *(float(x) for x in numbers)) for name, *numbers in rows]
    return sorted(listed, key=lambda x: -(x.first if x.total != x.total else x.total))


def _problem(axes: Sequence[str]) -> dict[str, object]:
    try:
        import SALib  # noqa: F401
    except ImportError:
        raise SceneError("--sample needs SALib; install heavylift[sweep]") from None
    return {"num_vars": len(axes), "names": list(axes), "bounds": [[0.0, 1.0]] * len(axes)}


RESULTS = {
    "use": "largest use of a load's limit",
    "clearance [m]": "smallest clearance [m]",
    "off-lead [deg]": "largest angle of a hook's rope [deg]",
}
LEVEL = 0.95


def result_label(name: str) -> str:
    """Return the label of a result: a column of `RESULTS`, or a response by its own name."""
    return RESULTS.get(name) or name.removeprefix(RESPONSE)


@dataclass(frozen=True)
class Chance:
    """Statistics of the utilisation of one limit over the variants of a study.

    Number of checked variants, mean and maximum utilisation, number and fraction of variants beyond the limit, and for
    independent draws the 95 % interval of this fraction.
    """

    limit: str
    judged: int
    mean: float
    most: float
    beyond: int
    part: float
    low: float
    high: float


@dataclass(frozen=True)
class Summary:
    """Summary of the results of a study so far.

    Counts by status, variants still to run, unfinished variants, inputs (n,) by axis and results (n,) by name, limits
    with the governing one first, sensitivity indices by result.
    """

    counts: dict[str, int]
    waiting: int
    unfinished: int
    inputs: dict[str, Floats]
    results: dict[str, Floats]
    chances: list[Chance]
    indices: dict[str, list[Index]]


def summary(study: Study) -> Summary:
    """Return a summary of all rows that the study has so far."""
    plan, rows = study.plan, [study.rows[n] for n in sorted(study.rows)]
    ended = [row for row in rows if row["status"] in ("done", "red")]
    inputs = {axis.label: _column(ended, INPUT + axis.label) for axis in plan.axes}
    own = [RESPONSE + name for name, _ in study.task.responses]
    results = {name: values for name in (*RESULTS, *own) if np.isfinite(values := _column(ended, name)).any()}
    independent = base_rows(plan.design, len(plan.variants), len(plan.axes))
    alone = [row for row in ended if not plan.sample or independent[row["number"]]]
    names = dict.fromkeys(name for row in ended for name in row if name.startswith("use/"))
    chances = [_chance(name, _column(alone, name)) for name in names]
    found: dict[str, list[Index]] = {}
    if plan.sample and len(ended) == len(plan.variants):
        labels = [axis.label for axis in plan.axes]
        quantiles = drawn(plan.design, plan.sample, len(labels), plan.seed)
        found = {name: indices(plan.design, labels, quantiles, values, plan.seed) for name, values in results.items()}
    return Summary(
        dict(sorted(Counter(row["status"] for row in rows).items())),
        len(study.waiting),
        sum(bool(row["unfinished"]) for row in ended),
        inputs,
        results,
        sorted(chances, key=lambda x: -x.most),
        {name: listed for name, listed in found.items() if listed},
    )


def measured_error(study: Study) -> str:
    """Return a sentence on the error of the study's model level as measured on some variants; "" if not measured."""
    known = {n: float(row["error"]) for n, row in sorted(study.rows.items()) if row.get("error") is not None}
    if not known:
        return ""
    facts = study.plan.scene.facts
    named = f"variant{'s' * (len(known) > 1)} {', '.join(map(str, known))}"
    message = f"error measured on {named}: within {percent(max(known.values()))} of {', '.join(facts.ask)}"
    beyond = [
        f"variant {n} disagrees, {percent(e)} in {study.rows[n]['error in']}"
        for n, e in known.items()
        if e > facts.accuracy
    ]
    return "; ".join([message, *beyond])


def _chance(name: str, uses: Floats) -> Chance:
    """Return the statistics of a limit, with the conservative interval of Clopper and Pearson (1934)."""
    from scipy.special import betaincinv

    uses = uses[np.isfinite(uses)]
    n, k = len(uses), int((uses > 1.0).sum())
    tail = (1.0 - LEVEL) / 2.0
    low = float(betaincinv(k, n - k + 1, tail)) if k else 0.0
    high = float(betaincinv(k + 1, n - k, 1.0 - tail)) if k < n else 1.0
    mean, most = (float(uses.mean()), float(uses.max())) if n else (np.nan, np.nan)
    return Chance(name.removeprefix("use/"), n, mean, most, k, k / n if n else np.nan, low, high)


def _column(rows: Sequence[dict[str, object]], name: str) -> Floats:
    return np.array([np.nan if (x := row.get(name)) is None else x for row in rows], np.float64)
