"""Solver for the next active set of constraints: a linear complementarity problem with bounds, by pivoting in a fixed
order.

Find x in [lo, hi] with w = A x + b such that w_i >= 0 where x_i = lo_i, w_i <= 0 where x_i = hi_i, else w_i = 0. Block
principal pivoting (Judice, Pires, Comput. Oper. Res. 21 (1994)): every row that violates its condition changes sides at
once; if the number of such rows does not fall for some rounds, only the last of them changes sides (Murty, Lin. Alg.
Appl. 9 (1974)), which ends for every P matrix. No BLAS: sums in a fixed order, the same bits on floats and in machine
code, compiled for the sizes in `SIZES`; smaller problems are padded with free rows at zero, which add exact zeros, and
larger ones run on floats.

Redundant rows make A singular; the proximal passes (A + mu) x_n+1 = b + mu x_n converge to the solution of least norm
(Carpentier, Budhiraja, Mansard 2021, algorithm 2): rows with the same direction share their load equally, and
multipliers stay bounded while a mechanism passes a singular pose.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from types import SimpleNamespace

import numpy as np
from heavylift.kernel.compiler.emit import Library, While, module
from heavylift.kernel.compiler.function import Function, Layout, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, any_of, less, select

PATIENCE = 4.0  # block changes without progress before single ones
ROUNDS = 60.0  # per row and solve; Murty's worst case is exponential, but is never met in practice


def start_of(n: int, side: Array) -> SimpleNamespace:
    """Return the loop variables at the start of the pivoting; `side` (n,): initial active set."""
    return SimpleNamespace(
        side=side, x=np.zeros(n), w=np.zeros(n), fewest=n + 1.0, patience=PATIENCE, budget=ROUNDS * n, run=1.0
    )


def round_of(s: SimpleNamespace, A: Array, b: Array, lo: Array, hi: Array, small_x: Scalar, small_w: Scalar) -> None:
    """Do one round of pivoting: solve for the active set, then change the sides of rows that violate their conditions;
    set s.run = 0 if none does."""
    n = len(b)
    low, high = less(s.side, 0.0), less(0.0, s.side)
    free = select(low, 0.0, select(high, 0.0, 1.0)) * np.ones(n)
    held = select(low, lo, select(high, hi, 0.0))
    # rows at a bound move to the right-hand side
    s.x = held + eliminate(A, -product(A, held, b), free)
    s.w = product(A, s.x, b)
    # rows between bounds must stay inside them, rows at a bound must not be pulled off
    between = less(0.0, free)
    down = select(between, select(less(s.x, lo - small_x), 1.0, 0.0), 0.0)
    up = select(between, select(less(hi + small_x, s.x), 1.0, 0.0), 0.0)
    back = select(low, select(less(s.w, -small_w), 1.0, 0.0), select(high, select(less(small_w, s.w), 1.0, 0.0), 0.0))
    # signs: leave the lower bound if w < 0 there, the upper one if w > 0
    wrong = down + up + back
    number = _sum(wrong)
    fewer = number < s.fewest
    # block changes as long as they reduce the number of violations, with some patience
    block = any_of([fewer, s.patience > 0.0])
    s.patience = select(fewer, PATIENCE, s.patience - 1.0)
    s.fewest = select(fewer, number, s.fewest)
    # else only the last violated row changes (Murty): slower, but cannot cycle for P matrices
    change = select(block, wrong, _last(wrong))
    s.side = select(less(0.0, change), up - down, s.side)
    s.budget = s.budget - 1.0
    s.run = select(number > 0.0, select(s.budget > 0.0, 1.0, 0.0), 0.0)
    s.number = number


def product(A: Array, x: Array, b: Array) -> Array:
    """Return the vector A x + b, summed column by column."""
    for j in range(len(b)):
        b = b + A[:, j] * x[j]
    return b


def _sum(x: Array) -> Scalar:
    total: Scalar = 0.0
    for e in x:
        total = total + e
    return total


def _last(wrong: Array) -> Array:
    """Return the marks `wrong` with only the last marked row kept."""
    out, later = [], 0.0
    for e in reversed(list(wrong)):
        out.append(e * (1.0 - later))
        later = select(e > 0.0, 1.0, later)
    return np.array(out[::-1])


def eliminate(A: Array, r: Array, free: Array) -> Array:
    """Solve A x = r over the free rows and columns, with x = 0 elsewhere; pivots are taken in row order."""
    n = len(r)
    # rows and columns that are not free become those of the identity, so that the size stays fixed in machine code
    M = np.concatenate([A * free[:, None] * free + np.eye(n) * (1.0 - free), (r * free)[:, None]], axis=1)
    for k in range(n):
        # Gauss-Jordan without pivoting: free blocks of a P matrix have positive pivots
        row, others = M[k] * (1.0 / M[k][k]), M[:, k] * (1.0 - np.eye(n)[k])
        M = M - others[:, None] * row
        M[k] = row
    return M[:, n]


SIZES = (6, 12)  # rows
_SCALARS = ("fewest", "patience", "budget", "number", "small_x", "small_w")
_VECTORS = ("side", "x", "w", "b", "lo", "hi")


def pivot(
    s: SimpleNamespace, A: np.ndarray, b: np.ndarray, lo: np.ndarray, hi: np.ndarray, small: tuple[float, float]
) -> None:
    """Run rounds of pivoting on the loop variables s until the active set stays the same or the rounds are used up."""
    n = len(b)
    size = next((k for k in SIZES if n <= k), 0)
    if not size:
        while s.run > 0.0:
            round_of(s, A, b, lo, hi, *small)
        return
    layout, code = _loop(size)
    X = np.zeros(layout.size)
    # padding with free rows of the identity at zero adds exact zeros, so that the bits do not depend on the size
    wide = np.eye(size)
    wide[:n, :n] = A
    given = {"A": wide.ravel(), "small_x": small[0], "small_w": small[1], **vars(s), "number": 0.0}
    for name, value in given.items():
        at = layout.at[name]
        X[at] = np.pad(value, (0, size - n)) if name in _VECTORS else value
    for name, values, beyond in (("b", b, 0.0), ("lo", lo, -np.inf), ("hi", hi, np.inf)):
        X[layout.at[name]] = np.pad(values, (0, size - n), constant_values=beyond)
    code.call("pivot", X)
    s.side, s.x, s.w = (X[layout.at[name]][:n].copy() for name in ("side", "x", "w"))
    s.fewest, s.patience, s.budget, s.number, s.run = (
        float(X[layout.at[name]]) for name in ("fewest", "patience", "budget", "number", "run")
    )


@cache
def _loop(n: int) -> tuple[Layout, Library]:
    layout = Layout({**dict.fromkeys(("run", *_SCALARS)), **dict.fromkeys(_VECTORS, n), "A": n * n})

    def body(X: Array) -> Outputs:
        s = layout.unpack(X, SimpleNamespace)
        round_of(s, np.reshape(s.A, (n, n)), s.b, s.lo, s.hi, s.small_x, s.small_w)
        return {"X": layout.pack(s)}

    f = Function(f"round_{n}", body, {"X": layout.size})
    loop = While("pivot", layout.at["run"], (f,))
    return layout, Library(f"pivoting of {n} rows", lambda: module(loop, f))


PASSES = 4  # proximal passes; each gains about seven digits
SOFTNESS = 1e-7  # regularisation relative to the mean diagonal: redundant rows share their load equally
SMALL = 1e-11  # relative size of what counts as zero


@dataclass(frozen=True)
class Solution:
    """Solution of a linear complementarity problem with bounds: x and w (n,).

    side (n,): -1 at lo, 1 at hi, 0 between; `found`: whether all conditions hold.
    """

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
    """Solve the linear complementarity problem with bounds for a matrix A (n, n), possibly unsymmetric or singular.

    `side` (n,): initial active set (default: at the bound nearest to zero, or free without bounds). Singular problems
    are solved by proximal passes; of all solutions they find the one whose redundant rows share the load equally, or
    the one nearest to `prior` (n,).
    """
    n = len(b)
    if not n:
        return Solution(np.zeros(0), np.zeros(0), np.zeros(0), True)
    # in proportion to the mean diagonal, as units of the rows differ
    soft = SOFTNESS * sum(np.abs(np.diag(A)).tolist()) / n
    regular = A + soft * np.eye(n)
    x = np.zeros(n) if prior is None else prior
    # rows that can only push begin at zero, all others free
    s = start_of(n, np.where(lo == 0.0, -1.0, np.where(hi == 0.0, 1.0, 0.0)) if side is None else side)
    with np.errstate(all="ignore"):
        for _ in range(PASSES):
            # patience and budget are renewed, the set found so far is kept
            s = start_of(n, s.side)
            size = float(np.abs(b).max())
            small = SMALL * size / float(np.diag(regular).max()), SMALL * size
            # the proximal term: each pass solves (A + soft) x' = soft x - b
            pivot(s, regular, b - soft * x, lo, hi, small)
            if s.number > 0.0 or not np.isfinite(s.x).all():
                return Solution(s.x, s.w, s.side, False)
            x = s.x
    return Solution(x, product(A, x, b), s.side, True)


MU = 1e-6  # regularisation relative to a row's own diagonal
MU_SHARED = 1e-8  # and to the mean size of all rows, metres and radians alike: for what can only move together
TINY = 1e-300  # where no row can move anything
PROXIMAL_PASSES = 3  # each divides the error by 1/MU for well-conditioned rows


def fill_in(n: int, couples: Sequence[tuple[int, int]]) -> list[list[int]]:
    """Return, for each row s of a matrix, the later rows r that become nonzero when s is eliminated.

    Rows may be blocks; `couples`: initial nonzero pairs (s, r), s < r.
    """
    later: list[list[int]] = [[] for _ in range(n)]
    for s, r in couples:
        later[s].append(r)
    for s in range(n):
        later[s].sort()
        for i, r in enumerate(later[s]):
            # eliminating s couples all rows that come after it: the usual symbolic factorisation
            later[r] = sorted({*later[r], *later[s][i + 1 :]})
    return later


class Proximal:
    """Base class of factorisations of A + mu: finds multipliers also for redundant rows, by proximal iterations."""

    _substitute: Function  # (C, b -> x) of one factorisation

    def _multipliers(self, C: Array, mu: Scalars, b: Scalars, prior: "Scalars | None" = None) -> Outputs:
        """Return the multipliers; for redundant rows those nearest to `prior` (n,), default zero."""
        first = b if prior is None else [e + m * y for e, m, y in zip(b, mu, prior, strict=True)]
        x = self._substitute(C=C, b=first).x
        for _ in range(PROXIMAL_PASSES - 1):
            # proximal iterations: the regularisation is compensated by the previous multipliers
            x = self._substitute(C=C, b=[e + m * y for e, m, y in zip(b, mu, x, strict=True)]).x
        return {"x": x}
