"""ROS34PW2: a linearly implicit method of order 3 with an approximate Jacobian, for stiff ropes at medium accuracy.

Rang, Angermann, BIT 45 (2005) 761-787, table 4.2: four stages, L-stable, stiffly accurate, a W-method: its order holds
for any matrix in place of the Jacobian, so that the structured one of `stiffness` will do and time derivatives may be
left out.  Each stage solves (H + h g C + (h g)^2 K) dv = ... in velocity space; coordinates follow through dq = N dv,
heat and work by quadrature.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from heavylift.kernel.algebra.dense import inverse, least_norm
from heavylift.kernel.algebra.spatial import exact, join
from heavylift.kernel.compiler.emit import Parts, While
from heavylift.kernel.compiler.function import OPAQUE, Function, Primitive
from heavylift.kernel.compiler.layout import Places
from heavylift.kernel.compiler.native_linear_algebra import Factors, product, solver
from heavylift.kernel.compiler.native_loops import Code
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.step_state import Rate, StepState
from heavylift.kernel.model.evaluation import evaluate
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.motion import rates

from .method import Attempt, Build, Exponents, Method, combine, fallen_in, length
from .stiffness import Linearised

GAMMA = 0.435866521508459
ALPHA = np.array(
    [
        [0.0, 0.0, 0.0, 0.0],
        [0.87173304301691801, 0.0, 0.0, 0.0],
        [0.84457060015369423, -0.11299064236484185, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ]
)
GAMMAS = GAMMA * np.eye(4) + np.array(
    [
        [0.0, 0.0, 0.0, 0.0],
        [-0.87173304301691801, 0.0, 0.0, 0.0],
        [-0.90338057013044082, 0.054180672388095326, 0.0, 0.0],
        [0.24212380706095346, -1.2232505839045147, 0.54526025533510214, 0.0],
    ]
)
B = np.array([0.24212380706095346, -1.2232505839045147, 1.5452602553351020, GAMMA])
B_SECOND = np.array([0.37810903145819369, -0.096042292212423178, 0.5, 0.21793326075422950])


def _dense() -> tuple[np.ndarray, np.ndarray]:
    """Weights of x and x^2 of an interpolant of order 2 for any matrix: the smallest that fulfil its conditions.

    sum p = 1, sum p alpha = sum p gamma = 0; the weights of x^2 are b - p.
    """
    conditions = np.array([np.ones(4), ALPHA.sum(axis=1), GAMMAS.sum(axis=1)])
    p = np.array(least_norm(conditions.tolist(), [1.0, 0.0, 0.0]))
    return p, B - p


# in terms of u = Gamma k, which needs no products with the Jacobian (Hairer, Wanner II, (IV.7.25))
INVERSE = exact(inverse(GAMMAS.tolist()))
STAGES = (exact(ALPHA) @ INVERSE).tolist()
COUPLING = (np.diag(1.0 / np.diag(GAMMAS)) - INVERSE).tolist()
WEIGHTS = (exact(B) @ INVERSE).tolist()
ERROR = (exact(B - B_SECOND) @ INVERSE).tolist()
LINEAR, SQUARE = ((w @ INVERSE).tolist() for w in _dense())
NODES = ALPHA.sum(axis=1).tolist()


class RosenbrockW(Method):
    """Assembles and factorises its matrix once a step, then solves four times with it."""

    name = "ros34pw2"
    order = 3
    evaluations = 4
    exponents = Exponents(down=-1.0 / 3.0, up=-0.7 / 3.0, memory=0.2 / 3.0)
    vectors = ("d1", "d2")
    scalars = ("factor",)

    def __init__(self, program: Program) -> None:
        if program.graph.loops or any(link.modes for link in program.graph.links):
            raise KernelError(f"method '{self.name}': it knows trees of rigid bodies only; choose radau5")
        self.program = program
        n = program.nv
        self._factors = Factors(n, 1, 0)
        area = n * self._factors.stride
        self._H, self._K = self._factors.stop, self._factors.stop + area
        self.matrices = self._factors.stop + 2 * area
        self._solve = solver("solve_real", self._factors, n)
        self._times_H = product("inertia_times", n, self._factors.stride, self._H)
        self._times_K = product("stiffness_times", n, self._factors.stride, self._K)
        blocks = {"M": OPAQUE, "y": program.ny, "r": program.ny, "e": 1}
        self._scalars = Function("scalars", lambda b: {"x": b}, {"b": n})
        self._stage = Function("stage", self._stage_text, blocks, vectors=["x"])

    def prologue(
        self, build: Build, at: Places, rate: Function, sizes: Mapping[str, int]
    ) -> tuple[Function | Parts, ...]:
        return build("assemble", self._assemble, matrices=True, plain=True), While(
            "factors", at["factor"], (self._factorise(at),)
        )

    def _assemble(self, s: StepState, rate: Rate) -> list[Value]:
        """What stands in M: H + e C + e^2 K with e = gamma h, H and K, column by column."""
        h, _ = length(s)
        e = GAMMA * h
        x = Linearised(evaluate(self.program, s.t, s.y, s.P))
        n, stride = self.program.nv, self._factors.stride
        s.factor = 1.0

        def columns(entry: Value) -> list[Value]:
            return [entry(i, j) if i < n else 0.0 for j in range(n) for i in range(stride)]

        A = columns(lambda i, j: x.H[i][j] + e * (x.C[i][j] + e * x.K[i][j]))
        rest = [0.0] * (self._factors.stop - len(A))
        return [*A, *rest, *columns(lambda i, j: x.H[i][j]), *columns(lambda i, j: x.K[i][j])]

    def _factorise(self, at: Places) -> Primitive:
        c = Code("factorise", ["X", "M"])
        self._factors.factorise(c)
        c.store("0.0", c.at("%X", at["factor"]))

        def floats(X: np.ndarray, M: np.ndarray) -> dict[str, Value]:
            self._factors.factorise_floats(M)
            X[at["factor"]] = 0.0
            return {}

        return Primitive("factorise", floats, {"X": OPAQUE, "M": OPAQUE}, {}, c.text())

    def _stage_text(self, M: Value, y: Value, r: Value, e: Value) -> dict[str, Value]:
        """Solve (1/e - J) x = r for J = [[0, N], [-K N^+, -C]] in velocity space, e = gamma h."""
        p, e = self.program, e[0]
        links = p.graph.links

        def along(k: Value) -> list[Value]:
            """Components of r's coordinate part along the columns of N, which are orthogonal."""
            one = np.eye(k.v.stop - k.v.start)
            N = [rates(k.joint.kind, y[k.q], unit) for unit in one]
            return [(c @ r[k.q]) * (1.0 / (c @ c)) for c in N]

        r_v = r[p.nq : p.nq + p.nv]
        Hr = self._times_H(M=M, b=r_v).x
        Kr = self._times_K(M=M, b=[x for k in links for x in along(k)]).x
        v = self._solve(M=M, b_re=e * (Hr - e * Kr), tail=[0.0]).re
        moved = self._scalars(b=v).x
        q = [e * (r[k.q] + rates(k.joint.kind, y[k.q], moved[k.v])) for k in links]
        return {"x": join(*q, moved, e * r[p.nq + p.nv :])}

    def attempt(self, s: StepState, rate: Rate, h: Value, among: Value) -> Attempt:
        e = GAMMA * h
        u: list[Value] = []
        seen = []
        for c, a, coupled in zip(NODES, STAGES, COUPLING, strict=True):
            f = s.f
            if u:
                r = rate(s.t + c * h, among, s.y + combine(a, u))
                f = r.dy
                seen.append((c, fallen_in(r)))
                f = f + (1.0 / h) * combine(coupled, u)
            u.append(self._stage(M=s.M, y=s.y, r=f, e=[e]).x)
        y = s.y + combine(WEIGHTS, u)
        r = rate(s.t + h, among, y)
        seen.append((1.0, fallen_in(r)))
        return Attempt(y, r.dy, r, combine(ERROR, u), seen, u)

    def keep(self, s: StepState, h: Value, a: Attempt) -> None:
        s.d1, s.d2 = combine(LINEAR, a.k), combine(SQUARE, a.k)

    def interpolate(self, s: StepState, x: Value) -> Value:
        return s.d0 + x * (s.d1 + x * s.d2)

    def amplification(self, J: np.ndarray, h: float, nq: int) -> np.ndarray:
        one = np.eye(len(J))
        inverse = np.linalg.inv(one - h * GAMMA * J)
        k: list[np.ndarray] = []
        for a, g in zip(ALPHA.tolist(), GAMMAS.tolist(), strict=True):
            before = combine(a[: len(k)], k) if k else 0.0 * one
            coupled = combine(g[: len(k)], k) if k else 0.0 * one
            k.append(inverse @ J @ (one + h * (before + coupled)))
        result: np.ndarray = one + h * combine(B.tolist(), k)
        return result
