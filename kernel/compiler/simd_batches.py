"""Batches of independent calls of one traced function, one call per SIMD lane of a vector call.

Equal frames, ropes and trees are calls of one function with different numbers, so the processor's vector units take up
to eight of them at once. Every lane does what the scalar code does, operation by operation, so no bit changes; where a
processor has narrower vectors the compiler splits them.

Operands of several calls are gathered into one vector by the cheapest LLVM IR: one load where they are adjacent in
memory, a shuffle where earlier vector calls hold them, single loads otherwise.
"""

import struct
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from .function import Function, operands
from .symbol import Sym, is_sym

WIDEST = 8
CROWDED = 4  # so many times fewer calls side by side than each of them has inside: those inside use the lanes better


@dataclass(frozen=True)
class SimdBatch:
    """Simultaneous calls of one traced function, one per SIMD lane; `shared`: their common input blocks."""

    calls: tuple[Sym, ...]  # the last one also fills the remaining lanes
    width: int
    shared: frozenset[str]

    @property
    def function(self) -> Function:
        return self.calls[0].args[0]  # type: ignore[no-any-return]

    @property
    def name(self) -> str:
        return f"{self.calls[0].id}x"

    @property
    def lanes(self) -> list[Sym]:
        return [*self.calls, *[self.calls[-1]] * (self.width - len(self.calls))]


def width_of(n: int) -> int:
    """Return the number of lanes for n equal calls: a power of two, which keeps the number of compiled widths small."""
    return WIDEST if n > WIDEST // 2 else 4 if n > 2 else n


def arranged(nodes: Sequence[Sym]) -> list[Sym | SimdBatch]:
    """Return the nodes of a traced function sorted so that inputs come first, with independent equal calls batched."""
    batches = list(_batches(nodes))
    while True:
        at = {call: batch for batch in batches for call in batch.calls}
        order, stuck = _ordered(nodes, at)
        if stuck is None:
            return order
        batches.remove(stuck)


def _batches(nodes: Sequence[Sym]) -> Iterator[SimdBatch]:
    """Yield batches of independent calls of one function that have the same depth in the graph."""
    candidates: dict[Sym, dict[Function, int]] = {}
    groups: dict[tuple[Function, int], list[Sym]] = {}
    for n in nodes:
        candidate: dict[Function, int] = {}
        for x in operands(n):
            below = candidates[x]
            if below is not candidate and below:
                candidate = (
                    {f: max(candidate.get(f, 0), below.get(f, 0)) for f in (*candidate, *below)} if candidate else below
                )
        if n.op == "call":
            f = n.args[0]
            candidate = {**candidate, f: candidate.get(f, 0) + 1}
            if _scalar(f):
                groups.setdefault((f, candidate[f]), []).append(n)
        candidates[n] = candidate
    for (f, _), calls in groups.items():
        width = width_of(len(calls))
        if width > 1 and CROWDED * width > _inside(f):
            shared = _shared(calls)
            yield from (SimdBatch(tuple(calls[i : i + width]), width, shared) for i in range(0, len(calls), width))


def _inside(f: Function) -> int:
    """Return the number of SIMD lanes that the equal calls inside one call of f already fill."""
    counts = Counter(n.args[0] for n in f.nodes if n.op == "call")
    return width_of(max(counts.values(), default=0))


def _shared(calls: Sequence[Sym]) -> frozenset[str]:
    f, *first = calls[0].args
    return frozenset(
        block
        for i, block in enumerate(f.inputs)
        if all(x is y for call in calls for x, y in zip(call.args[i + 1], first[i], strict=True))
    )


def _scalar(f: Function) -> bool:
    """Whether a function consists of scalars only and can be vectorised over lanes."""
    return not (f.rows or f.vectors) and all(
        n.width == 0 and n.op not in ("slice", "dot") and (n.op != "call" or _scalar(n.args[0])) for n in f.nodes
    )


def _ordered(nodes: Sequence[Sym], at: dict[Sym, SimdBatch]) -> tuple[list[Sym | SimdBatch], SimdBatch | None]:
    """Order the nodes depth-first, batches after their inputs; also return a batch that depends on itself, or None."""
    order: list[Sym | SimdBatch] = []
    state: dict[Sym | SimdBatch, bool] = {}  # False while what it needs is being arranged
    for n in nodes:
        todo: list[Sym | SimdBatch] = [at.get(n, n)]
        while todo:
            x = todo[-1]
            if state.get(x):
                todo.pop()
                continue
            if x in state:
                state[x] = True
                order.append(todo.pop())
                continue
            state[x] = False
            needs = [y for call in x.calls for y in operands(call)] if isinstance(x, SimdBatch) else operands(x)
            for y in reversed(needs):
                z = at.get(y, y)
                if state.get(z) is False:
                    return order, z if isinstance(z, SimdBatch) else next(b for b in todo if isinstance(b, SimdBatch))
                if z not in state:
                    todo.append(z)
    return order, None


class OperandCode(Protocol):
    """Interface of a scalar code emitter, as far as the operands of SIMD code use it.

    `value`: returns the IR name of a number, which is loaded on first use.
    """

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
    """Emit the broadcast of a scalar to all lanes; return the vector's name."""
    k = code.new()
    spread_value(code.body, k, code.value(x), lanes)
    return k


def spread_value(body: list[str], name: str, x: str, lanes: int) -> None:
    """Emit the vector `name` with the value x in all lanes."""
    v = vector_type(lanes)
    body += [
        f"{name}a = insertelement {v} poison, double {x}, i64 0",
        f"{name} = shufflevector {v} {name}a, {v} poison, <{lanes} x i32> zeroinitializer",
    ]


def gathered(code: OperandCode, values: tuple[Any, ...]) -> str:
    """Emit a vector that holds one given number per lane; return its name."""
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
    """Emit a load of numbers that are adjacent in a block (the last may be repeated); None if they are not adjacent."""
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
    """Emit a shuffle of results of at most two vector calls; None if the values come from more calls."""
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
    """Emit the selection of some elements of one or two vectors."""
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
