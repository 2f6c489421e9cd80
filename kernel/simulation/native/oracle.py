"""The native functions interpreted on floats: the same text, NumPy instead of machine code, a thousand times slower.

It exists to check the tracer and the compiler: both must agree to 1e-12.
"""

from __future__ import annotations

import numpy as np
from heavylift.kernel.compiler.emit import EmittedParts, While
from heavylift.kernel.compiler.emit import blocks as names
from heavylift.kernel.compiler.function import Function, Primitive, flatten

from .native_functions import Stepping


class Oracle:
    """Stands in for `machine_code.Library`."""

    def __init__(self, method: Stepping) -> None:
        self._functions: dict[str, Function | EmittedParts] = {**method.functions, "advance": method.advance}

    def call(self, name: str, *blocks: np.ndarray) -> None:
        """Run a function on its blocks, in the order of its native arguments."""
        f = self._functions[name]
        self._run(f, dict(zip(names(f), blocks, strict=True)))

    def _run(self, f: Function | EmittedParts, memory: dict[str, np.ndarray]) -> None:
        if isinstance(f, While):
            while memory[f.block][f.flag] > 0.0:
                for part in f.parts:
                    self._run(part, memory)
        elif isinstance(f, EmittedParts):
            for part in f.parts:
                self._run(part, memory)
        elif isinstance(f, Primitive):
            f.body(**{k: memory[k] for k in f.inputs})
        else:
            out = f.body(**{k: memory[k] if k == "M" else memory[k].copy() for k in f.inputs})
            for name, values in out.items():
                row, given = values if isinstance(values, tuple) else (0.0, values)
                numbers = [float(x) for x in flatten(given)]
                start = int(row) * len(numbers)
                memory[name].reshape(-1)[start : start + len(numbers)] = numbers
