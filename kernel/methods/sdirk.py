"""Singly diagonally implicit Runge-Kutta methods, L-stable and stiffly accurate: long steps along the equilibrium path.

Alexander, SIAM J. Numer. Anal. 14 (1977) 1006-1021; Hairer, Wanner, Solving ODEs II, IV.6.  The unknowns of a stage are
its velocities v: its coordinates solve q = q_b + e N(q) v, e = gamma h, which are in closed form for every joint, and
what remains is (I - e J_v - e^2 J_q) dv = e a(q, v) - (v - v_b), one real system of the velocities.  Modes whose
frequency exceeds 1/h are damped, so that a long step follows the equilibrium path in the commanded inputs; slower ones
are resolved.  Which happens is decided by the error estimate, filtered by the same matrix.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from heavylift.kernel.algebra.spatial import join, quaternion_rate
from heavylift.kernel.compiler.emit import Parts, While
from heavylift.kernel.compiler.function import Function
from heavylift.kernel.compiler.layout import Places
from heavylift.kernel.compiler.symbol import Value, maximum, minimum, select, sqrt
from heavylift.kernel.description.joint_table import JOINTS
from heavylift.kernel.methods.step_state import Evaluated, Rate, StepState
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.motion import rates

from .control import NEAR
from .method import LONGEST, Attempt, Build, Exponents, combine, fallen_in, inside, length
from .tableaus import Diagonal
from .velocity_space import VelocitySpace

LONG = 10.0  # [s] a step, where tensions decide
MOST = 25.0  # iterations of a stage
RENEWALS = 4.0  # of the Jacobian in one stage
SLOW = 0.5  # rate of convergence above which the Jacobian is renewed
FAR = 0.5  # [m, rad] longest way of one iteration
LOST = 100.0  # [m, rad] a way after which the iterations are given up
SOLVED = 1e-3  # of the tolerance: last change of an iteration
BARELY = 0.3  # of the tolerance: the same of a step that can be no shorter, where more iterations lead no further
ROUND_OFF = 1e-13  # [m, rad] a change that is none


class DiagonallyImplicit(VelocitySpace):
    """Solves its stages one after the other in `prologue`; z is the state of the one at work, k are their slopes."""

    scalars: tuple[str, ...] = (
        "columns", "now", "within", "stale", "factor", "of", "e",  # Jacobian, factors of gamma h = `of`
        "begun", "newton", "stage", "turn", "size", "renewed", "sound",  # iterations
        "iterations", "differences", "factorisations",  # so far
    )  # fmt: skip

    def __init__(self, program: Program, tableau: Diagonal, tensions_only: bool = False) -> None:
        super().__init__(program)
        self.tableau = tableau
        self.tensions_only = tensions_only and bool(program.system.straight_ropes)
        self.longest = LONG if self.tensions_only else LONGEST
        self.evaluations = 2 if self.tensions_only else 1  # beside the iterations
        self.name, self.order = tableau.name, tableau.order
        self.exponents = Exponents(down=-1.0 / self.order, up=-1.0 / self.order, memory=0.0)
        self._slopes = tuple(f"k{i}" for i in range(len(tableau.A)))
        self._fell = tuple(f"fell{i}" for i in range(len(tableau.A) - 1))
        self.vectors = ("d1", "d2", "d3", "base", *self._slopes, *self._of_jacobian)
        self.scalars = (*self.scalars, *self._fell)
        self.counted = {"iterations": 1, "differences": 1}
        n, ny = program.nv, program.ny
        self._staged = Function(
            "staged", self._staged_text, {"base": ny, "z": ny, "d": n, "f": ny, "e": 1}, vectors=["x"]
        )

    def forgotten(self) -> dict[str, float]:
        return {"begun": 1.0}

    # ---- what the coordinates do --------------------------------------------------------------------------

    def _staged_text(self, base: Value, z: Value, d: Value, f: Value, e: Value) -> dict[str, Value]:
        """State whose velocities are those of z and d more: q = base + e N(q) v, and the integrals' slopes of f."""
        p, e = self.program, e[0]
        first = p.nq + p.nv
        v = z[p.nq : first] + d
        q = []
        for k in p.graph.links:
            at, u = base[k.q], v[k.v]
            i = JOINTS[k.joint.kind].quaternion
            if i is not None:  # a turning o as a matrix: o o = -|o|^2, so that (1 - e/2 o) q = q_b is solved by
                o = u[i:]
                turned = (at[i:] + e * quaternion_rate(at[i:], o)) * (1.0 / (1.0 + 0.25 * e * e * (o @ o)))
                at = join(at[:i], turned)
                q += [at[:i] + e * rates(k.joint.kind, at, u)[:i], turned]
            else:
                q.append(at + e * u)
            q.append(base[k.q_modes] + e * v[k.v_modes])
        return {"x": join(*q, v, base[first:] + e * f[first:])}

    # ---- before the step: Jacobian, factors, stages --------------------------------------------------------

    def prologue(
        self, build: Build, at: Places, rate: Function, sizes: Mapping[str, int]
    ) -> tuple[Function | Parts, ...]:
        return (
            build("begin", self._begin),
            While(
                "stages",
                at["newton"],
                (
                    self._jacobian(build, at, rate, sizes),
                    While("factors", at["factor"], (self._factorise(at),)),
                    build("iterate", self._iterate, matrices=True),
                ),
            ),
        )

    def _begin(self, s: StepState, rate: Rate) -> None:
        if self.tensions_only:
            s.h = select(s.begun > 0.0, select(s.forced > 0.0, s.h, minimum(s.h, NEAR)), s.h)
        s.begun = 0.0
        h, _ = length(s)
        s.e = self.tableau.gamma * h
        s.factor = select(abs(s.of - s.e) > 0.0, 1.0, 0.0)
        s.of, s.columns = s.e, 0.0
        s.base = s.y
        s.z = self._staged(base=s.y, z=s.y, d=self._none, f=s.f, e=[s.e]).x
        s.newton, s.stage, s.turn, s.size, s.renewed, s.sound = 1.0, 0.0, 0.0, 0.0, 0.0, 0.0

    def _time(self, s: StepState) -> Value:
        """Of the stage at work."""
        h, c = length(s)[0], self.tableau.c
        x = c[-1]
        for i, node in reversed([*enumerate(c[:-1])]):
            x = select(s.stage < i + 0.5, node, x)
        return s.t + x * h

    def _iterate(self, s: StepState, rate: Rate) -> None:
        """One simplified Newton iteration of the stage at work; a new Jacobian or the next stage where it is due."""
        r = rate(self._time(s), inside(s), s.z)
        d = self._solve(M=s.M, b_re=self._velocities(y=s.e * r.dy - (s.z - s.base)).x, tail=[0.0]).re
        change = sqrt(d @ d)
        way = s.e * change
        size = self._size(s, way, change)
        again, ratio = s.size > 0.0, minimum(1.0, size * (1.0 / maximum(s.size, 1e-300)))
        fine = (size < SOLVED) | (way < ROUND_OFF) | (again & (ratio < SLOW) & (ratio * size < SOLVED * (1.0 - ratio)))
        known = s.stale <= 0.0
        near = fine & known
        slow = select(known, select(fine, 0.0, select(again, select(ratio > SLOW, 1.0, 0.0), 0.0)), 1.0) > 0.5
        going = (s.turn < MOST) & (s.renewed < RENEWALS + 0.5) & ((way < LOST) | (s.stale > 0.0))
        near = near | (select(going, 0.0, s.forced) * select(size < BARELY, 1.0, 0.0) > 0.0)
        renew = select(slow, select(going, 1.0, 0.0), 0.0)
        both = select(known, select(s.renewed > 0.5, 2.0, 1.0), 2.0)  # velocities change it little
        s.now, s.within = self._time(s), inside(s)
        s.here, s.columns, s.factor = r.dy, renew * both * float(self.program.nv), renew
        s.factorisations, s.iterations = s.factorisations + renew, s.iterations + 1.0
        s.renewed, s.turn, s.size = s.renewed + renew, s.turn + 1.0, select(slow, 0.0, size)
        s.newton = select(near, 1.0, select(going, 1.0, 0.0))
        s.stale = 1.0 - s.newton
        part = select(slow, 0.0, select(going, minimum(1.0, FAR * (1.0 / maximum(way, 1e-300))), 0.0))
        s.z = self._staged(base=s.base, z=s.z, d=select(near, 1.0, part) * d, f=r.dy, e=[s.e]).x
        self._next(s, near, r)

    def _size(self, s: StepState, way: Value, change: Value) -> Value:
        """Of a change of velocities, relative to the tolerance."""
        if self.tensions_only:
            return way * (1.0 / s.tol)
        return (way + change) * (1.0 / (s.tol * maximum(s.scale, s.grain)))

    def _next(self, s: StepState, near: Value, r: Evaluated) -> None:
        """Where a stage is solved: its slope, and where the next one begins."""
        k, h, last = (s.z - s.base) * (1.0 / s.e), length(s)[0], len(self._slopes) - 1
        base, slopes = s.base, list[Value]()
        for i, name in enumerate(self._slopes):
            here = near & (abs(s.stage - i) < 0.5)
            slopes.append(select(here, k, getattr(s, name)))
            setattr(s, name, slopes[-1])
            if i < last:
                following = s.y + h * combine([*self.tableau.A[i + 1][:-1]], slopes)
                base = select(here, following, base)
                before = getattr(s, self._fell[i])
                setattr(s, self._fell[i], select(here, select(fallen_in(r), 1.0, 0.0), before) if len(r.G) else before)
        ended, on = near & (s.stage > last - 0.5), near & (s.stage < last - 0.5)
        s.base = base
        s.z = select(on, self._staged(base=base, z=s.z, d=self._none, f=r.dy, e=[s.e]).x, s.z)
        s.stage, s.size = s.stage + select(on, 1.0, 0.0), select(on, 0.0, s.size)
        s.turn, s.renewed = select(on, 0.0, s.turn), select(on, 0.0, s.renewed)
        s.sound, s.newton = select(ended, 1.0, 0.0), select(ended, 0.0, s.newton)

    # ---- the step ------------------------------------------------------------------------------------------

    def attempt(self, s: StepState, rate: Rate, h: Value, among: Value) -> Attempt:
        k = [getattr(s, name) for name in self._slopes]
        r = rate(s.t + h, among, s.z)
        u, w = self._error(s, h, k)
        apart = self._displaced(y=s.z, u=u, w=w).x
        felt = rate(s.t + h, among, apart).T if self.tensions_only else None
        fell = [getattr(s, name) > 0.0 for name in self._fell]
        seen = [*zip(self.tableau.c, [*fell, fallen_in(r)], strict=True)] if len(r.G) else [(1.0, False)]
        return Attempt(s.z, r.dy, r, apart - s.z, seen, k, s.sound > 0.0, felt=felt)

    def _error(self, s: StepState, h: Value, k: list[Value]) -> tuple[Value, Value]:
        """Estimates for displacements and velocities, filtered: stiff modes are where their equilibrium is."""
        d, A = self.tableau.error, self.tableau.A
        of_v = [sum(d[i] * A[i][j] for i in range(j, len(d))) for j in range(len(d))]
        u = self._velocities(y=h * h * combine(of_v, k)).x
        w = self._velocities(y=h * combine([*d], k)).x
        w = self._solve(M=s.M, b_re=w + s.e * self._times_J_q(M=s.M, b=u).x, tail=[0.0]).re
        return u + s.e * w, w

    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        s.d1 = a.y - s.y
        s.d2 = h * s.f - s.d1
        s.d3 = s.d1 - h * a.k[-1] - s.d2

    def interpolate(self, s: StepState, x: Value) -> Value:
        return s.d0 + x * (s.d1 + (1.0 - x) * (s.d2 + x * s.d3))

    def between(self, s: StepState, rate: Rate, t: Value) -> Value:
        """One iteration with the factors of the last step on the interpolant: stiff ropes feel what is little to it."""
        x, slope = (t - s.t0) * (1.0 / s.h0), 1.0 / s.h0
        y = self.interpolate(s, x)
        change = (s.d1 + (1.0 - 2.0 * x) * s.d2 + x * (2.0 - 3.0 * x) * s.d3) * slope
        missing = self._velocities(y=rate(t, s.t0 + 0.5 * s.h0, y).dy - change).x
        w = self._solve(M=s.M, b_re=s.e * missing, tail=[0.0]).re
        return self._displaced(y=y, u=s.e * w, w=w).x

    def amplification(self, J: np.ndarray, h: float, nq: int) -> np.ndarray:
        one = np.eye(len(J))
        inverse = np.linalg.inv(one - h * self.tableau.gamma * J)
        k: list[np.ndarray] = []
        for row in self.tableau.A:
            k.append(inverse @ J @ (one + h * combine([*row[:-1]], k)))
        result: np.ndarray = one + h * combine([*self.tableau.A[-1]], k)
        return result
