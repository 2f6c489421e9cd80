"""Dense linear systems A x = b, real or complex, solved in native loops by LU factors with partial pivoting.

Right-looking elimination by columns (Golub, Van Loan, Matrix Computations, 3.4); the pivot is the first largest entry
of its column, so that the same numbers give the same bits.  Matrices lie column after column, `stride` apart; those of
complex systems in two planes.  Factors live in a block of doubles beside the state.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from .function import OPAQUE, Primitive
from .native_loops import VECTOR, LoopEmitter, padded
from .simd_batches import WIDEST

Number = list[str]  # registers of the real and, if there is one, the imaginary part


@dataclass(frozen=True)
class FactorLayout:
    """Memory layout of the LU factors of a real or complex matrix (n, n) in a block, from index `start`."""

    n: int
    planes: int  # 1 real, 2 complex
    start: int

    @property
    def stride(self) -> int:
        return padded(self.n)

    @property
    def matrix(self) -> list[int]:
        return [self.start + p * self.n * self.stride for p in range(self.planes)]

    @property
    def exchanges(self) -> int:
        return self.start + self.planes * self.n * self.stride

    @property
    def inverses(self) -> list[int]:
        return [self.exchanges + (1 + p) * self.stride for p in range(self.planes)]

    @property
    def stop(self) -> int:
        return self.exchanges + (1 + self.planes) * self.stride

    def factorise(self, c: LoopEmitter) -> None:
        """Emit the loops that replace the matrix in block M by its factors."""
        n, stride = self.n, self.stride
        planes = [c.at("%M", x) for x in self.matrix]
        largest, where = c.reserve("double"), c.reserve("i64")
        factors = [c.reserve(f"[{stride} x double]") for _ in planes]
        with c.loop(0, n) as k:
            column = [c.at(p, c.integer("mul", k, stride)) for p in planes]
            after, first = c.integer("add", k, 1), c.integer("and", c.integer("add", k, 1), -WIDEST)
            c.store(_size(c, [c.load(c.at(p, k)) for p in column]), largest)
            c.store(k, where, "i64")
            with c.loop(after, n) as i:
                size, best = _size(c, [c.load(c.at(p, i)) for p in column]), c.load(largest)
                better, there = c.let(f"fcmp ogt double {size}, {best}"), c.load(where, "i64")
                c.store(c.let(f"select i1 {better}, double {size}, double {best}"), largest)
                c.store(c.let(f"select i1 {better}, i64 {i}, i64 {there}"), where, "i64")
            pivot = c.load(where, "i64")
            c.store(c.let(f"sitofp i64 {pivot} to double"), c.at("%M", self.exchanges, k))
            with c.when(c.let(f"icmp ne i64 {pivot}, {k}")), c.loop(0, n) as j:
                start = c.integer("mul", j, stride)
                for p in planes:
                    _swap(c, c.at(p, start, k), c.at(p, start, pivot))
            inverse = _reciprocal(c, [c.load(c.at(p, k)) for p in column])
            for x, place in zip(inverse, self.inverses, strict=True):
                c.store(x, c.at("%M", place, k))
            wide = [c.spread(x) for x in inverse]
            with c.loop(first, stride, WIDEST) as i:
                below = c.lanes("sgt", i, k)
                old = [c.load(c.at(p, i), VECTOR) for p in column]
                for x, o, p, f in zip(times(c, old, wide, VECTOR), old, column, factors, strict=True):
                    c.store(c.keep(below, x, o), c.at(p, i), VECTOR)
                    c.store(c.keep(below, x), c.at(f, i), VECTOR)
            with c.loop(after, n) as j:
                other = [c.at(p, c.integer("mul", j, stride)) for p in planes]
                _less(c, other, [c.load(c.at(p, k)) for p in other], factors, first, stride)

    def solve(self, c: LoopEmitter, x: list[str]) -> None:
        """Emit the loops that overwrite b with the solution x of A x = b, from the factors of A in block M.

        x is `stride` long, with zeros after its first n numbers.
        """
        n, stride = self.n, self.stride
        planes = [c.at("%M", p) for p in self.matrix]
        with c.loop(0, n) as k:
            pivot = c.let(f"fptosi double {c.load(c.at('%M', self.exchanges, k))} to i64")
            for p in x:
                _swap(c, c.at(p, k), c.at(p, pivot))
        with c.loop(0, n) as k:
            column = [c.at(p, c.integer("mul", k, stride)) for p in planes]
            first = c.integer("and", c.integer("add", k, 1), -WIDEST)
            _less(c, x, [c.load(c.at(p, k)) for p in x], column, first, stride, ("sgt", k))
        with c.loop(n - 1, -1, -1) as k:
            column = [c.at(p, c.integer("mul", k, stride)) for p in planes]
            inverse = [c.load(c.at("%M", place, k)) for place in self.inverses]
            value = times(c, [c.load(c.at(p, k)) for p in x], inverse)
            for v, p in zip(value, x, strict=True):
                c.store(v, c.at(p, k))
            _less(c, x, value, column, "0", k, ("slt", k))

    # ---- the same on floats, for the oracle ----------------------------------------------------------------

    def read(self, M: np.ndarray) -> np.ndarray:
        """Return the (n, n) matrix, or its factors, stored in block M."""
        planes = [M[p : p + self.n * self.stride].reshape(self.n, self.stride)[:, : self.n].T for p in self.matrix]
        return planes[0] if self.planes == 1 else planes[0] + 1j * planes[1]

    def write(self, M: np.ndarray, A: np.ndarray) -> None:
        """Write a matrix or its factors to block M."""
        for p, plane in zip(self.matrix, (A.real, A.imag), strict=False):
            M[p : p + self.n * self.stride].reshape(self.n, self.stride)[:, : self.n] = plane.T

    def factorise_floats(self, M: np.ndarray) -> None:
        A, n = np.array(self.read(M)), self.n
        for k in range(n):
            size = np.abs(A[k:, k].real) + np.abs(A[k:, k].imag)
            pivot = k + int(np.argmax(size))
            M[self.exchanges + k] = pivot
            A[[k, pivot]] = A[[pivot, k]]
            inverse = 1.0 / A[k, k]
            for place, x in zip(self.inverses, (inverse.real, inverse.imag), strict=False):
                M[place + k] = x
            A[k + 1 :, k] *= inverse
            A[k + 1 :, k + 1 :] -= np.outer(A[k + 1 :, k], A[k, k + 1 :])
        self.write(M, A)

    def solve_floats(self, M: np.ndarray, x: np.ndarray) -> np.ndarray:
        A, n = self.read(M), self.n
        inverse = [M[place : place + n] for place in self.inverses]
        for k, pivot in enumerate(M[self.exchanges : self.exchanges + n].astype(int)):
            x[[k, pivot]] = x[[pivot, k]]
        for k in range(n):
            x[k + 1 :] -= A[k + 1 :, k] * x[k]
        for k in reversed(range(n)):
            x[k] *= inverse[0][k] if self.planes == 1 else inverse[0][k] + 1j * inverse[1][k]
            x[:k] -= A[:k, k] * x[k]
        return x


@lru_cache(64)  # every simulation names the functions of its code, mostly of code that is there already
def solver(name: str, factors: FactorLayout, ny: int) -> Primitive:
    """Return the native function that solves A x = b with stored LU factors of A (n, n).

    b has `ny` components; those after the first n are multiplied by `tail`. Outputs: real part `re`, imaginary part
    `im`.
    """
    parts = ("re", "im")[: factors.planes]
    n, stride = factors.n, factors.stride
    inputs: dict[str, int] = {"M": OPAQUE, **{f"b_{p}": ny for p in parts}, "tail": factors.planes}
    c = LoopEmitter(name, [*inputs, *parts])
    x = [c.reserve(f"[{max(stride, 1)} x double]") for _ in parts]
    for part, buffer in zip(parts, x, strict=True):
        with c.loop(0, stride, WIDEST) as i:
            c.store("zeroinitializer", c.at(buffer, i), VECTOR)
        with c.loop(0, n) as i:
            c.store(c.load(c.at(f"%b_{part}", i)), c.at(buffer, i))
    factors.solve(c, x)
    for part, buffer in zip(parts, x, strict=True):
        with c.loop(0, n) as i:
            c.store(c.load(c.at(buffer, i)), c.at(f"%{part}", i))
    tail = [c.load(c.at("%tail", p)) for p in range(factors.planes)]
    with c.loop(n, ny) as i:
        value = times(c, [c.load(c.at(f"%b_{p}", i)) for p in parts], tail)
        for part, v in zip(parts, value, strict=True):
            c.store(v, c.at(f"%{part}", i))

    def floats(M: np.ndarray, tail: np.ndarray, **b: np.ndarray) -> Mapping[str, Any]:
        whole = np.array(b["b_re"] if factors.planes == 1 else b["b_re"] + 1j * b["b_im"])
        t = tail[0] if factors.planes == 1 else complex(*tail)
        out = np.concatenate([factors.solve_floats(M, whole[:n].copy()), t * whole[n:]])
        return {"re": out.real, **({"im": out.imag} if factors.planes == 2 else {})}

    return Primitive(name, floats, inputs, dict.fromkeys(parts, ny), c.text())


def product(name: str, n: int, stride: int, start: int) -> Primitive:
    """Return the native function x = A b for an (n, n) matrix stored in block M from `start`."""
    c = LoopEmitter(name, ["M", "b", "x"])
    total = c.reserve(f"[{stride} x double]")
    with c.loop(0, stride, WIDEST) as i:
        c.store("zeroinitializer", c.at(total, i), VECTOR)
    with c.loop(0, n) as k:
        opposite = c.let(f"fneg double {c.load(c.at('%b', k))}")
        _less(c, [total], [opposite], [c.at("%M", start, c.integer("mul", k, stride))], "0", stride)
    with c.loop(0, n) as i:
        c.store(c.load(c.at(total, i)), c.at("%x", i))

    def floats(M: np.ndarray, b: np.ndarray) -> Mapping[str, Any]:
        return {"x": M[start : start + n * stride].reshape(n, stride)[:, :n].T @ b}

    return Primitive(name, floats, {"M": OPAQUE, "b": n}, {"x": n}, c.text())


def _size(c: LoopEmitter, x: Number) -> str:
    sizes = [c.let(f"call double @llvm.fabs.f64(double {e})") for e in x]
    return sizes[0] if len(x) == 1 else c.let(f"fadd double {sizes[0]}, {sizes[1]}")


def times(c: LoopEmitter, a: Sequence[str], b: Sequence[str], kind: str = "double") -> Number:
    """Emit the product a b of two numbers, real or complex; return the registers of the result."""

    def mul(x: str, y: str) -> str:
        return c.let(f"fmul {kind} {x}, {y}")

    if len(a) == 1:
        return [mul(a[0], b[0])]
    real = c.let(f"fsub {kind} {mul(a[0], b[0])}, {mul(a[1], b[1])}")
    return [real, c.let(f"fadd {kind} {mul(a[0], b[1])}, {mul(a[1], b[0])}")]


def _reciprocal(c: LoopEmitter, x: Number) -> Number:
    if len(x) == 1:
        return [c.let(f"fdiv double 1.0, {x[0]}")]
    squares = [c.let(f"fmul double {e}, {e}") for e in x]
    square = c.let(f"fadd double {squares[0]}, {squares[1]}")
    opposite = c.let(f"fneg double {x[1]}")
    return [c.let(f"fdiv double {x[0]}, {square}"), c.let(f"fdiv double {opposite}, {square}")]


def _swap(c: LoopEmitter, a: str, b: str) -> None:
    x, y = c.load(a), c.load(b)
    c.store(y, a)
    c.store(x, b)


def _less(
    c: LoopEmitter,
    target: list[str],
    a: Number,
    v: list[str],
    start: str,
    stop: int | str,
    only: tuple[str, str] | None = None,
) -> None:
    """Emit target -= a v from index `start` to `stop`, where the index comparison `only` holds; skipped for a = 0."""
    some = c.let(f"fcmp une double {a[0]}, 0.0")
    if len(a) == 2:
        some = c.let(f"or i1 {some}, {c.let(f'fcmp une double {a[1]}, 0.0')}")
    with c.when(some):
        wide = [c.spread(e) for e in a]
        with c.loop(start, stop, WIDEST) as i:
            x = [c.load(c.at(p, i), VECTOR) for p in v]
            if only:
                mask = c.lanes(only[0], i, only[1])
                x = [c.keep(mask, e) for e in x]
            for p, e in zip(target, times(c, x, wide, VECTOR), strict=True):
                old = c.load(c.at(p, i), VECTOR)
                c.store(c.let(f"fsub {VECTOR} {old}, {e}"), c.at(p, i), VECTOR)
