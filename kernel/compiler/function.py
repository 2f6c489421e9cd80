"""Traced functions: a body is traced once and called many times, so that its machine code exists once.

Named parts of one block of doubles: the same names index it from Python and from traced text.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from threading import RLock
from types import SimpleNamespace
from typing import Any, TypeAlias, TypeVar

import numpy as np

from .symbol import RECORDING, Array, ExpressionGraph, Sym, is_sym, node

IDLE = ("in", "ret", "slice", "block")  # of nodes: they read what is there
Outputs: TypeAlias = Mapping[str, Any]  # what a body returns: the numbers of each block
OPAQUE = -1  # size of an input block that is handed on as a whole
ONCE = RLock()  # programs in several threads share functions


def operands(n: Sym) -> list[Sym]:
    args = [x for a in n.args[1:] for x in a] if n.op == "call" else n.args
    return [x for x in args if type(x) is Sym]


def symbols(block: str, n: int) -> np.ndarray:
    """Return the n numbers of an input block as symbols (n,)."""
    return np.array([node("in", block, i) for i in range(n)] + [None], dtype=object)[:-1]


class Function:
    """A Python function on arrays of numbers that is traced once into native code and called many times.

    body(**blocks) -> {name: values, or (row, values) for a row of a table}. On floats a call runs the body itself;
    while another function is being traced a call adds one call node, so the machine code exists once. `vectors`:
    outputs that callers receive as one vector symbol. `rare`: called so seldom that a long function is compiled without
    optimisation.
    """

    def __init__(
        self,
        name: str,
        body: Callable[..., Mapping[str, Any]],
        inputs: Mapping[str, int],
        vectors: Sequence[str] = (),
        rare: bool = False,
    ) -> None:
        self.name, self.body, self.inputs, self.vectors, self.rare = name, body, dict(inputs), vectors, rare
        self._nodes: list[Sym] | None = None
        self.rows: dict[str, Any] = {}
        self._outputs: dict[str, list[Any]] = {}

    def record(self) -> None:
        """Trace the body of the function and drop unused operations."""
        with ONCE:
            if self._nodes is None:
                self._record()

    def _record(self) -> None:
        with ExpressionGraph() as graph:
            out = self.body(**{k: node("block", k) if n == OPAQUE else symbols(k, n) for k, n in self.inputs.items()})
            self.rows = {k: v[0] for k, v in out.items() if isinstance(v, tuple)}
            values = {k: v[1] if k in self.rows else v for k, v in out.items()}
            self._outputs = {k: flatten(v) for k, v in values.items()}
        live: set[Sym] = set()
        written = [x for name, v in self._outputs.items() for x, kept in placed(name, v) if not kept]
        todo = [x for x in (*written, *self.rows.values()) if is_sym(x)]
        while todo:
            x = todo.pop()
            if x not in live:
                live.add(x)
                todo += operands(x)
        self._nodes = [n for n in graph.nodes if n in live]

    @property
    def nodes(self) -> list[Sym]:
        self.record()
        assert self._nodes is not None
        return self._nodes

    @property
    def outputs(self) -> dict[str, list[Any]]:
        self.record()
        return self._outputs

    @cached_property
    def operations(self) -> int:
        """The number of arithmetic operations in one call, including those of called functions."""
        return sum(n.args[0].operations if n.op == "call" else n.op not in IDLE for n in self.nodes)

    def __call__(self, **values: Any) -> SimpleNamespace:
        if not RECORDING.graphs or RECORDING.graphs[-1].opaque:
            out = self.body(**{k: v if self.inputs[k] == OPAQUE else self._numbers(v) for k, v in values.items()})
            return SimpleNamespace(**{k: np.array(flatten(v)) for k, v in out.items()})
        call = node("call", self, *(tuple(flatten(values[k])) for k in self.inputs))

        def returned(k: str, v: list[Any]) -> Any:
            width = sum(max(1, x.width) if is_sym(x) else 1 for x in v)
            if k in self.vectors:
                return node("ret", call, k, 0, width=width)
            return np.array([node("ret", call, k, i) for i in range(width)] + [None], dtype=object)[:-1]

        return SimpleNamespace(**{k: returned(k, v) for k, v in self.outputs.items()})

    def _numbers(self, x: Any) -> Array:
        """Return Python floats in order: NumPy passes products of its own floats to BLAS, whose last bits differ."""
        return np.array(flatten(x), dtype=object)


class Primitive(Function):
    """A native function given as LLVM IR `text` (hand-written loops), with the Python function `body` as its reference
    on floats.

    A primitive without outputs works in place on its blocks and serves as a part of a loop.
    """

    def __init__(
        self,
        name: str,
        body: Callable[..., Mapping[str, Any]],
        inputs: Mapping[str, int],
        outputs: Mapping[str, int],
        text: str,
    ) -> None:
        super().__init__(name, body, inputs, [*outputs])
        self.text = text
        self._nodes = []
        self._outputs = {k: [0.0] * n for k, n in outputs.items()}

    def _numbers(self, x: Any) -> Array:
        return np.array(flatten(x))  # whatever an oracle does, machine code does in a stated order


def placed(block: str, values: list[Any]) -> list[tuple[Any, bool]]:
    """Return the values to be written to a memory block, and for each whether the block already holds it."""
    out, at = [], 0
    for x in values:
        known = type(x) is Sym
        out.append((x, known and x.op in ("in", "slice") and x.args == (block, at)))
        at += (x.width or 1) if known else 1
    return out


def flatten(x: Any) -> list[Any]:
    """Return the scalars and vector symbols of a nested value as a flat list in their order."""
    if is_sym(x) or isinstance(x, float | int):
        return [x]
    if isinstance(x, np.ndarray):
        return list(x.ravel().tolist())
    return [e for y in x for e in flatten(y)]


Places = Mapping[str, Any]  # name -> index of a scalar, slice of several numbers
Parts = TypeVar("Parts", bound=SimpleNamespace)


class Layout:
    """Memory layout of a block: the positions of its named numbers.

    `sizes`: None for a scalar, n for n numbers; names in `vectors` are unpacked as vector symbols.
    """

    def __init__(self, sizes: Mapping[str, int | None], vectors: frozenset[str] = frozenset()) -> None:
        places: dict[str, Any] = {}
        self.vectors = vectors
        n = 0
        for name, m in sizes.items():
            places[name] = n if m is None else slice(n, n + m)
            n += 1 if m is None else m
        self.at: Places = places
        self.size = n

    def unpack(self, block: Any, kind: type[Parts]) -> Parts:
        """Return the named parts of a block as an object of type `kind`: scalars, arrays or vector symbols."""
        if isinstance(block, np.ndarray) and block.dtype == np.float64:
            return kind(**{name: block[at] for name, at in self.at.items()})

        def part(name: str) -> Any:
            x = block[self.at[name]]
            if name in self.vectors and len(x) and is_sym(x[0]):
                return node("slice", x[0].args[0], x[0].args[1], width=len(x))
            return x

        return kind(**{name: part(name) for name in self.at})

    def pack(self, parts: SimpleNamespace) -> list[Any]:
        """Return the values of a block in the order of the layout; a vector symbol stays one value."""
        out: list[Any] = []
        for name in self.at:
            x = getattr(parts, name)
            out += x.ravel().tolist() if isinstance(x, np.ndarray) else x if isinstance(x, list) else [x]
        return out
