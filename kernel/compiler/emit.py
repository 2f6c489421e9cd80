"""Recorded functions -> LLVM IR text: straight-line code, and one loop construct around it.

Every function takes pointers to blocks of doubles.  Arithmetic is strict IEEE (no reassociation except inside dot
products of fixed lanes, no contraction unless asked for), so that the bits are the same at every optimisation level.
"""

from __future__ import annotations

from dataclasses import dataclass

from .function import Function, Primitive
from .llvm_function import StraightLineCode, blocks_of, named_code
from .simd_batches import WIDEST

_DECLARE = [
    "declare double @llvm.sqrt.f64(double)",
    "declare double @llvm.fabs.f64(double)",
    *(
        f"declare <{w} x double> @llvm.fabs.v{w}f64(<{w} x double>)\n"
        f"declare <{w} x double> @llvm.sqrt.v{w}f64(<{w} x double>)\n"
        f"declare double @llvm.vector.reduce.fadd.v{w}f64(double, <{w} x double>)"
        for w in range(1, WIDEST + 1)
    ),
]


class EmittedParts:
    """Functions, sequences and loops that make up one native function."""

    name: str
    parts: tuple[Function | EmittedParts, ...]

    @property
    def blocks(self) -> list[str]:
        return list(dict.fromkeys(b for p in self.parts for b in blocks(p)))


@dataclass(frozen=True)
class Sequence(EmittedParts):
    """The parts one after the other."""

    name: str
    parts: tuple[Function | EmittedParts, ...]


@dataclass(frozen=True)
class While(EmittedParts):
    """Repeat the parts while block[flag] > 0."""

    name: str
    flag: int
    parts: tuple[Function | EmittedParts, ...]
    block: str = "X"


def blocks(f: Function | EmittedParts) -> list[str]:
    """Names of the memory blocks of a function, in the order of its pointer arguments."""
    return f.blocks if isinstance(f, EmittedParts) else blocks_of(f)


def module(*functions: Function | EmittedParts, fused: bool = False) -> str:
    """IR text of functions and loops and of everything that they call; `fused`: see `StraightLineCode`."""
    texts: list[str] = []
    seen: dict[str, Function | EmittedParts] = {}

    def visit(f: Function | EmittedParts, lanes: int, shared: frozenset[str] = frozenset()) -> None:
        name = f.name if isinstance(f, EmittedParts) else named_code(f, lanes, shared)
        if name in seen:
            assert seen[name] is f, f"two functions are called '{name}'"
            return
        seen[name] = f
        if isinstance(f, EmittedParts):
            for part in f.parts:
                visit(part, 0)
            texts.append(_sequence(f))
            return
        if isinstance(f, Primitive):
            texts.append(f.text)
            return
        code = StraightLineCode(f, lanes, fused, shared)
        texts.append(code.text())
        for called in code.called:
            visit(*called)

    for f in functions:
        visit(f, 0)
    return "\n".join([*_DECLARE, *texts])


def _sequence(w: EmittedParts) -> str:
    parameters = ", ".join(f"ptr %{k}" for k in w.blocks)
    calls = "\n".join(f"  call void @{p.name}({', '.join(f'ptr %{k}' for k in blocks(p))})" for p in w.parts)
    if not isinstance(w, While):
        return f"define void @{w.name}({parameters}) {{\n{calls}\n  ret void\n}}"
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
