"""The next active set: a linear complementarity problem with boxes, solved by pivoting in a fixed order.

Find x in [lo, hi] with w = A x + b such that w_i >= 0 where x_i = lo_i, w_i <= 0 where x_i = hi_i, else w_i = 0.
`block_pivoting` says how sets follow each other, `native_pivoting` runs that as machine code.  Here is what surrounds
it: problems
that are singular because rows are redundant, and tolerances.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .block_pivoting import product, start_of
from .native_pivoting import pivot

PASSES = 4  # proximal passes; each gains about seven digits
SOFTNESS = 1e-7  # regularisation relative to the mean diagonal: redundant rows share their load equally
SMALL = 1e-11  # relative size of what counts as zero


@dataclass(frozen=True)
class Solution:
    """x and w (n,); side (n,): -1 at lo, 1 at hi, 0 between; `found`: whether all conditions hold."""

    x: np.ndarray
    w: np.ndarray
    side: np.ndarray
    found: bool


def solve(
    A: np.ndarray,
    b: np.ndarray,
    lo: np.ndarray,
    hi: np.ndarray,
    side: np.ndarray | None = None,
    prior: np.ndarray | None = None,
) -> Solution:
    """A: (n, n), need not be symmetric and may be singular; `side` (n,): the set to begin with (default: all at rest
    at the bound nearest to zero, or free where there is none).

    Singular problems are solved by proximal passes: of all solutions, the one whose redundant rows share equally, or
    are next to `prior` (n,).
    """
    n = len(b)
    if not n:
        return Solution(np.zeros(0), np.zeros(0), np.zeros(0), True)
    soft = SOFTNESS * sum(np.abs(np.diag(A)).tolist()) / n
    regular = A + soft * np.eye(n)
    x = np.zeros(n) if prior is None else prior
    s = start_of(n, np.where(lo == 0.0, -1.0, np.where(hi == 0.0, 1.0, 0.0)) if side is None else side)
    with np.errstate(all="ignore"):
        for _ in range(PASSES):
            s = start_of(n, s.side)
            size = float(np.abs(b).max())
            small = SMALL * size / float(np.diag(regular).max()), SMALL * size
            pivot(s, regular, b - soft * x, lo, hi, small)
            if s.number > 0.0 or not np.isfinite(s.x).all():
                return Solution(s.x, s.w, s.side, False)
            x = s.x
    return Solution(x, product(A, x, b), s.side, True)
