"""One round of the pivoting solver, without branches: the same text runs on floats and becomes machine code.

Block principal pivoting (Judice, Pires, Comput. Oper. Res. 21 (1994)): every row that violates its condition changes
sides at once; if that does not reduce their number for a while, only the last one does (Murty, Lin. Alg. Appl. 9
(1974)), which ends for every P matrix.  No BLAS: sums in a fixed order, the same bits.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from heavylift.kernel.compiler.symbol import Array, Scalar, any_of, less, select

PATIENCE = 4.0  # block changes without progress before single ones
ROUNDS = 60.0  # per row and solve; Murty's worst case is exponential, but is never met in practice


def start_of(n: int, side: Array) -> SimpleNamespace:
    """The loop's variables before the first round; side (n,) is the set to begin with."""
    return SimpleNamespace(
        side=side, x=np.zeros(n), w=np.zeros(n), fewest=n + 1.0, patience=PATIENCE, budget=ROUNDS * n, run=1.0
    )


def round_of(s: SimpleNamespace, A: Array, b: Array, lo: Array, hi: Array, small_x: Scalar, small_w: Scalar) -> None:
    """Solve for the present set and change the sides of rows that violate their condition; run = 0 when none does."""
    n = len(b)
    low, high = less(s.side, 0.0), less(0.0, s.side)
    free = select(low, 0.0, select(high, 0.0, 1.0)) * np.ones(n)
    held = select(low, lo, select(high, hi, 0.0))
    s.x = held + eliminate(A, -product(A, held, b), free)
    s.w = product(A, s.x, b)
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


def product(A: Array, x: Array, b: Array) -> Array:
    """A x + b, summed column by column."""
    for j in range(len(b)):
        b = b + A[:, j] * x[j]
    return b


def _sum(x: Array) -> Scalar:
    total: Scalar = 0.0
    for e in x:
        total = total + e
    return total


def _last(wrong: Array) -> Array:
    """Only the last of the marked rows."""
    out, later = [], 0.0
    for e in reversed(list(wrong)):
        out.append(e * (1.0 - later))
        later = select(e > 0.0, 1.0, later)
    return np.array(out[::-1])


def eliminate(A: Array, r: Array, free: Array) -> Array:
    """A x = r over the free rows and columns, x = 0 in the others; pivots in the order of the rows."""
    n = len(r)
    M = np.concatenate([A * free[:, None] * free + np.eye(n) * (1.0 - free), (r * free)[:, None]], axis=1)
    for k in range(n):
        row, others = M[k] * (1.0 / M[k][k]), M[:, k] * (1.0 - np.eye(n)[k])
        M = M - others[:, None] * row
        M[k] = row
    return M[:, n]
