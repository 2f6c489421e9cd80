"""The pivoting solver as machine code: rounds in a native loop until no row violates its condition.

One piece of code per size, cached like that of scenes; smaller problems are filled up with rows that are free, at
zero, and touch no other row.  Those add exact zeros, so that x is that of the same rounds on floats, bit by bit.
Larger problems than `SIZES` run on floats: their code would take longer to compile than a run saves.
"""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
from heavylift.kernel.compiler.emit import While, module
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.layout import Layout
from heavylift.kernel.compiler.machine_code import Library
from heavylift.kernel.compiler.symbol import Array

from .block_pivoting import round_of

SIZES = (6, 12)  # rows
_SCALARS = ("fewest", "patience", "budget", "number", "small_x", "small_w")
_VECTORS = ("side", "x", "w", "b", "lo", "hi")


def pivot(
    s: SimpleNamespace, A: np.ndarray, b: np.ndarray, lo: np.ndarray, hi: np.ndarray, small: tuple[float, float]
) -> None:
    """Rounds from the start s until none changes anything or the budget is spent; s holds the result."""
    n = len(b)
    size = next((k for k in SIZES if n <= k), 0)
    if not size:
        while s.run > 0.0:
            round_of(s, A, b, lo, hi, *small)
        return
    layout, code = _loop(size)
    X = np.zeros(layout.size)
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
