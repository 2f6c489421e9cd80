"""User-defined laws: plain Python functions, traced like the kernel's own code.

A law is named "package.module:function" or "file.py:function", so that it is data and crosses processes. The law is
called as `law(x)` with the fields of `LawInput` and returns the effort along its joint, or a force (3,) or force and
moment (6,) in world axes for each end. Its power on bodies counts as work of the law. The law is traced when the scene
is compiled; the digest of its operations is part of the structure, so an edited law never runs as an old object file.
"""

import hashlib
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, is_sym
from heavylift.kernel.description.forces import UserLaw
from heavylift.kernel.description.user_code import imported
from heavylift.kernel.errors import KernelError
from heavylift.kernel.trust import foreign, namer, refusal

from .force_law import BODY, ForceLaw, LawOutput, Poses, SampledQuantity, attachment, wrench

MATHEMATICS = "heavylift.kernel.forces.mathematics"
CONDITIONS = ("gt", "ge", "and", "or")  # operations whose result is no number


@dataclass(frozen=True)
class LawInput:
    """Argument of a user-defined law: time [s], the motion of its joint and of its end bodies, and its parameters."""

    t: Scalar
    parameters: Array  # (n,)
    signal: Scalar
    modes: Array  # (n,)
    q: Any = None
    dq: Any = None
    p: Any = None  # (ends, 3)
    v: Any = None  # (ends, 3)
    R: Any = None  # (ends, 3, 3)
    w: Any = None  # (ends, 3)


class UserLawEntry(ForceLaw[UserLaw]):
    """Force law that evaluates a Python function written by a user, which is traced once as a check.

    Its parameters are the user's parameters and modes.
    """

    works = True
    timed = True

    def check(self, f: UserLaw) -> None:
        self.demand(f, "joint", bool(f.joint) != bool(f.ends), "and ends: it must act on either of them, not on both")
        law = self._traced(f)
        message = _wrong(law)
        if message:
            raise KernelError(f"law '{f.name}': '{f.function}' {message}")
        if _digest(self._traced(f)) != _digest(law):
            raise KernelError(
                f"law '{f.name}': '{f.function}' gives different results when it is called again; a law may "
                "depend only on its arguments, not on random numbers, clocks or stored values"
            )

    def shape(self, f: UserLaw) -> tuple[int, str]:
        return f.modes, _digest(self._traced(f))

    def numbers(self, f: UserLaw, poses: Poses) -> list[float]:
        return [*f.parameters, *[1.0] * f.modes, *(c for e in f.ends for c in e.p)]

    def answer(self, f: UserLaw, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        n, m = len(f.parameters), len(f.parameters) + f.modes
        modes = p[n:m]
        at = [attachment(body, p[m + 3 * i : m + 3 * i + 3], f"a{i + 1}") for i, body in enumerate(ends)]
        stacked = {
            "p": _stack([place for _, place, _ in at]),
            "v": _stack([v for _, _, v in at]),
            "R": _stack([np.reshape(body[:9], (3, 3)) for body in ends]),
            "w": _stack([body[15:18] for body in ends]),
        }
        q, dq = joint if f.joint else (None, None)
        given = LawInput(t, p[:n], signal[0], modes, q, dq, **(stacked if ends else {}))
        answer = _called(f, f.function, given)
        guards = _called(f, f.guards, given) if f.guards else []
        values = _numbers(guards)
        if values is None or len(values) != f.modes:
            raise KernelError(
                f"law '{f.name}': '{f.guards}' must return a list of {f.modes} numbers, one for each mode"
            )
        switched = [mode * g for mode, g in zip(modes, values, strict=True)]
        if dq is not None:
            effort = _numbers([answer])
            if effort is None or len(effort) != 1:
                raise KernelError(f"law '{f.name}': '{f.function}' must return one number, the effort along its joint")
            return LawOutput(effort=effort[0], work=effort[0] * dq, guards=switched, shown=effort)
        rows = np.array(answer, dtype=object)
        if rows.shape not in ((len(ends), 3), (len(ends), 6)) or _numbers(rows) is None:
            raise KernelError(
                f"law '{f.name}': '{f.function}' must return a force of 3 numbers, or force and moment of 6, for each "
                f"of its {len(ends)} ends"
            )
        wrenches, work = [], 0.0
        for (x, _, v), body, row in zip(at, ends, rows, strict=True):
            moment = row[3:] if len(row) == 6 else None
            wrenches.append(wrench(x, row[:3], moment))
            work = work + row[:3] @ v + (0.0 if moment is None else moment @ body[15:18])
        return LawOutput(wrenches, work=work, guards=switched, shown=[x for row in rows for x in row[:3]])

    def guards(self, f: UserLaw) -> tuple[str, ...]:
        return tuple(f"mode {i + 1}" for i in range(f.modes))

    def switch(self, f: UserLaw, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        i = len(f.parameters) + self.guards(f).index(guard)
        p[i] = -p[i]
        return "switched", float(p[i])

    def shows(self, f: UserLaw) -> list[SampledQuantity]:
        if f.joint:
            return [SampledQuantity("law/effort", f.name, "N or N m")]
        return [SampledQuantity("law/force", f"{f.name}.{i + 1}.{c}", "N") for i in range(len(f.ends)) for c in "xyz"]

    def _traced(self, f: UserLaw) -> Function:
        """Return the law traced on its own."""
        blocks = {"p": len(self.numbers(f, lambda body: (np.eye(3), np.zeros(3)))), "s": 2, "x": 2, "t": 1}
        blocks |= {f"e{i}": BODY for i in range(len(f.ends))}

        def body(p: Array, s: Scalars, x: Scalars, t: Array, **bodies: Array) -> Outputs:
            ends = [bodies[f"e{i}"] for i in range(len(f.ends))]
            a = self.answer(f, p, ends, s, x, t[0])
            return {"effort": [a.effort], "guards": a.guards, **{f"w{i}": w for i, w in enumerate(a.wrenches)}}

        law = Function(f.name, body, blocks)
        law.record()
        return law


def _stack(rows: list[Scalars]) -> Array:
    return np.array([np.asarray(r, dtype=object) for r in rows], dtype=object)


def _numbers(values: object) -> list[Scalar] | None:
    """Return the values if all are numbers or traced scalars, else None."""
    try:
        flat = np.ravel(np.array(values, dtype=object)).tolist()
    except ValueError:
        return None
    good = all((is_sym(x) and not x.width) or isinstance(x, float | int | np.number) for x in flat)
    return [x if is_sym(x) else float(x) for x in flat] if good else None


def _called(f: UserLaw, function: str, given: LawInput) -> object:
    """Call the user's function; exceptions become one-sentence errors with their line."""
    law = _found(f, function)
    try:
        return law(given)
    except Exception as e:
        file = law.__code__.co_filename if hasattr(law, "__code__") else ""
        lines = [x for x in traceback.extract_tb(e.__traceback__) if x.filename == file]
        where = f"{Path(file).name}:{lines[-1].lineno}" if lines else function
        message = str(e)
        if (
            "no callable" in message
            or "must be real number" in message
            or "ufunc" in message
            or "forced to a float" in message
        ):
            message = f"math and NumPy cannot work on a run-time value: use those of {MATHEMATICS}"
        raise KernelError(f"law '{f.name}': '{function}' at {where}: {message}") from e


def _found(f: UserLaw, function: str) -> Callable[[LawInput], object]:
    """Return the user's function. If data, not code, named the function, its folder must be trusted."""
    module, colon, name = function.rpartition(":")
    if not (colon and module and name):
        raise KernelError(f"law '{f.name}': '{function}' is not a function reference; write 'package.module:function'")
    by = namer(function)
    if by is not None and (why := refusal(module, function)):
        raise KernelError(f"{by}{': ' if by else ''}law '{f.name}': {why}")
    try:
        found = getattr(_module(module), name, None)
    except Exception as e:
        raise KernelError(f"law '{f.name}': '{module}' cannot be imported: {e}") from e
    if not callable(found):
        raise KernelError(f"law '{f.name}': there is no function '{name}' in '{module}'")
    if by is not None and (why := foreign(found, function)):
        raise KernelError(f"{by}{': ' if by else ''}law '{f.name}': '{function}' must not be called: {why}")
    return found  # type: ignore[no-any-return]


def _module(name: str) -> ModuleType:
    """Import a module by name or file; a file gets a name of its own, so that it cannot clash with another module."""
    path = Path(name).resolve()  # as it was checked
    return imported(name, f"heavylift_law_{hashlib.sha256(str(path).encode()).hexdigest()[:16]}")


def _wrong(law: Function) -> str:
    """Return why a traced law cannot be computed; "" if it can."""
    written = [x for values in law.outputs.values() for x in values]
    if any(isnan(x) for x in (*written, *(a for n in law.nodes for a in n.args)) if isinstance(x, float)):
        return "computes with nan; give it finite numbers"
    used = [
        (x, n.op in ("and", "or") or (n.op == "select" and i == 0)) for n in law.nodes for i, x in enumerate(n.args)
    ]
    for x, wants in (*used, *((x, False) for x in written)):
        if is_sym(x) and wants != (x.op in CONDITIONS):
            message = "a number is not a condition" if wants else "a condition is not a number"
            return f"computes where {message}: use select(condition, a, b) with > or >="
    return ""


def _digest(law: Function) -> str:
    """Return the fingerprint of a traced function, 16 hexadecimal digits."""
    names = {n: f"#{i}" for i, n in enumerate(law.nodes)}

    def written(x: Any) -> str:
        if isinstance(x, tuple | list):
            return "(" + ",".join(map(written, x)) + ")"
        return x.name if isinstance(x, Function) else names[x] if is_sym(x) else repr(x)

    lines = [f"{n.op}{written(n.args)}" for n in law.nodes] + [f"{k}={written(v)}" for k, v in law.outputs.items()]
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]
