"""Newton systems of implicit methods, reduced to the velocities: (I - e J_v - e^2 J_q) dv = ..., where e is part of a
step.

Coordinates follow from velocities, q' = N(q) v, and are eliminated in closed form: a quarter of the numbers and an
eighth of the operations of a matrix over both. J_q are derivatives of the accelerations along the displacements of unit
velocities, J_v those by velocities; both are one-sided differences (`tangent_stiffness.one_sided`).
"""

from collections.abc import Mapping

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.emit import While
from heavylift.kernel.compiler.function import OPAQUE, Function, Places, Primitive
from heavylift.kernel.compiler.native_linear_algebra import FactorLayout, product, solver, times
from heavylift.kernel.compiler.native_loops import LoopEmitter
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.methods.method import Rate, StepState
from heavylift.kernel.model.program import Program
from heavylift.kernel.model.tangent_stiffness import one_sided
from heavylift.kernel.multibody.motion import rates

from .method import Build, Method

MOVED, SPED = 1e-6, 1e-5  # [m, rad], [m/s, rad/s] finite differences


class VelocitySpace(Method):
    """Base class of implicit methods that solve Newton systems over the velocities.

    Block M holds the Jacobians at the state `z`, where the accelerations are `here`, and the factors for the part `e`
    of a step. `columns`: number of derivatives to recompute: 0, those by displacements (nv), or also those by
    velocities (2 nv).
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        n, ny = program.nv, program.ny
        abreast = max([1, *(k.v.stop - k.v.start for k in program.graph.links)])
        self._along = tuple(f"way{m}" for m in range(abreast))
        self._none = np.zeros(n)
        self._row = FactorLayout(n, 1, 0).stride  # of a column: all of J_q, then all of J_v
        self._real = FactorLayout(n, 1, 2 * n * self._row)
        self.matrices = self._real.stop
        self._solve = solver("solve_real", self._real, n)
        self._times_J_q = product("stiffness_times", n, self._row, 0)
        self._displaced = Function("displaced", self._displaced_text, {"y": ny, "u": n, "w": n}, ["x"], rare=True)
        at = slice(program.nq, program.nq + n)
        self._velocities = Function("velocities", lambda y: {"x": y[at]}, {"y": ny}, vectors=["x"])

    @property
    def _of_jacobian(self) -> tuple[str, ...]:
        """Names of the vectors that the Jacobian needs."""
        return ("z", "here", *self._along, "way", "first", "last")

    def constants(self) -> dict[str, Value]:
        return {"stale": 2.0, **dict(zip(("way", "first", "last"), self._reached().T, strict=True))}

    def _reached(self) -> np.ndarray:
        """Return, for each velocity (ny, 3): its index in the joint, the first coordinate of the joint, and the index
        after the last."""
        out = np.zeros((self.program.ny, 3))
        for k in self.program.graph.links:
            for v in range(k.v.start, k.v.stop):
                out[v] = v - k.v.start, k.q.start, k.q.stop
            for i in range(k.v_modes.stop - k.v_modes.start):
                out[k.v_modes.start + i] = 0, k.q_modes.start + i, k.q_modes.start + i + 1
        return out

    def _displaced_text(self, y: Value, u: Value, w: Value) -> dict[str, Value]:
        """Return the state after a small displacement along u and a change w of the velocities."""
        p = self.program
        first = p.nq + p.nv
        q = []
        for k in p.graph.links:
            q += [y[k.q] + rates(k.joint.kind, y[k.q], u[k.v]), y[k.q_modes] + u[k.v_modes]]
        return {"x": join(*q, y[p.nq : first] + w, y[first:])}

    def _jacobian(self, build: Build, at: Places, rate: Function, sizes: Mapping[str, int]) -> While:
        """Return the native loop that computes the derivatives that are due."""
        p = self.program
        differences = one_sided(at, rate, sizes, p.nq, p.nv, self._row, (MOVED, SPED))
        return While("differences", at["columns"], (build("ways", self._ways), differences))

    def _ways(self, s: StepState, rate: Rate) -> None:
        """Compute coordinate rates of unit velocities, for the first velocities of all joints, then the second, ..."""
        for m, name in enumerate(self._along):
            u = self._none.copy()
            for k in self.program.graph.links:
                u[k.v][m : m + 1] = u[k.v_modes] = 1.0
            setattr(s, name, self._displaced(y=s.z, u=u, w=self._none).x - s.z)

    def _factorise(self, at: Places, e: tuple[str, ...] = ("e",), factors: FactorLayout | None = None) -> Primitive:
        """Return a function for I - e J_v - e^2 J_q and its factors; `e`: names of its real and imaginary part."""
        n, F = self.program.nv, factors or self._real
        name = "factorise" if F.planes == 1 else "factorise_complex"
        c = LoopEmitter(name, ["X", "M"])
        part = [c.load(c.at("%X", at[name])) for name in e]
        with c.loop(0, n) as j:
            source, target = c.integer("mul", j, self._row), c.integer("mul", j, F.stride)
            with c.loop(0, n) as i:
                J_q, J_v = (c.load(c.at("%M", source, c.integer("add", i, k))) for k in (0, n * self._row))
                by = [c.let(f"fmul double {x}, {J_q}") for x in part]
                by[0] = c.let(f"fadd double {J_v}, {by[0]}")
                for value, plane in zip(times(c, part, by), F.matrix, strict=True):
                    c.store(c.let(f"fneg double {value}"), c.at("%M", c.integer("add", target, plane), i))
            diagonal = c.at("%M", c.integer("add", target, F.start), j)
            c.store(c.let(f"fadd double {c.load(diagonal)}, 1.0"), diagonal)
        F.factorise(c)
        c.store("0.0", c.at("%X", at["factor"]))

        def floats(X: np.ndarray, M: np.ndarray) -> dict[str, Value]:
            J = M[: 2 * n * self._row].reshape(2, n, self._row)[:, :, :n].transpose(0, 2, 1)
            x = X[at[e[0]]] if len(e) == 1 else complex(X[at[e[0]]], X[at[e[1]]])
            F.write(M, np.eye(n) - x * (J[1] + x * J[0]))
            F.factorise_floats(M)
            X[at["factor"]] = 0.0
            return {}

        return Primitive(name, floats, {"X": OPAQUE, "M": OPAQUE}, {}, c.text())
