"""Where a sample is taken, as quantiles, and what it says of the inputs: with SALib, from the extra `sweep`.

sobol   Saltelli's extension of a Sobol sequence: base rows A and B, and A with each column of B.  Gives first and total
        indices; A and B alone are independent draws.                          Saltelli et al. (2010)
lhs     a Latin hypercube; gives first indices by random balance designs.       Tarantola, Gatelli, Mara (2006)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan

import numpy as np
from heavylift.kernel.errors import SceneError
from numpy.typing import NDArray

FEWEST = {"sobol": 16, "lhs": 100}  # rows that say something of an index: ten harmonics need several each
DESIGNS = tuple(FEWEST)
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Index:
    """What part of the variance of a result an axis explains alone, and with all others; each with its half-width at
    95 %."""

    axis: str
    first: float
    first_half: float
    total: float
    total_half: float


def drawn(design: str, count: int, axes: int, seed: int) -> Floats:
    """(at most count, axes) quantiles in (0, 1); raises SceneError where the count is too small."""
    if design not in DESIGNS:
        raise SceneError(f"--design '{design}': there is none; choose {' or '.join(DESIGNS)}")
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
    """(count,) bool: which rows are independent draws of all inputs."""
    independent = np.ones(count, bool)
    if design == "sobol":
        block = np.arange(count) % (axes + 2)
        independent = (block == 0) | (block == axes + 1)
    return independent


def indices(design: str, axes: Sequence[str], quantiles: Floats, result: Floats, seed: int) -> list[Index]:
    """The indices of each axis, by falling total; none where a value is missing, or does not vary."""
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
