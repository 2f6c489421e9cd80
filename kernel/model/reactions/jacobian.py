"""The constraint Jacobian of a scene at one pose, on floats, scaled so that its singular values can be compared.

Rows are the conditions of loop joints and of taut rigid ropes, columns the degrees of freedom that are neither
prescribed by a drive nor locked. The unit of length is the longest lever of a group of coupled rows, angles are in
radians, so that ranks depend neither on units and sizes nor on masses. The equations run on Python floats here: the
same bits on every processor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import fsum
from typing import Any

import numpy as np
from heavylift.kernel.algebra.dense import combinations, decomposed, dot, norm, product, solve
from heavylift.kernel.compiler.symbol import Array
from heavylift.kernel.constraints.row_structure import ConstraintRow, held_rows
from heavylift.kernel.description.mechanics import JOINTS
from heavylift.kernel.model.evaluation import evaluate
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.kinematics import Kinematics, kinematics, seen_from
from heavylift.kernel.multibody.motion import rates
from heavylift.kernel.multibody.trees import Tree

RANK = 1e-6  # singular value, relative to the largest of its group, that counts as zero
TAUT = 1e-6  # [m] slack up to which a rigid rope counts as taut
PART = 1e-9  # of a row, squared, that none of the others makes up for
DAMPED = 1e-12  # least damping: what rows cannot move stays where it is
NOISE = 1e-12  # of the terms of a sum: what is left of them is round-off
State = tuple[float, list[float], list[float]]  # local time [s], y, P


@dataclass(frozen=True)
class RowGroup:
    """A group of coupled constraint rows, with its scaled Jacobian over the free degrees of freedom."""

    rows: list[int]
    columns: list[tuple[int, int]]  # tree, degree of freedom
    G: list[list[float]]
    rows_by: list[float]  # scales that divide residuals [m, or 1]
    columns_by: list[float]  # scales that divide velocity components [m, or 1]
    lever: float  # [m] the longest

    @cached_property
    def _parts(self) -> tuple[list[tuple[float, list[float]]], list[list[float]]]:
        return decomposed(self.G, len(self.columns))

    @property
    def _least(self) -> float:
        return RANK * max((size for size, _ in self._parts[0]), default=0.0)

    @property
    def rank(self) -> int:
        """The number of independent constraint rows of the group at this pose."""
        return sum(size > self._least for size, _ in self._parts[0])

    @property
    def motions(self) -> list[list[float]]:
        """Orthonormal scaled velocities that satisfy all constraint rows of the group at this pose."""
        found, rest = self._parts
        return [v for size, v in found if not size > self._least] + rest

    @property
    def repeated(self) -> list[int]:
        """The redundant constraint rows of the group: removing any single one of them leaves the rank unchanged."""
        left = [1.0] * len(self.rows)
        for size, v in self._parts[0]:
            if size > self._least:
                left = [x - (u / size) * (u / size) for x, u in zip(left, product(self.G, v), strict=True)]
        return [r for r, x in zip(self.rows, left, strict=True) if x > PART]

    @property
    def redundancies(self) -> list[dict[int, float]]:
        """Undetermined constraint forces: combinations that cause no motion, as scaled multipliers by row."""
        return [{self.rows[n]: x for n, x in distance.items()} for distance in combinations(self.G, RANK)]

    def towards(self, residuals: Sequence[float]) -> list[float]:
        """Return a scaled Levenberg-Marquardt step that reduces the scaled residuals of the group's constraint rows."""
        columns = [list(c) for c in zip(*self.G, strict=True)]
        A = [[0.0] * len(columns) for _ in columns]
        size = norm(residuals)
        for i, a in enumerate(columns):
            for j in range(i + 1):
                A[i][j] = A[j][i] = dot(a, columns[j])
            A[i][i] += min(1.0, max(size * size, DAMPED))
        return solve(A, [-dot(c, residuals) for c in columns])


class Pose:
    """A pose of a scene's bodies, with the constraint rows evaluated there.

    `running`: the state of a run, whose parameters state which ropes are taut and which contacts push; otherwise ropes
    without slack are taut, and contacts do not count.
    """

    def __init__(self, program: Program, state: State, running: bool = False) -> None:
        self.program, (self.t, self.y, self.P), self.running = program, state, running
        x = evaluate(program, self.t, np.array(self.y, dtype=object), np.array(self.P, dtype=object), forces=False)
        self.q, self.v, self.ends = x.q, x.v, x.ends
        lengths = {r.name: x.length_of(r) for r in program.constraints.ropes}
        self.rows: list[ConstraintRow] = held_rows(program, x.ends, x.numbers, lengths)
        if running:
            self.rows += program.constraints.contacts.rows(program.constraints.contacts.slots(x.numbers, x.ends))
        names, units = program.constraints.names, program.constraints.units
        self.names, self.units = names[: len(self.rows)], units[: len(self.rows)]
        self._K: dict[int, Kinematics] = {}

    def tree(self, i: int) -> Tree:
        """Return the i-th tree of bodies with its numerical values."""
        return self.program.instances[i][0]

    def kinematics(self, i: int) -> Kinematics:
        """Return the kinematics of the i-th tree of bodies at this pose."""
        if i not in self._K:
            tree = self.tree(i)
            q, v = (np.array(x, dtype=object) for x in (self.q[tree.q], self.v[tree.v]))
            self._K[i] = kinematics(tree, q, v, 0.0, [0.0] * len(tree.prescribed_dofs))
        return self._K[i]

    def holds(self, r: int) -> bool:
        """Return whether constraint row r is active: a rope must be hooked and taut, and a contact must push."""
        c = self.program.constraints
        first = len(c.of)
        if r < first:
            return True
        if r >= first + len(c.ropes):
            return any(x != 0.0 for _, w in self.pushes(r) for x in w)
        if self.running:
            return bool(self.rows[r].on > 0.0)
        hooked = self.P[self.program.parameters.at["rigid", c.ropes[r - first].name]][0] > 0.0
        return bool(hooked) and bool(float(self.rows[r].gap) < TAUT)

    def pushes(self, r: int) -> list[tuple[int, Array]]:
        """Return the bodies on which constraint row r acts, each with its wrench (6,) of a unit multiplier."""
        return self.rows[r].push or self.rows[r].wrenches

    def normal(self, r: int) -> bool:
        """Return whether constraint row r is the normal row of a contact."""
        c = self.program.constraints.contacts
        first = len(self.rows) - len(c.held)
        sizes = [s.per_slot for s in c.sites for _ in range(s.pair.slots)]
        starts = [first]
        for n in sizes:
            starts.append(starts[-1] + n)
        return r in starts

    @property
    def groups(self) -> list[RowGroup]:
        """The active constraint rows, in groups that share degrees of freedom."""
        out = []
        for rows, trees in self.program.constraints.groups:
            there = [r for r in rows if r < len(self.rows) and self.holds(r)]
            if there:
                out.append(self._group(there, trees))
        return out

    def _group(self, rows: list[int], trees: list[int]) -> RowGroup:
        columns = [(i, k) for i in trees for k in self.tree(i).free_dofs]
        entries = [self.row(r) for r in rows]
        G = [[e.get(c, 0.0) for c in columns] for e in entries]
        turns = [self._turns(*c) for c in columns]
        levers = [
            abs(x) for r, row in zip(rows, G, strict=True) if self.units[r] == "m"
            for x, angle in zip(row, turns, strict=True) if angle
        ]  # fmt: skip
        L = max(levers, default=0.0) or 1.0
        rows_by = [L if self.units[r] == "m" else 1.0 for r in rows]
        columns_by = [1.0 if angle or angle is None else L for angle in turns]
        G = [[x * c / s for x, c in zip(row, columns_by, strict=True)] for row, s in zip(G, rows_by, strict=True)]
        for n, angle in enumerate(turns):
            if angle is None and (size := norm([row[n] for row in G])) > 0.0:  # a mode has no unit of its own
                columns_by[n] /= size
                for row in G:
                    row[n] /= size
        return RowGroup(rows, columns, G, rows_by, columns_by, L)

    def row(self, r: int) -> dict[tuple[int, int], float]:
        """Return row r of the constraint Jacobian over all degrees of freedom, free or not."""
        found: dict[tuple[int, int], float] = {}
        sizes: dict[tuple[int, int], float] = {}
        for body, w in self.pushes(r):
            if body < 0:
                continue
            i, b = self.program.constraints.instance[body]
            tree, K = self.tree(i), self.kinematics(i)
            for k in self.path(i, b):
                terms = [float(p * q) for p, q in zip(seen_from(tree, K, k, b), w, strict=True)]
                found[i, k] = fsum([found.get((i, k), 0.0), *terms])
                sizes[i, k] = fsum([sizes.get((i, k), 0.0), *map(abs, terms)])
        return {c: x if abs(x) > NOISE * sizes[c] else 0.0 for c, x in found.items()}

    def path(self, i: int, b: int) -> list[int]:
        """Return the degrees of freedom of the i-th tree that move its body b."""
        bodies = self.tree(i).bodies
        out = [*range(bodies[b].v.start, bodies[b].v.stop)]
        while (b := bodies[b].parent) >= 0:
            out += range(bodies[b].v.start, bodies[b].v_modes.stop)
        return sorted(out)

    def _turns(self, i: int, k: int) -> bool | None:
        """Return whether a degree of freedom is an angle; None for a mode."""
        tree = self.tree(i)
        b = tree.bodies[tree.body_of_dof[k]]
        joint, n = JOINTS[b.kind], k - b.v.start
        if n >= joint.n_v:
            return None
        if joint.quaternion is not None:
            return bool(n >= joint.quaternion)  # as many displacements stand before the angular velocity
        return any(m.turns for m in joint.motions if m.coordinate == n)

    @property
    def gaps(self) -> list[float]:
        """The residual of each constraint row [m or rad]; 0 for slack ropes."""
        return [float(row.gap) if self.holds(r) else 0.0 for r, row in enumerate(self.rows)]

    def moved(self, steps: Sequence[tuple[RowGroup, Sequence[float]]]) -> Pose:
        """Return the pose reached by scaled steps, one for each group of constraint rows."""
        p = self.program
        change: dict[tuple[int, int], float] = {}
        for group, step in steps:
            for c, x, by in zip(group.columns, step, group.columns_by, strict=True):
                change[c] = x * by
        y: list[Any] = list(self.y)
        y[: p.nq] = self.q  # prescribed coordinates are where their drives are
        for i in sorted({i for i, _ in change}):
            tree = self.tree(i)
            for b in tree.bodies:
                q = self.q[tree.q.start + b.q.start : tree.q.start + b.q.stop]
                u = np.array([change.get((i, k), 0.0) for k in range(b.v.start, b.v.stop)], dtype=object)
                dq = rates(b.kind, np.array(q, dtype=object), u) if len(u) else []
                new = [a + float(x) for a, x in zip(q, dq, strict=True)]
                start = JOINTS[b.kind].quaternion
                if start is not None:
                    size = norm(new[start:])
                    new[start:] = [a / size for a in new[start:]]
                y[tree.q.start + b.q.start : tree.q.start + b.q.stop] = new
                for n, k in zip(range(b.q_modes.start, b.q_modes.stop), range(b.v_modes.start, b.v_modes.stop),
                                strict=True):  # fmt: skip
                    y[tree.q.start + n] = self.q[tree.q.start + n] + change.get((i, k), 0.0)
        return Pose(p, (self.t, y, self.P), self.running)


def pose_of(program: Program, y: Array | None = None, P: Array | None = None, t: float = 0.0) -> Pose:
    """Return the pose of a state y (default: the start) with its constraint rows; with `P`, of a run in progress."""
    running = P is not None
    y = program.initial_state() if y is None else y
    P = program.parameters.initial if P is None else P
    return Pose(program, (float(t), [float(x) for x in y], [float(x) for x in P]), running)
