"""Inertia, damping and stiffness of a scene in velocity space, written analytically: H dv' = -C dv - K dq.

For linearly implicit methods of W type, whose order does not need the exact Jacobian: what is here are the stiff parts.
A rope between points with relative velocity columns B = J_b - J_a along u contributes, per line of length l,
    axial      (EA/L0) B^T u u^T B, damping c B^T u u^T B                  (its whole length is one row)
    geometric  (T/l) B^T (1 - u u^T) B - f . (w_k x J_l)                    l at or behind k on the path of a point
where f is the force on the point and w_k the rotation of degree of freedom k: light loaders hang on these.
Springs, stops, brakes, supports and drives add their constants.  dq is the displacement along the velocities.
"""

from __future__ import annotations

import numpy as np
from heavylift.kernel.algebra.spatial import cross
from heavylift.kernel.compiler.symbol import Value, select, sqrt
from heavylift.kernel.forces.joint_laws import StopAt
from heavylift.kernel.forces.ropes import RopeAt
from heavylift.kernel.model.evaluation import Evaluation
from heavylift.kernel.multibody.dynamics import composites, joint_space_inertia
from heavylift.kernel.multibody.kinematics import Kinematics, kinematics, seen_from
from heavylift.kernel.multibody.trees import Tree, with_numbers

Row = dict[int, Value]  # degree of freedom -> number, or column (3,)


class Linearised:
    """Dense symmetric H, C, K as lists of rows over all velocities; prescribed ones stand alone with H = 1."""

    def __init__(self, x: Evaluation) -> None:
        self.x, self.program = x, x.program
        n = self.program.nv
        self.H: list[list[Value]] = [[0.0] * n for _ in range(n)]
        self.C: list[list[Value]] = [[0.0] * n for _ in range(n)]
        self.K: list[list[Value]] = [[0.0] * n for _ in range(n)]
        self._moved: dict[int, tuple[Tree, Kinematics, int]] = {}  # body -> its tree, motion and number there
        self._inertia()
        self._ropes()
        self._supports()
        self._along_joints()
        for tree, _ in self.program.instances:
            for k in tree.prescribed_dofs:
                i = tree.v.start + k
                for A in (self.H, self.C, self.K):
                    for j in range(n):
                        A[i][j] = A[j][i] = 0.0
                self.H[i][i] = 1.0

    def _inertia(self) -> None:
        for i, (tree, _) in enumerate(self.program.instances):
            t = with_numbers(tree, self.x.numbers("tree", str(i)))
            M = kinematics(
                t, np.array(self.x.q[tree.q]), np.array(self.x.v[tree.v]), 0.0, [0.0] * len(t.prescribed_dofs)
            )
            I, _ = composites(t, M, [np.zeros(6)] * len(t.bodies))
            for (k, l), h in joint_space_inertia(t, M, I).items():
                self.H[tree.v.start + k][tree.v.start + l] = self.H[tree.v.start + l][tree.v.start + k] = h
            self._moved.update({tree.first + b: (t, M, b) for b in range(len(t.bodies))})

    def _columns(self, body: int, p: Value) -> list[tuple[int, Value, Value]]:
        """Degree of freedom, rotation w and velocity J of a point per unit speed, from the ground outwards."""
        if body < 0:
            return []
        tree, M, b = self._moved[body]
        path: list[int] = []
        carrier = b
        while carrier >= 0:
            own = [k for k, i in enumerate(tree.body_of_dof) if i == carrier]
            path, carrier = own + path, tree.bodies[carrier].parent
        x = M.r[b] + M.R[b] @ p
        columns = [(k, seen_from(tree, M, k, b)) for k in path]
        return [(tree.v.start + k, S[:3], S[3:] + cross(S[:3], x)) for k, S in columns]

    def _place(self, body: int, p: Value) -> Value:
        if body < 0:
            return p
        _, M, b = self._moved[body]
        return M.o + M.r[b] + M.R[b] @ p

    def _lever(self, columns: list[tuple[int, Value, Value]], force: Value) -> None:
        """What a force on a point changes along the degrees of freedom when those turn its arm."""
        for n, (k, w, _) in enumerate(columns):
            for l, _, J in columns[n:]:
                change = force @ cross(w, J)
                self.K[k][l] = self.K[k][l] - change
                if l != k:
                    self.K[l][k] = self.K[l][k] - change

    @staticmethod
    def _square(A: list[list[Value]], factor: Value, row: Row) -> None:
        for k, a in row.items():
            for l, b in row.items():
                if l <= k:
                    A[k][l] = A[k][l] + factor * (a * b)
                    A[l][k] = A[k][l]

    def _ropes(self) -> None:
        number = self.program.graph.number
        for rope, T, L0 in zip(self.program.system.ropes, self.x.tensions, self.x.lengths, strict=True):
            p = self.x.numbers("rope", rope.name)
            on = select(p[RopeAt.TAUT] > 0.0, p[RopeAt.HOOKED], 0.0)
            whole: Row = {}
            for n, line in enumerate(rope.lines):
                a, b, share = p[4 + 7 * n : 7 + 7 * n], p[7 + 7 * n : 10 + 7 * n], p[10 + 7 * n]
                bodies = number(line.a.body), number(line.b.body)
                d = self._place(bodies[1], b) - self._place(bodies[0], a)
                l = sqrt(d @ d)
                u = d * (1.0 / l)
                ends = [self._columns(body, point) for body, point in zip(bodies, (a, b), strict=True)]
                B: Row = {}
                for sign, columns in zip((-1.0, 1.0), ends, strict=True):
                    for k, _, J in columns:
                        B[k] = B[k] + sign * J if k in B else sign * J
                    self._lever(columns, (-sign * share * T) * u)
                along = {k: u @ J for k, J in B.items()}
                for k, x in along.items():
                    whole[k] = whole[k] + share * x if k in whole else share * x
                pull = share * T * (1.0 / l)
                for axis in range(3):
                    self._square(self.K, pull, {k: J[axis] for k, J in B.items()})
                self._square(self.K, -pull, along)
            self._square(self.K, on * p[RopeAt.EA] * (1.0 / L0), whole)
            self._square(self.C, on * p[RopeAt.DAMPING], whole)

    def _supports(self) -> None:
        for s in self.program.system.supports:
            p = self.x.numbers("support", s.name)
            _, k, d, mu, kt, dt, closed, stick = p[3:11]
            columns = self._columns(self.program.graph.number(s.point.body), p[:3])
            held = select(mu > 0.0, closed * stick, 0.0)
            for axis, stiff, damp in (
                (0, held * kt, held * dt),
                (1, held * kt, held * dt),
                (2, closed * k, closed * d),
            ):
                row = {i: J[axis] for i, _, J in columns}
                self._square(self.K, stiff, row)
                self._square(self.C, damp, row)

    def _along_joints(self) -> None:
        """Springs, stops, brakes and drives: constants of one degree of freedom each."""
        s, numbers = self.program.system, self.x.numbers

        def add(law: Value, stiff: Value, damp: Value) -> None:
            _, k = self.program.graph.coordinate(law.name, law.joint, law.coordinate)
            self.K[k][k], self.C[k][k] = self.K[k][k] + stiff, self.C[k][k] + damp

        for spring in s.springs:
            add(spring, *numbers("spring", spring.name)[:2])
        for stop in s.stops:
            p = numbers("stop", stop.name)
            on = p[StopAt.AT_LOWER] + p[StopAt.AT_UPPER]
            add(stop, on * p[StopAt.K], on * p[StopAt.D])
        for brake in s.brakes:
            _, stiff, damp, engaged, stick, *_ = numbers("brake", brake.name)
            add(brake, engaged * stick * stiff, engaged * stick * damp)
        for drive in s.drives:
            kp, kv = numbers("drive", drive.name)
            if drive.kind == "servo":
                add(drive, kp, kv)
            elif drive.kind == "speed":
                add(drive, 0.0, kv)
