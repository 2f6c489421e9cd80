"""The next active set: a linear complementarity problem with boxes, solved by pivoting in a fixed order.

Find x in [lo, hi] with w = A x + b such that w_i >= 0 where x_i = lo_i, w_i <= 0 where x_i = hi_i, else w_i = 0.
Block principal pivoting (Judice, Pires, Comput. Oper. Res. 21 (1994)): every row that violates its condition changes
sides at once; if that does not reduce their number for a while, only the last one does (Murty, Lin. Alg. Appl. 9
(1974)), which ends for every P matrix.  `round_of` is one such change, without branches, so that the same text runs on
floats and becomes machine code; a loop around it is the solver.  No BLAS: sums in a fixed order, the same bits.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..symbol import any_of, less, select

__all__ = ["Solution", "eliminate", "round_of", "solve", "start_of"]

PATIENCE = 4.0  # block changes without progress before single ones
ROUNDS = 60.0  # per row and solve; Murty's worst case is exponential, but is never met in practice
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


def start_of(n: int, side: Any) -> SimpleNamespace:
    """The loop's variables before the first round; side (n,) is the set to begin with."""
    return SimpleNamespace(
        side=side, x=np.zeros(n), w=np.zeros(n), fewest=n + 1.0, patience=PATIENCE, budget=ROUNDS * n, run=1.0
    )


def round_of(s: SimpleNamespace, A: Any, b: Any, lo: Any, hi: Any, small_x: Any, small_w: Any) -> None:
    """Solve for the present set and change the sides of rows that violate their condition; run = 0 when none does."""
    n = len(b)
    low, high = less(s.side, 0.0), less(0.0, s.side)
    free = select(low, 0.0, select(high, 0.0, 1.0)) * np.ones(n)
    held = select(low, lo, select(high, hi, 0.0))
    s.x = held + eliminate(A, -_product(A, held, b), free)
    s.w = _product(A, s.x, b)
    between = less(0.0, free)
    down = select(between, select(less(s.x, lo - small_x), 1.0, 0.0), 0.0)
    up = select(between, select(less(hi + small_x, s.x), 1.0, 0.0), 0.0)
    back = select(low, select(less(s.w, -small_w), 1.0, 0.0), select(high, select(less(small_w, s.w), 1.0, 0.0), 0.0))
    wrong = down + up + back
    number = _sum(wrong)
    fewer = number < s.fewest
    block = any_of([fewer, s.patience > 0.0])
    s.patience = select(fewer, PATIENCE, s.patience - 1.0)
    s.fewest = select(fewer, number, s.fewest)
    change = select(block, wrong, _last(wrong))
    s.side = select(less(0.0, change), up - down, s.side)
    s.budget = s.budget - 1.0
    s.run = select(number > 0.0, select(s.budget > 0.0, 1.0, 0.0), 0.0)
    s.number = number


def _product(A: Any, x: Any, b: Any) -> Any:
    """A x + b, summed column by column."""
    for j in range(len(b)):
        b = b + A[:, j] * x[j]
    return b


def _sum(x: Any) -> Any:
    total: Any = 0.0
    for e in x:
        total = total + e
    return total


def _last(wrong: Any) -> Any:
    """Only the last of the marked rows."""
    out, later = [], 0.0
    for e in reversed(list(wrong)):
        out.append(e * (1.0 - later))
        later = select(e > 0.0, 1.0, later)
    return np.array(out[::-1])


def eliminate(A: Any, r: Any, free: Any) -> Any:
    """A x = r over the free rows and columns, x = 0 in the others; pivots in the order of the rows."""
    n = len(r)
    M = np.concatenate([A * free[:, None] * free + np.eye(n) * (1.0 - free), (r * free)[:, None]], axis=1)
    for k in range(n):
        row, others = M[k] * (1.0 / M[k][k]), M[:, k] * (1.0 - np.eye(n)[k])
        M = M - others[:, None] * row
        M[k] = row
    return M[:, n]


def solve(A: np.ndarray, b: np.ndarray, lo: np.ndarray, hi: np.ndarray, side: np.ndarray | None = None) -> Solution:
    """A: (n, n), need not be symmetric and may be singular; `side` (n,): the set to begin with (default: all at rest
    at the bound nearest to zero, or free where there is none).

    Singular problems are solved by proximal passes: of all solutions, the one whose redundant rows share equally.
    """
    n = len(b)
    if not n:
        return Solution(np.zeros(0), np.zeros(0), np.zeros(0), True)
    soft = SOFTNESS * float(_sum(np.abs(np.diag(A)))) / n
    regular = A + soft * np.eye(n)
    x = np.zeros(n)
    s = start_of(n, np.where(lo == 0.0, -1.0, np.where(hi == 0.0, 1.0, 0.0)) if side is None else side)
    with np.errstate(all="ignore"):
        for _ in range(PASSES):
            s = start_of(n, s.side)
            size = float(np.abs(b).max())
            while s.run > 0.0:
                round_of(s, regular, b - soft * x, lo, hi, SMALL * size / float(np.diag(regular).max()), SMALL * size)
            if s.number > 0.0 or not np.isfinite(s.x).all():
                return Solution(s.x, s.w, s.side, False)
            x = s.x
    return Solution(x, _product(A, x, b), s.side, True)
