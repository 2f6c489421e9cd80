"""Recorded functions -> LLVM IR text: straight-line code, and one loop construct around it.

Every function takes pointers to blocks of doubles.  Arithmetic is strict IEEE (no contraction, no reassociation
except inside dot products of fixed lanes), so that the bits are the same at every optimisation level.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

from .function import Function, placed
from .symbol import Sym, is_sym

__all__ = ["While", "module"]

LANES = 8  # vectors are emitted in pieces of 8 doubles

_DECLARE = [
    "declare double @llvm.sqrt.f64(double)",
    "declare double @llvm.fabs.f64(double)",
    *(
        f"declare <{w} x double> @llvm.fabs.v{w}f64(<{w} x double>)\n"
        f"declare double @llvm.vector.reduce.fadd.v{w}f64(double, <{w} x double>)"
        for w in range(1, LANES + 1)
    ),
]
_ARITHMETIC = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}


@dataclass(frozen=True)
class While:
    """Repeat the parts (functions or loops) while block[flag] > 0."""

    name: str
    flag: int
    parts: tuple[Function | While, ...]
    block: str = "X"

    @property
    def blocks(self) -> list[str]:
        return list(dict.fromkeys(b for p in self.parts for b in blocks(p)))


def blocks(f: Function | While) -> list[str]:
    """Names of the memory blocks of a function, in the order of its pointer arguments."""
    return f.blocks if isinstance(f, While) else list(dict.fromkeys([*f.inputs, *f.outputs]))


def module(*functions: Function | While) -> str:
    """IR text of functions and loops and of everything that they call."""
    order: list[Function | While] = []
    seen: set[str] = set()

    def visit(f: Function | While) -> None:
        if f.name in seen:
            return
        seen.add(f.name)
        parts = f.parts if isinstance(f, While) else [n.args[0] for n in f.nodes if n.op == "call"]
        for g in parts:
            visit(g)
        order.append(f)

    for f in functions:
        visit(f)
    return "\n".join([*_DECLARE, *(_loop(f) if isinstance(f, While) else _Emitter(f).text() for f in order)])


def _loop(w: While) -> str:
    parameters = ", ".join(f"ptr %{k}" for k in w.blocks)
    calls = "\n".join(f"  call void @{p.name}({', '.join(f'ptr %{k}' for k in blocks(p))})" for p in w.parts)
    return f"""define void @{w.name}({parameters}) {{
  %p = getelementptr double, ptr %{w.block}, i64 {w.flag}
  br label %head
head:
  %f = load double, ptr %p
  %go = fcmp ogt double %f, 0.0
  br i1 %go, label %body, label %exit
body:
{calls}
  br label %head
exit:
  ret void
}}"""


def _constant(x: float) -> str:
    (bits,) = struct.unpack("<Q", struct.pack("<d", float(x)))
    return f"0x{bits:016X}"


def _ref(x: Any) -> str:
    return f"%t{x.id}" if is_sym(x) else _constant(x)


def _width(x: Any) -> int:
    return max(1, x.width) if is_sym(x) else 1


def _pieces(x: Sym) -> list[tuple[str, int, int]]:
    """Suffix, offset and lanes of each piece of a value; one piece of 0 lanes for a scalar."""
    if not x.width:
        return [("", 0, 0)]
    return [(f"_{i}", i * LANES, min(LANES, x.width - i * LANES)) for i in range(-(-x.width // LANES))]


def _type(lanes: int, element: str = "double") -> str:
    return f"<{lanes} x {element}>" if lanes else element


class _Emitter:
    """Straight-line code of one recorded function."""

    def __init__(self, f: Function) -> None:
        self.f = f
        self.head: list[str] = []
        self.body: list[str] = []
        self.splats = 0

    def text(self) -> str:
        f = self.f
        for n in f.nodes:
            self.node(n)
        for name, values in f.outputs.items():
            base = f"%{name}"
            if name in f.rows:  # a row of a table
                size = sum(map(_width, values))
                self.body += [
                    f"%row_{name} = fptosi double {_ref(f.rows[name])} to i64",
                    f"%first_{name} = mul i64 %row_{name}, {size}",
                    f"%base_{name} = getelementptr double, ptr %{name}, i64 %first_{name}",
                ]
                base = f"%base_{name}"
            self.store(placed("" if name in f.rows else name, values), base, f"o_{name}")
        parameters = ", ".join(f"ptr noalias %{k}" for k in blocks(f))
        lines = [
            f"define void @{f.name}({parameters}) noinline nounwind {{",
            *self.head,
            *self.body,
            "ret void",
            "}",
        ]
        return "\n".join(lines)

    def load(self, n: Sym, base: str, index: int) -> None:
        for piece, offset, lanes in _pieces(n):
            self.body += [
                f"%g{n.id}{piece} = getelementptr double, ptr {base}, i64 {index + offset}",
                f"%t{n.id}{piece} = load {_type(lanes)}, ptr %g{n.id}{piece}, align 8",
            ]

    def store(self, values: list[tuple[Any, bool]], base: str, tag: str) -> None:
        """Write values one after the other, except those that stand there already."""
        i = 0
        for x, kept in values:
            for piece, offset, lanes in [] if kept else _pieces(x) if is_sym(x) else [("", 0, 0)]:
                self.body += [
                    f"%{tag}_{i + offset} = getelementptr double, ptr {base}, i64 {i + offset}",
                    f"store {_type(lanes)} {_ref(x)}{piece}, ptr %{tag}_{i + offset}, align 8",
                ]
            i += _width(x)

    def operand(self, x: Any, piece: str, lanes: int) -> str:
        """One piece of an operand; scalars are spread over the lanes."""
        if not lanes or (is_sym(x) and x.width):
            return _ref(x) + (piece if is_sym(x) and x.width else "")
        self.splats += 1
        k, v = f"%s{self.splats}", _type(lanes)
        self.body += [
            f"{k}a = insertelement {v} poison, double {_ref(x)}, i64 0",
            f"{k} = shufflevector {v} {k}a, {v} poison, <{lanes} x i32> zeroinitializer",
        ]
        return k

    def pointer(self, values: tuple[Any, ...], tag: str) -> str:
        """Address of consecutive values: where they already lie so in a block, else a copy on the stack."""
        v: Any = values[0] if values else None
        if (
            is_sym(v)
            and v.op in ("in", "ret", "slice")
            and all(
                is_sym(x) and x.op == v.op and x.args[:-1] == v.args[:-1] and x.args[-1] == v.args[-1] + i
                for i, x in enumerate(values)
            )
        ):
            base = f"%r{v.args[0].id}_{v.args[1]}" if v.op == "ret" else f"%{v.args[0]}"
            self.body.append(f"%{tag} = getelementptr double, ptr {base}, i64 {v.args[-1]}")
        else:
            size = max(1, sum(map(_width, values)))
            self.head.append(f"%{tag} = alloca [{size} x double], align 64")
            self.store([(x, False) for x in values], f"%{tag}", tag)
        return f"ptr %{tag}"

    def node(self, n: Sym) -> None:
        a = n.args
        if n.op in ("in", "slice"):
            self.load(n, f"%{a[0]}", a[1])
        elif n.op == "ret":
            self.load(n, f"%r{a[0].id}_{a[1]}", a[2])
        elif n.op == "call":
            self.call(n)
        elif n.op == "dot":
            self.dot(n)
        else:
            for piece, _, lanes in _pieces(n):
                self.body.append(f"%t{n.id}{piece} = {self.operation(n, piece, lanes)}")

    def operation(self, n: Sym, piece: str, lanes: int) -> str:
        a, d = n.args, _type(lanes)
        x = [self.operand(y, piece, lanes) if not (n.op == "select" and i == 0) else "" for i, y in enumerate(a)]
        if n.op == "select":
            wide = a[0].width
            return f"select {_type(wide and lanes, 'i1')} {_ref(a[0])}{piece if wide else ''}, {d} {x[1]}, {d} {x[2]}"
        if n.op in ("gt", "ge"):
            return f"fcmp o{n.op} {d} {x[0]}, {x[1]}"
        if n.op in ("and", "or"):
            return f"{n.op} {_type(lanes, 'i1')} {x[0]}, {x[1]}"
        if n.op == "neg":
            return f"fneg {d} {x[0]}"
        if n.op in ("exponent", "power_of_two"):
            return self.binary_exponent(n, x[0])
        if n.op in ("sqrt", "abs"):
            suffix = f"v{lanes}" if lanes else ""
            return f"call {d} @llvm.{'fabs' if n.op == 'abs' else n.op}.{suffix}f64({d} {x[0]})"
        return f"{_ARITHMETIC[n.op]} {d} {x[0]}, {x[1]}"

    def binary_exponent(self, n: Sym, x: str) -> str:
        """Exponent of a double as a number, or the double that has a given one: its bits 52 to 62, less 1023."""
        b = f"%b{n.id}"
        if n.op == "exponent":
            self.body += [f"{b} = bitcast double {x} to i64", f"{b}s = lshr i64 {b}, 52", f"{b}k = sub i64 {b}s, 1023"]
            return f"sitofp i64 {b}k to double"
        self.body += [f"{b} = fptosi double {x} to i64", f"{b}k = add i64 {b}, 1023", f"{b}s = shl i64 {b}k, 52"]
        return f"bitcast i64 {b}s to double"

    def call(self, n: Sym) -> None:
        f, *arguments = n.args
        at = {k: self.pointer(v, f"a{n.id}_{k}") for k, v in zip(f.inputs, arguments, strict=True)}
        for k, v in f.outputs.items():
            self.head.append(f"%r{n.id}_{k} = alloca [{max(1, sum(map(_width, v)))} x double], align 64")
            at[k] = f"ptr %r{n.id}_{k}"
        self.body.append(f"call void @{f.name}({', '.join(at[k] for k in blocks(f))})")

    def dot(self, n: Sym) -> None:
        total, t = _constant(0.0), f"%t{n.id}"
        last = len(_pieces(n.args[0])) - 1
        for i, (piece, _, lanes) in enumerate(_pieces(n.args[0])):
            v, result = _type(lanes), t if i == last else f"{t}s{i}"
            a, b = (self.operand(x, piece, lanes) for x in n.args)
            self.body += [
                f"{t}m{i} = fmul {v} {a}, {b}",
                f"{t}r{i} = call double @llvm.vector.reduce.fadd.v{lanes}f64(double {_constant(0.0)}, {v} {t}m{i})",
                f"{result} = fadd double {total}, {t}r{i}",
            ]
            total = result
