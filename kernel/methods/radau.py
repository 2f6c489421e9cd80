"""Radau IIA of order 5: L-stable collocation in three stages, for stiff ropes and stiff constraints.

Hairer, Wanner, Solving ODEs II, IV.8: simplified Newton iterations on the stages in the eigenbasis of A^-1, so that a
real and a complex system, both in the velocities alone, replace one of three times the size (`velocity_space`; the
change of N(q) is left to the iterations); starting values from the last step's polynomial; error estimate of order 3
filtered by the real system. The Jacobian is kept while the iterations converge well, its velocity part longer. Heat and
work are pure quadratures and stay outside the matrices.
"""

from collections.abc import Mapping

import numpy as np
from heavylift.kernel.algebra.dense import inverse
from heavylift.kernel.algebra.elementary import power
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.emit import EmittedParts, While
from heavylift.kernel.compiler.function import Function, Places
from heavylift.kernel.compiler.native_linear_algebra import FactorLayout, solver
from heavylift.kernel.compiler.symbol import Value, maximum, minimum, select, sqrt
from heavylift.kernel.methods.method import Rate, StepState
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.motion import rates, speeds

from .control import allowed
from .method import Attempt, Build, Exponents, combine, fallen_in, inside, length
from .velocity_space import VelocitySpace

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
MOST = 15.0  # iterations
SLOW = 0.1  # rate of convergence above which the next step gets a new Jacobian
ROUND_OFF = 2e-15  # of the state: iterations need not change less
FLOOR = 0.1  # of the tolerance: a last change below it that no longer shrinks is round-off
LONG = 10.0  # [s] a step
LOST = 0.95  # rate above which the iterations are given up


class Radau5(VelocitySpace):
    """Radau IIA method of order 5, whose stages come from Newton iterations.

    z: displacements of the stages, w: the same in the eigenbasis.
    """

    name = "radau5"
    order = 5
    longest = LONG
    exponents = Exponents(down=-0.25, up=-0.175, memory=0.05, held=1.2)
    scalars = (
        "columns", "now", "within", "stale", "fresh", "factor", "of",  # Jacobian, factors of step `of`
        "real", "alpha", "beta", "e", "e_re", "e_im",  # eigenvalues over the step, and their inverses
        "newton", "turn", "size", "rate", "sound", "warm", "fell0", "fell1",  # iterations
        "iterations", "differences", "factorisations",  # so far
    )  # fmt: skip

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self.n = program.nq + program.nv
        self.vectors = ("d1", "d2", "d3", "w0", "w1", "w2", "z0", "z1", "z2", "moving", *self._of_jacobian)
        self.counted = {"iterations": len(C), "differences": 1}
        self._moved = len(program.constraints) > 0  # by closing what rows have opened
        self.evaluations = 3 if self._moved else 2  # beside the iterations
        n, ny = program.nv, program.ny
        # coordinates are eliminated: systems of nv rows in place of nq + nv
        self._complex = FactorLayout(n, 2, self.matrices)
        self.matrices = self._complex.stop
        self._solve_complex = solver("solve_complex", self._complex, n)
        self._speeds = Function("speeds", self._speeds_text, {"y": ny, "b": ny}, vectors=["x"])
        self._carried = Function("carried", self._carried_text, {"y": ny, "b": ny, "v": n}, ["x", "v_"], rare=True)

    def constants(self) -> dict[str, Value]:
        return {**super().constants(), "moving": np.arange(self.program.ny) < self.n}  # no account

    def forgotten(self) -> dict[str, float]:
        return {"stale": 2.0, "warm": 0.0}

    # ---- what the coordinates do --------------------------------------------------------------------------

    def _speeds_text(self, y: Value, b: Value) -> dict[str, Value]:
        """Return the velocities whose coordinate rates are those in b."""
        parts = [(speeds(k.joint.kind, y[k.q], b[k.q]), b[k.q_modes]) for k in self.program.graph.links]
        return {"x": join(*(x for pair in parts for x in pair))}

    def _carried_text(self, y: Value, b: Value, v: Value) -> dict[str, Value]:
        """Return `x`: b with the coordinate rates of velocities v added to its coordinates, and velocities 0; and `v_`:
        v alone, in a vector of the same size."""
        p, q = self.program, []
        for k in p.graph.links:
            q += [b[k.q] + rates(k.joint.kind, y[k.q], v[k.v]), b[k.q_modes] + v[k.v_modes]]
        last = p.nq + p.nv
        return {"x": join(*q, 0.0 * v, b[last:]), "v_": join(np.zeros(p.nq), v, np.zeros(p.ny - last))}

    def _solved(self, s: StepState, b: Value) -> Value:
        """Return (1/e - J)^-1 b of the real system; 1/e: real eigenvalue of A^-1 over the step."""
        # (1/e - J) x = b with J = [[0, N], [K, D]] and q eliminated: (1 - e D - e^2 K N) v = e (e K b_q + b_v)
        g = s.e * (s.e * self._times_J_q(M=s.M, b=self._speeds(y=s.y, b=b).x).x + self._velocities(y=b).x)
        x = self._carried(y=s.y, b=b, v=self._solve(M=s.M, b_re=g, tail=[0.0]).re)
        return s.e * x.x + x.v_

    def _solved_complex(self, s: StepState, b: tuple[Value, Value]) -> tuple[Value, Value]:
        """Return (1/e - J)^-1 b of the complex system; b and the result are pairs of real and imaginary part."""
        pushed = [self._times_J_q(M=s.M, b=self._speeds(y=s.y, b=x).x).x for x in b]
        inner = _by(s, pushed)
        g = _by(s, [x + self._velocities(y=y).x for x, y in zip(inner, b, strict=True)])
        v = self._solve_complex(M=s.M, b_re=g[0], b_im=g[1], tail=[0.0, 0.0])
        x = [self._carried(y=s.y, b=y, v=u) for y, u in zip(b, (v.re, v.im), strict=True)]
        re, im = _by(s, [y.x for y in x])
        return re + x[0].v_, im + x[1].v_

    # ---- before the step: Jacobian, factors, stages --------------------------------------------------------

    def prologue(
        self, build: Build, at: Places, rate: Function, sizes: Mapping[str, int]
    ) -> tuple[Function | EmittedParts, ...]:
        both = self._factorise(at), self._factorise(at, ("e_re", "e_im"), self._complex)
        return (
            build("begin", self._begin),
            self._jacobian(build, at, rate, sizes),
            While("factors", at["factor"], both),
            While("iterations", at["newton"], (build("iterate", self._iterate, matrices=True),)),
        )

    def _begin(self, s: StepState, rate: Rate) -> None:
        h, _ = length(s)
        # gamma, alpha, beta over h are the diagonal blocks of (h A)^-1 in the eigenbasis
        s.real, s.alpha, s.beta = GAMMA / h, ALPHA / h, BETA / h
        square = 1.0 / (s.alpha * s.alpha + s.beta * s.beta)
        s.e, s.e_re, s.e_im = 1.0 / s.real, s.alpha * square, s.beta * square
        # stale 1: displacement part only; 2: also the velocity part, which changes more slowly
        s.columns = select(s.stale > 0.0, select(s.stale > 1.5, 2.0, 1.0) * float(self.program.nv), 0.0)
        s.factor = select(s.stale > 0.0, 1.0, select(abs(s.of - h) > 0.0, 1.0, 0.0))
        s.of, s.fresh, s.stale = h, s.stale, 0.0
        s.factorisations = s.factorisations + s.factor
        if self._moved:  # differences against the derivative of another place would be no Jacobian
            s.f = rate(s.t, inside(s), s.y).dy
        s.z, s.here, s.now, s.within = s.y, s.f, s.t, inside(s)
        # starting values: the collocation polynomial of the last step, extrapolated; zero after a jump
        before = 1.0 / select(s.warm > 0.0, s.h0, 1.0)
        z = []
        for c in C:
            x = (s.t + c * h - s.t0) * before
            z.append(select(s.warm > 0.0, self.interpolate(s, x) - s.y, 0.0 * s.y))
        s.z0, s.z1, s.z2 = z
        s.w0, s.w1, s.w2 = (combine(row, z) for row in T_INVERSE.tolist())
        s.newton, s.turn, s.size, s.sound = 1.0, 0.0, 1.0, 0.0

    def _iterate(self, s: StepState, rate: Rate) -> None:
        """Do one simplified Newton iteration, (IV.8.13)."""
        h, among = s.of, inside(s)
        # the three stages, at which guards are watched as well
        runs = [rate(s.t + c * h, among, s.y + z) for c, z in zip(C, (s.z0, s.z1, s.z2), strict=True)]
        s.fell0, s.fell1 = (select(fallen_in(r), 1.0, 0.0) if len(r.G) else 0.0 for r in runs[:2])
        F = [combine(row, [r.dy for r in runs]) for row in T_INVERSE.tolist()]
        # (gamma/h - J) dw0 = F0 - gamma/h w0, and the complex pair likewise: (IV.8.13)
        d0 = self._solved(s, F[0] - s.real * s.w0)
        d1, d2 = self._solved_complex(
            s, (F[1] - (s.alpha * s.w1 + s.beta * s.w2), F[2] - (s.alpha * s.w2 - s.beta * s.w1))
        )
        # heat and work are quadratures: they follow from the stages and must not govern convergence
        weight = s.moving / allowed(s, abs(s.y))  # accounts follow one iteration later
        steps = [d0 * weight, d1 * weight, d2 * weight]
        size = sqrt(sum(e @ e for e in steps) * (1.0 / (3.0 * self.n)))
        first = s.turn < 0.5
        # no rate is known in the first iteration; half of LOST lets it go on
        ratio = select(first, LOST * 0.5, size * (1.0 / maximum(s.size, 1e-300)))
        w = [s.w0 + d0, s.w1 + d1, s.w2 + d2]
        s.w0, s.w1, s.w2 = w
        s.z0, s.z1, s.z2 = (combine(row, w) for row in T.tolist())
        # kappa of RADAU5: the iteration error stays a small part of the tolerance, but above round-off
        enough = maximum(ROUND_OFF * (1.0 / s.tol), minimum(0.03, sqrt(s.tol)))
        # theta / (1 - theta) times the last change bounds the remaining error of a geometric series, (IV.8.11)
        near = select(first, 10.0, ratio * (1.0 / maximum(1.0 - ratio, 1e-3))) * size < enough
        # or the changes no longer shrink because they are round-off
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
        # the error estimate of order 3 of (IV.8.19), from the stages and the slope at the start
        slope = combine(ERROR, z) * (1.0 / h)
        # filtered by (gamma/h - J)^-1, so that stiff components do not reject steps
        first = self._solved(s, s.f + slope)
        # evaluated once more at the filtered value, as (IV.8.20) does for the first and for rejected steps
        again = rate(s.t, among, s.y + first).dy
        error = self._solved(s, again + slope)
        seen = [(C[0], s.fell0 > 0.0), (C[1], s.fell1 > 0.0), (C[2], fallen_in(r))] if len(r.G) else [(1.0, False)]
        return Attempt(y, r.dy, r, error, seen, z, s.sound > 0.0, s.fresh > 0.0)

    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        s.d1, s.d2, s.d3 = (combine([*weights], a.k) for weights in zip(*DENSE, strict=True))
        s.warm = s.sound
        # if a fresh displacement part did not help, the velocity part is renewed as well
        renewed = select(s.fresh > 0.5, 2.0, 1.0)  # by velocities, too, where displacements did not help
        s.stale = select(s.sound > 0.0, select(s.rate > SLOW, renewed, 0.0), renewed)

    def interpolate(self, s: StepState, x: Value) -> Value:
        return s.d0 + x * (s.d1 + x * (s.d2 + x * s.d3))

    def amplification(self, J: np.ndarray, h: float, nq: int) -> np.ndarray:
        n = len(J)
        stages = np.kron(np.ones((3, 1)), J)
        k = np.linalg.solve(np.eye(3 * n) - h * np.kron(A, J), stages)
        result: np.ndarray = np.eye(n) + h * np.kron(A[2], np.eye(n)) @ k
        return result


def _by(s: StepState, x: list[Value]) -> list[Value]:
    """Return the product of the complex number e and x."""
    return [s.e_re * x[0] - s.e_im * x[1], s.e_re * x[1] + s.e_im * x[0]]
