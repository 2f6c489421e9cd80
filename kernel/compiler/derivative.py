"""Derivatives of traced functions by forward-mode differentiation, for all directions at once.

Every node has its value and its derivatives along k directions. Rounding to a whole number has derivative zero; a
condition keeps its present value. (Griewank, Walther, Evaluating Derivatives, 2008, chapter 3.)
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from .function import Function, Primitive, flatten
from .symbol import Sym, exponent, is_sym, power_of_two

Dual = tuple[Any, Any]  # a number or (n,) of them; its derivatives (k,) or (n, k), None where all are zero
WHOLE = 2.0**51  # a constant that leaves no fraction in a sum: the sum steps, it does not move


def derivatives(
    f: Function, values: Mapping[str, np.ndarray], seeds: Mapping[str, np.ndarray]
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the outputs (n,) of a traced function, each with its derivatives (n, k) in k directions.

    `values`: inputs by name; `seeds`: their derivatives (n, k) in these directions.
    """
    k = next(iter(seeds.values())).shape[1]
    given = {
        name: [(float(x), seeds[name][i] if name in seeds and seeds[name][i].any() else None) for i, x in enumerate(X)]
        for name, X in values.items()
    }
    with np.errstate(all="ignore"):
        out = _called(f, given)
    zero = np.zeros(k)
    return {
        name: (
            np.array([float(x) for x, _ in found]),
            np.array([zero if d is None else d for _, d in found]).reshape(len(found), k),
        )
        for name, found in out.items()
    }


def _called(f: Function, blocks: Mapping[str, list[Dual]]) -> dict[str, list[Dual]]:
    assert not isinstance(f, Primitive), f"'{f.name}' is machine code without symbols"
    at: dict[Sym, Any] = {}

    def dual(x: Any) -> Dual:
        return at[x] if is_sym(x) else (x, None)

    def block(values: Any) -> list[Dual]:
        out: list[Dual] = []
        for x in flatten(values):
            if is_sym(x) and x.op == "block":
                return blocks[x.args[0]]
            value, d = dual(x)
            if np.ndim(value):
                out += [(float(e), None if d is None else d[i]) for i, e in enumerate(value)]
            else:
                out.append((value, d))
        return out

    for n in f.nodes:
        if n.op == "call":
            called, *given = n.args
            at[n] = _called(called, {k: block(v) for k, v in zip(called.inputs, given, strict=True)})
        elif n.op in ("in", "slice", "ret"):
            source = at[n.args[0]][n.args[1]] if n.op == "ret" else blocks[n.args[0]]
            first = n.args[-1]
            at[n] = _stacked(source[first : first + n.width]) if n.width else source[first]
        elif n.op != "block":
            at[n] = _operation(n, [dual(x) for x in n.args])
    return {name: block(values) for name, values in f.outputs.items()}


def _stacked(parts: list[Dual]) -> Dual:
    value = np.array([x for x, _ in parts])
    some = next((d for _, d in parts if d is not None), None)
    return value, None if some is None else np.array([np.zeros_like(some) if d is None else d for _, d in parts])


def _operation(n: Sym, x: list[Dual]) -> Dual:
    (a, da), (b, db) = x[0], x[1] if len(x) > 1 else x[0]
    value: Any
    parts: list[Any] = []
    match n.op:
        case "add" | "sub":
            value = a + b if n.op == "add" else a - b
            if not any(not is_sym(c) and abs(c) >= WHOLE for c in n.args):
                parts = [_times(da, 1.0), _times(db, 1.0 if n.op == "add" else -1.0)]
        case "neg":
            value, parts = -a, [_times(da, -1.0)]
        case "mul":
            value, parts = a * b, [_times(da, b), _times(db, a)]
        case "div":
            value = np.divide(a, b)
            parts = [_times(da, np.divide(1.0, b)), _times(db, np.divide(-value, b))]
        case "dot":
            value = float(a @ b)
            return value, _sum([b @ da if da is not None else None, a @ db if db is not None else None])
        case "sqrt":
            value = np.sqrt(a)  # at zero it counts as flat, as a distance of zero does
            parts = [_times(da, np.where(value > 0.0, np.divide(0.5, value), 0.0))]
        case "abs":
            value, parts = abs(a), [_times(da, np.sign(a))]
        case "select":
            value = np.where(a, b, x[2][0]) if np.ndim(a) else b if a else x[2][0]
            parts = [_where(a, db), _where(np.logical_not(a), x[2][1])] if np.ndim(a) else [db if a else x[2][1]]
        case "gt" | "ge":
            value = np.greater(a, b) if n.op == "gt" else np.greater_equal(a, b)
        case "and" | "or":
            value = np.logical_and(a, b) if n.op == "and" else np.logical_or(a, b)
        case _:
            value = {"exponent": exponent, "power_of_two": power_of_two}[n.op](a)
    d = _sum(parts)
    if d is not None and np.ndim(value) and d.ndim == 1:
        d = np.broadcast_to(d, (len(value), len(d)))
    return value, d


def _times(d: Any, factor: Any) -> Any:
    """Return derivatives times a number or (n,) numbers; zero derivatives stay zero even if the number is infinite."""
    if d is None:
        return None
    scaled = d * np.reshape(factor, (-1, 1)) if np.ndim(factor) else d * float(factor)
    return scaled if np.isfinite(factor).all() else np.where(d == 0.0, 0.0, scaled)


def _where(there: Any, d: Any) -> Any:
    return None if d is None else np.where(np.reshape(there, (-1, 1)), d, 0.0)


def _sum(parts: list[Any]) -> Any:
    found = [d for d in parts if d is not None]
    return None if not found else found[0] if len(found) == 1 else found[0] + found[1]
