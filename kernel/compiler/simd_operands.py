"""Numbers of several calls as one vector, in the cheapest way that LLVM IR has for where they are.

Loaded at once where they lie next to each other, shuffled where earlier vector calls have left them, one by one else.
"""

from __future__ import annotations

import struct
from typing import Any, Protocol

from .simd_batches import SimdBatch
from .symbol import Sym, is_sym


class OperandCode(Protocol):
    """Straight-line code that is being written; `lane`: where calls stand that were made side by side; `value`: the
    name of a number, which is loaded if it has not been."""

    body: list[str]
    lane: dict[Sym, tuple[SimdBatch, int]]

    def new(self) -> str: ...

    def value(self, x: Any, lanes: int = 0) -> str: ...


def constant(x: float, lanes: int = 0) -> str:
    (bits,) = struct.unpack("<Q", struct.pack("<d", float(x)))
    return f"<{', '.join([f'double 0x{bits:016X}'] * lanes)}>" if lanes else f"0x{bits:016X}"


def reference(x: Any, lanes: int = 0) -> str:
    return f"%t{x.id}" if is_sym(x) else constant(x, lanes)


def vector_type(lanes: int, element: str = "double") -> str:
    return f"<{lanes} x {element}>" if lanes else element


def spread(code: OperandCode, x: Any, lanes: int) -> str:
    """One scalar in all lanes."""
    k = code.new()
    spread_value(code.body, k, code.value(x), lanes)
    return k


def spread_value(body: list[str], name: str, x: str, lanes: int) -> None:
    """A vector of that name with the value x in all lanes."""
    v = vector_type(lanes)
    body += [
        f"{name}a = insertelement {v} poison, double {x}, i64 0",
        f"{name} = shufflevector {v} {name}a, {v} poison, <{lanes} x i32> zeroinitializer",
    ]


def gathered(code: OperandCode, values: tuple[Any, ...]) -> str:
    """One number of every lane as a vector."""
    if all(x is values[0] for x in values):
        return spread(code, values[0], len(values))
    if not any(map(is_sym, values)):
        return f"<{', '.join(f'double {constant(x)}' for x in values)}>"
    found = None
    if all(is_sym(x) and x.op == "in" for x in values):
        found = _inputs(code, values)
    elif all(is_sym(x) and x.op == "ret" and x.args[0] in code.lane for x in values):
        found = _results(code, values)
    return found or _one_by_one(code, values)


def _inputs(code: OperandCode, values: tuple[Sym, ...]) -> str | None:
    """Numbers that lie next to each other in a block, the last one perhaps repeated."""
    block, first = values[0].args
    n = next((i for i, x in enumerate(values) if x.args != (block, first + i)), len(values))
    if n < 2 or any(x is not values[n - 1] for x in values[n:]):
        return None
    k = code.new()
    code.body += [
        f"{k}p = getelementptr double, ptr %{block}, i64 {first}",
        f"{k} = load {vector_type(n)}, ptr {k}p, align 8",
    ]
    return _shuffled(code, [k], n, [min(i, n - 1) for i in range(len(values))])


def _results(code: OperandCode, values: tuple[Sym, ...]) -> str | None:
    """Results of vector calls, at most two different numbers of them."""
    at = [(*code.lane[x.args[0]], x.args[1], x.args[2]) for x in values]
    sources = list(dict.fromkeys((batch, block, i) for batch, _, block, i in at))
    width = sources[0][0].width
    if len(sources) > 2 or any(batch.width != width for batch, _, _ in sources):
        return None
    loaded = []
    for batch, block, i in sources:
        k = code.new()
        loaded.append(k)
        code.body += [
            f"{k}p = getelementptr double, ptr %r{batch.name}_{block}, i64 {i * width}",
            f"{k} = load {vector_type(width)}, ptr {k}p, align 8",
        ]
    return _shuffled(code, loaded, width, [sources.index((b, block, i)) * width + lane for b, lane, block, i in at])


def _shuffled(code: OperandCode, sources: list[str], width: int, places: list[int]) -> str:
    """The given places of one or two vectors as one."""
    if places == list(range(width)):
        return sources[0]
    k, v = code.new(), vector_type(width)
    first, second = (*sources, "poison")[:2]
    mask = ", ".join(f"i32 {i}" for i in places)
    code.body.append(f"{k} = shufflevector {v} {first}, {v} {second}, <{len(places)} x i32> <{mask}>")
    return k


def _one_by_one(code: OperandCode, values: tuple[Any, ...]) -> str:
    names = [code.value(x) for x in values]
    k, v, last = code.new(), vector_type(len(values)), "poison"
    for i in range(len(values)):
        code.body.append(f"{k}_{i} = insertelement {v} {last}, double {names[i]}, i64 {i}")
        last = f"{k}_{i}"
    return last
