"""The native functions interpreted on floats: the same text, NumPy instead of machine code, a thousand times slower.

It exists to check the tracer and the compiler: both must agree to 1e-12.
"""

from __future__ import annotations

import numpy as np

from .emit import While
from .function import Function, flatten
from .stepping import Stepping

__all__ = ["Oracle"]


class Oracle:
    """Stands in for `native.Library`."""

    def __init__(self, method: Stepping) -> None:
        self._functions: dict[str, Function | While] = {**method.functions, "advance": method.advance}

    def call(self, name: str, *blocks: np.ndarray) -> None:
        """Run a function on the blocks X, P and, where it writes rows, the table."""
        self._run(self._functions[name], *blocks)

    def _run(self, f: Function | While, X: np.ndarray, P: np.ndarray, table: np.ndarray | None = None) -> None:
        if isinstance(f, While):
            while X[f.flag] > 0.0:
                for part in f.parts:
                    self._run(part, X, P, table)
            return
        out = f.body(X=X.copy(), P=P)
        X[:] = [float(x) for x in flatten(out["X"])]
        if "table" in out and table is not None:
            row, values = out["table"]
            table[int(row)] = [float(x) for x in flatten(values)]
