"""Loops over vectors of eight numbers for arithmetic on whole states, so that the code does not grow with the state.

Elementwise operations between two calls become one loop. Results needed outside it are kept in memory; comparisons are
recomputed where they are needed. Every number passes through the operations of unrolled code in the same order, also in
dot products: the bits are those of unrolled code.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol

from .function import Function, operands, placed
from .simd_batches import WIDEST, SimdBatch, constant, vector_type
from .symbol import Sym, is_sym

UNROLLED = 256  # numbers of the longest value whose arithmetic is written out
_FLAGS = ("gt", "ge", "and", "or")
_MOVED = ("call", "dot", "ret", "slice", "in", "block")


def is_long(x: Any) -> bool:
    """Return whether a traced value is a vector so long that it is processed in loops."""
    return is_sym(x) and x.width > UNROLLED


class VectorEmitter(Protocol):
    """Interface of a code emitter, as far as `Wide` uses it; `head` and `body`: the lines of LLVM IR emitted so far."""

    head: list[str]
    body: list[str]

    def operation(self, n: Sym, piece: str, lanes: int) -> str: ...


class Wide:
    """Emitter of loops for the long vectors of one traced function; decides which vectors share a loop."""

    def __init__(self, code: VectorEmitter, f: Function, order: Sequence[Sym | SimdBatch]) -> None:
        self._code = code
        self._loops = 0
        self._group: dict[Sym, int] = {}
        self._kept: set[Sym] = set()
        self._pending: list[Sym] = []
        self._copies: dict[Sym, str] = {}
        number = 0
        for n in order:
            if isinstance(n, SimdBatch) or n.op in ("call", "dot"):
                number += 1
            elif is_long(n) and n.op not in _MOVED:
                self._group[n] = number
        for n in order if self._group else ():
            for call in n.calls if isinstance(n, SimdBatch) else (n,):
                self._keep((x for x in operands(call)), self._group.get(call))
        written = (x for name, v in f.outputs.items() for x, kept in placed(name, v) if not kept and is_sym(x))
        self._keep(written, None)

    def _keep(self, used: Iterable[Sym], group: int | None) -> None:
        """Mark as kept in memory the values that another loop, or code outside of loops, uses."""
        for x in used:
            if x in self._group and (group is None or self._group[x] != group):
                if x.op in _FLAGS:
                    self._keep((y for y in x.args if isinstance(y, Sym)), None)
                else:
                    self._kept.add(x)

    def later(self, n: Sym) -> bool:
        """Postpone operation n on long vectors to the next loop; return False if n is not computed in loops."""
        if n in self._group:
            self._pending.append(n)
            return True
        return False

    def address(self, x: Sym) -> tuple[str, int]:
        """Return the pointer and the first index of a long vector in memory."""
        if x in self._copies:
            return self._copies[x], 0
        if x.op == "slice":
            return f"%{x.args[0]}", x.args[1]
        if x.op == "ret":
            return f"%r{x.args[0].id}_{x.args[1]}", x.args[2]
        return f"%m{x.id}", 0

    def flush(self) -> None:
        """Emit one loop for all operations that `later` has postponed since the last loop."""
        nodes, self._pending = self._pending, []
        for n in nodes:
            if n in self._kept:
                self._code.head.append(f"%m{n.id} = alloca [{n.width} x double], align 64")
        for width in dict.fromkeys(n.width for n in nodes):
            same = [n for n in nodes if n.width == width]

            def block(piece: str, lanes: int, at: str, same: list[Sym] = same) -> list[str]:
                lines: list[str] = []
                ready: set[Sym] = set()
                for n in same:
                    self._make(n, set(same), ready, lines, piece, lanes, at)
                    if n in self._kept:
                        lines += self._stored(n, f"%m{n.id}", 0, piece, lanes, at)
                return lines

            self._loop(width, block)

    def copy(self, x: Sym, base: str, first: int) -> None:
        """Emit the loop that copies a vector with many elements into a block."""

        def block(piece: str, lanes: int, at: str) -> list[str]:
            lines: list[str] = []
            self._make(x, set(), set(), lines, piece, lanes, at)
            return lines + self._stored(x, base, first, piece, lanes, at)

        self._loop(x.width, block)

    def save(self, x: Sym) -> None:
        """Emit a copy of a part of a block that is about to be overwritten but is still needed."""
        if x.op == "slice" and x not in self._copies:
            name = f"%c{x.id}"
            self._code.head.append(f"{name} = alloca [{x.width} x double], align 64")
            self.copy(x, name, 0)
            self._copies[x] = name

    def dot(self, n: Sym) -> None:
        """Emit a dot product, summed in groups of eight products."""

        def block(piece: str, lanes: int, at: str) -> list[str]:
            lines: list[str] = []
            ready: set[Sym] = set()
            for x in n.args:
                self._make(x, set(), ready, lines, piece, lanes, at)
            a, b = (f"%t{x.id}{piece}" for x in n.args)
            v, t = vector_type(lanes), f"%t{n.id}{piece}"
            return [
                *lines,
                f"{t}m = fmul {v} {a}, {b}",
                f"{t}r = call double @llvm.vector.reduce.fadd.v{lanes}f64(double {constant(0.0)}, {v} {t}m)",
                f"{t}o = load double, ptr %m{n.id}, align 8",
                f"{t}n = fadd double {t}o, {t}r",
                f"store double {t}n, ptr %m{n.id}, align 8",
            ]

        self._code.head.append(f"%m{n.id} = alloca double, align 8")
        self._code.body.append(f"store double {constant(0.0)}, ptr %m{n.id}, align 8")
        self._loop(n.args[0].width, block)
        self._code.body.append(f"%t{n.id} = load double, ptr %m{n.id}, align 8")

    def _make(
        self, x: Sym, inside: set[Sym], ready: set[Sym], lines: list[str], piece: str, lanes: int, at: str
    ) -> None:
        """Emit eight numbers of x: computed in this loop if x is in `inside`, loaded otherwise."""
        if x in ready:
            return
        ready.add(x)
        t = f"%t{x.id}{piece}"
        if x not in inside and x.op not in _FLAGS:
            base, first = self.address(x)
            lines += [
                f"{t}p = getelementptr double, ptr {base}, i64 {first}",
                f"{t}q = getelementptr double, ptr {t}p, i64 {at}",
                f"{t} = load {vector_type(lanes)}, ptr {t}q, align 8",
            ]
            return
        for y in x.args:
            if is_long(y):
                self._make(y, inside, ready, lines, piece, lanes, at)
        lines.append(f"{t} = {self._code.operation(x, piece, lanes)}")

    def _stored(self, x: Sym, base: str, first: int, piece: str, lanes: int, at: str) -> list[str]:
        s = f"%s{x.id}{piece}"
        return [
            f"{s}p = getelementptr double, ptr {base}, i64 {first}",
            f"{s}q = getelementptr double, ptr {s}p, i64 {at}",
            f"store {vector_type(lanes)} %t{x.id}{piece}, ptr {s}q, align 8",
        ]

    def _loop(self, width: int, block: Callable[[str, int, str], list[str]]) -> None:
        """Emit a loop that runs `block` over groups of eight numbers, and then over the remainder."""
        self._loops += 1
        k = f"w{self._loops}"
        whole = width - width % WIDEST
        lines = [
            f"br label %{k}.head",
            f"{k}.head:",
            f"br label %{k}.loop",
            f"{k}.loop:",
            f"%{k} = phi i64 [0, %{k}.head], [%{k}.next, %{k}.loop]",
            *block(f"_{k}", WIDEST, f"%{k}"),
            f"%{k}.next = add i64 %{k}, {WIDEST}",
            f"%{k}.more = icmp slt i64 %{k}.next, {whole}",
            f"br i1 %{k}.more, label %{k}.loop, label %{k}.end",
            f"{k}.end:",
        ]
        if width > whole:
            lines += block(f"_{k}r", width - whole, str(whole))
        self._code.body.append("\n".join(lines))
