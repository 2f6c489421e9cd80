"""Radau IIA of order 5: L-stable collocation in three stages, for stiff ropes and stiff constraints.

Hairer, Wanner, Solving ODEs II, IV.8: simplified Newton iterations on the stages in the eigenbasis of A^-1, so that an
(n, n) real and an (n, n) complex system are solved in place of one of 3n; starting values from the last step's
polynomial; error estimate of order 3 filtered by the real system.  The Jacobian comes from finite differences and is
kept while the iterations converge well.  Heat and work are pure quadratures and stay outside the matrices.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from heavylift.kernel.algebra.dense import inverse
from heavylift.kernel.algebra.elementary import power
from heavylift.kernel.compiler.emit import Parts, While
from heavylift.kernel.compiler.function import OPAQUE, Function, Primitive
from heavylift.kernel.compiler.layout import Places
from heavylift.kernel.compiler.native_linear_algebra import Factors, solver
from heavylift.kernel.compiler.native_loops import Code, padded
from heavylift.kernel.compiler.symbol import Value, maximum, minimum, select, sqrt
from heavylift.kernel.methods.step_state import Rate, StepState
from heavylift.kernel.model.program import Program

from .method import Attempt, Build, Exponents, Method, combine, fallen_in, inside, length
from .small_motions import allowed

__all__ = ["Radau5"]

R6, R3 = sqrt(6.0), power(3.0, 1.0 / 3.0)
C = ((4.0 - R6) / 10.0, (4.0 + R6) / 10.0, 1.0)
A = np.array(
    [
        [(88 - 7 * R6) / 360, (296 - 169 * R6) / 1800, (-2 + 3 * R6) / 225],
        [(296 + 169 * R6) / 1800, (88 + 7 * R6) / 360, (-2 - 3 * R6) / 225],
        [(16 - R6) / 36, (16 + R6) / 36, 1 / 9],
    ]
)
# eigenvalues of A^-1: one real, one complex pair; T^-1 A^-1 T is block diagonal with them, (IV.8.5)
GAMMA = 3.0 + R3 * R3 - R3
ALPHA, BETA = 3.0 + 0.5 * (R3 - R3 * R3), 0.5 * (power(3.0, 5.0 / 6.0) + 3.0 * power(3.0, 1.0 / 6.0))
T = np.array(
    [
        [0.09443876248897524, -0.14125529502095421, 0.03002919410514742],
        [0.25021312296533332, 0.20412935229379994, -0.38294211275726192],
        [1.0, 1.0, 0.0],
    ]
)
T_INVERSE = np.array(inverse(T.tolist()))
ERROR = [(-13.0 - 7.0 * R6) / 3.0, (-13.0 + 7.0 * R6) / 3.0, -1.0 / 3.0]
# the collocation polynomial: columns are the weights of x, x^2, x^3
DENSE = [
    [13 / 3 + 7 * R6 / 3, -23 / 3 - 22 * R6 / 3, 10 / 3 + 5 * R6],
    [13 / 3 - 7 * R6 / 3, -23 / 3 + 22 * R6 / 3, 10 / 3 - 5 * R6],
    [1 / 3, -8 / 3, 10 / 3],
]
STEP = 1.5e-8  # of a finite difference, relative to 1 + |y|: the root of the machine's precision
MOST = 15.0  # iterations
SLOW = 0.1  # rate of convergence above which the next step gets a new Jacobian
ROUND_OFF = 2e-15  # of the state: iterations need not change less
FLOOR = 0.1  # of the tolerance: a last change below it that no longer shrinks is round-off
LOST = 0.95  # rate above which the iterations are given up


class Radau5(Method):
    """Stages from a loop of iterations; z are stage displacements, w the same in the eigenbasis."""

    name = "radau5"
    order = 5
    evaluations = 2  # beside the iterations; with rows one more
    exponents = Exponents(down=-0.25, up=-0.175, memory=0.05)
    vectors = ("d1", "d2", "d3", "w0", "w1", "w2", "z0", "z1", "z2", "index")
    scalars = (
        "columns", "stale", "fresh", "factor", "of", "real", "alpha", "beta",  # Jacobian, factors of step `of`
        "newton", "turn", "size", "rate", "sound", "warm", "fell0", "fell1",  # iterations
        "iterations", "differences", "factorisations",  # so far
    )  # fmt: skip

    def __init__(self, program: Program) -> None:
        self.n, self.ny = program.nq + program.nv, program.ny
        self.counted = {"iterations": len(C), "differences": 1}
        self._moved = len(program.constraints) > 0  # by closing what rows have opened
        self.evaluations = 3 if self._moved else 2
        self._stride = padded(self.ny)
        self._real = Factors(self.n, 1, self.n * self._stride)
        self._complex = Factors(self.n, 2, self._real.stop)
        self.matrices = self._complex.stop
        self._solve = solver("solve_real", self._real, self.ny)
        self._solve_complex = solver("solve_complex", self._complex, self.ny)

    def constants(self) -> dict[str, Value]:
        return {"index": np.arange(self.ny), "stale": 1.0}

    def forgotten(self) -> dict[str, float]:
        return {"stale": 1.0, "warm": 0.0}

    # ---- before the step: Jacobian, factors, stages --------------------------------------------------------

    def prologue(
        self, build: Build, at: Places, rate: Function, sizes: Mapping[str, int]
    ) -> tuple[Function | Parts, ...]:
        differences = build("difference", self._difference, matrices=True)
        return (
            build("begin", self._begin),
            While("differences", at["columns"], (differences,)),
            While("factors", at["factor"], (self._factorise(at),)),
            While("iterations", at["newton"], (build("iterate", self._iterate, matrices=True),)),
        )

    def _begin(self, s: StepState, rate: Rate) -> None:
        h, _ = length(s)
        s.real, s.alpha, s.beta = GAMMA / h, ALPHA / h, BETA / h
        s.columns = select(s.stale > 0.0, float(self.n), 0.0)
        s.factor = select(s.stale > 0.0, 1.0, select(abs(s.of - h) > 0.0, 1.0, 0.0))
        s.of, s.fresh, s.stale = h, s.stale, 0.0
        s.factorisations = s.factorisations + s.factor
        if self._moved:  # differences against the derivative of another place would be no Jacobian
            s.f = rate(s.t, inside(s), s.y).dy
        before = 1.0 / select(s.warm > 0.0, s.h0, 1.0)
        z = []
        for c in C:
            x = (s.t + c * h - s.t0) * before
            z.append(select(s.warm > 0.0, self.interpolate(s, x) - s.y, 0.0 * s.y))
        s.z0, s.z1, s.z2 = z
        s.w0, s.w1, s.w2 = (combine(row, z) for row in T_INVERSE.tolist())
        s.newton, s.turn, s.size, s.sound = 1.0, 0.0, 1.0, 0.0

    def _difference(self, s: StepState, rate: Rate) -> tuple[Value, list[Value]]:
        """One column of the Jacobian at (t, y)."""
        j = s.columns - 1.0
        hit = select(abs(s.index - j) < 0.5, 1.0, 0.0 * s.y)
        d = (STEP * (1.0 + abs(s.y))) @ hit
        column = (rate(s.t, inside(s), s.y + d * hit).dy - s.f) * (1.0 / d)
        s.columns, s.differences = j, s.differences + 1.0
        return j, [column, *[0.0] * (self._stride - self.ny)]

    def _factorise(self, at: Places) -> Primitive:
        """gamma/h - J and (alpha - i beta)/h - J, then their factors."""
        n = self.n
        c = Code("factorise", ["X", "M"])
        shift = [c.load(c.at("%X", at[name])) for name in ("real", "alpha", "beta")]
        planes = [*self._real.matrix, *self._complex.matrix]
        stride = self._real.stride
        with c.loop(0, n) as j:
            source, target = c.integer("mul", j, self._stride), c.integer("mul", j, stride)
            with c.loop(0, n) as i:
                x = c.let(f"fneg double {c.load(c.at('%M', source, i))}")
                for place, value in zip(planes, (x, x, "0.0"), strict=True):
                    c.store(value, c.at("%M", place, target, i))
            for place, value, sign in zip(planes, shift, ("fadd", "fadd", "fsub"), strict=True):
                diagonal = c.at("%M", place, target, j)
                c.store(c.let(f"{sign} double {c.load(diagonal)}, {value}"), diagonal)
        self._real.factorise(c)
        self._complex.factorise(c)
        c.store("0.0", c.at("%X", at["factor"]))

        def floats(X: np.ndarray, M: np.ndarray) -> dict[str, Value]:
            J = M[: n * self._stride].reshape(n, self._stride)[:, :n].T
            self._real.write(M, X[at["real"]] * np.eye(n) - J)
            self._complex.write(M, (X[at["alpha"]] - 1j * X[at["beta"]]) * np.eye(n) - J)
            self._real.factorise_floats(M)
            self._complex.factorise_floats(M)
            X[at["factor"]] = 0.0
            return {}

        return Primitive("factorise", floats, {"X": OPAQUE, "M": OPAQUE}, {}, c.text())

    def _iterate(self, s: StepState, rate: Rate) -> None:
        """One simplified Newton iteration, (IV.8.13)."""
        h, among = s.of, inside(s)
        runs = [rate(s.t + c * h, among, s.y + z) for c, z in zip(C, (s.z0, s.z1, s.z2), strict=True)]
        s.fell0, s.fell1 = (select(fallen_in(r), 1.0, 0.0) if len(r.G) else 0.0 for r in runs[:2])
        F = [combine(row, [r.dy for r in runs]) for row in T_INVERSE.tolist()]
        square = 1.0 / (s.alpha * s.alpha + s.beta * s.beta)
        d0 = self._solve(M=s.M, b_re=F[0] - s.real * s.w0, tail=[1.0 / s.real]).re
        pair = self._solve_complex(
            M=s.M,
            b_re=F[1] - (s.alpha * s.w1 + s.beta * s.w2),
            b_im=F[2] - (s.alpha * s.w2 - s.beta * s.w1),
            tail=[s.alpha * square, s.beta * square],
        )
        weight = 1.0 / allowed(s, abs(s.y))
        steps = [d0 * weight, pair.re * weight, pair.im * weight]
        size = sqrt(sum(e @ e for e in steps) * (1.0 / (3.0 * self.n)))
        first = s.turn < 0.5
        ratio = select(first, LOST * 0.5, size * (1.0 / maximum(s.size, 1e-300)))
        w = [s.w0 + d0, s.w1 + pair.re, s.w2 + pair.im]
        s.w0, s.w1, s.w2 = w
        s.z0, s.z1, s.z2 = (combine(row, w) for row in T.tolist())
        enough = maximum(ROUND_OFF * (1.0 / s.tol), minimum(0.03, sqrt(s.tol)))
        near = select(first, 10.0, ratio * (1.0 / maximum(1.0 - ratio, 1e-3))) * size < enough
        near = near | (size < 1e-3 * enough) | ((size < FLOOR) & (ratio > 0.5) & (s.turn > 0.5))
        s.turn, s.size, s.iterations = s.turn + 1.0, size, s.iterations + 1.0
        s.rate = select(first, 0.0, ratio)  # one iteration that suffices says nothing against its Jacobian
        s.sound = select(near, 1.0, 0.0)
        goes_on = select(ratio < LOST, select(s.turn < MOST, 1.0, 0.0), 0.0)
        s.newton = select(near, 0.0, goes_on)

    # ---- the step ------------------------------------------------------------------------------------------

    def attempt(self, s: StepState, rate: Rate, h: Value, among: Value) -> Attempt:
        z = [s.z0, s.z1, s.z2]
        y = s.y + s.z2
        r = rate(s.t + h, among, y)
        slope = combine(ERROR, z) * (1.0 / h)
        first = self._solve(M=s.M, b_re=s.f + slope, tail=[h / GAMMA]).re
        again = rate(s.t, among, s.y + first).dy
        error = self._solve(M=s.M, b_re=again + slope, tail=[h / GAMMA]).re
        seen = [(C[0], s.fell0 > 0.0), (C[1], s.fell1 > 0.0), (C[2], fallen_in(r))] if len(r.G) else [(1.0, False)]
        return Attempt(y, r.dy, r, error, seen, z, s.sound > 0.0, s.fresh > 0.0)

    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        s.d1, s.d2, s.d3 = (combine([*weights], a.k) for weights in zip(*DENSE, strict=True))
        s.warm = s.sound
        s.stale = select(s.sound > 0.0, select(s.rate > SLOW, 1.0, 0.0), 1.0)

    def interpolate(self, s: StepState, x: Value) -> Value:
        return s.d0 + x * (s.d1 + x * (s.d2 + x * s.d3))

    def amplification(self, J: np.ndarray, h: float, nq: int) -> np.ndarray:
        n = len(J)
        stages = np.kron(np.ones((3, 1)), J)
        k = np.linalg.solve(np.eye(3 * n) - h * np.kron(A, J), stages)
        result: np.ndarray = np.eye(n) + h * np.kron(A[2], np.eye(n)) @ k
        return result
