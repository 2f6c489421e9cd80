"""Equal calls side by side: calls of one function that do not need each other become the lanes of one vector call.

Equal frames, ropes and trees are calls of one function with different numbers, so the processor's vector units take
up to eight of them at once.  Every lane does what the scalar code does, operation by operation, so no bit changes;
where a processor has narrower vectors the compiler splits them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from .function import Function, operands
from .symbol import Sym

WIDEST = 8
CROWDED = 4  # so many times fewer calls side by side than each of them has inside: those inside use the lanes better


@dataclass(frozen=True)
class SimdBatch:
    """Calls of one function, one a lane; `calls` may be fewer than `width`: the last one fills the other lanes.

    `shared`: input blocks that are one and the same in all calls that could stand side by side.
    """

    calls: tuple[Sym, ...]
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
    """Lanes for n equal calls: a power of two, so that code exists for few widths."""
    return WIDEST if n > WIDEST // 2 else 4 if n > 2 else n


def arranged(nodes: Sequence[Sym]) -> list[Sym | SimdBatch]:
    """The nodes of a recording with equal independent calls batched, each after what it needs."""
    batches = list(_batches(nodes))
    while True:
        at = {call: batch for batch in batches for call in batch.calls}
        order, stuck = _ordered(nodes, at)
        if stuck is None:
            return order
        batches.remove(stuck)


def _batches(nodes: Sequence[Sym]) -> Iterator[SimdBatch]:
    """Calls of a function on the same rung of its ladder: none of them needs another."""
    rungs: dict[Sym, dict[Function, int]] = {}
    groups: dict[tuple[Function, int], list[Sym]] = {}
    for n in nodes:
        rung: dict[Function, int] = {}
        for x in operands(n):
            below = rungs[x]
            if below is not rung and below:
                rung = {f: max(rung.get(f, 0), below.get(f, 0)) for f in (*rung, *below)} if rung else below
        if n.op == "call":
            f = n.args[0]
            rung = {**rung, f: rung.get(f, 0) + 1}
            if _scalar(f):
                groups.setdefault((f, rung[f]), []).append(n)
        rungs[n] = rung
    for (f, _), calls in groups.items():
        width = width_of(len(calls))
        if width > 1 and CROWDED * width > _inside(f):
            shared = _shared(calls)
            yield from (SimdBatch(tuple(calls[i : i + width]), width, shared) for i in range(0, len(calls), width))


def _inside(f: Function) -> int:
    """Lanes that equal calls within one call of f fill."""
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
    """Whether a function is made of scalars alone, so that lanes can stand for them."""
    return not (f.rows or f.vectors) and all(
        n.width == 0 and n.op not in ("slice", "dot") and (n.op != "call" or _scalar(n.args[0])) for n in f.nodes
    )


def _ordered(nodes: Sequence[Sym], at: dict[Sym, SimdBatch]) -> tuple[list[Sym | SimdBatch], SimdBatch | None]:
    """Depth first, a batch behind all that its calls need; a batch that needs itself in the end is returned."""
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
