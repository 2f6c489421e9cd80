"""The constraint rows of a scene at one instant: their matrix, their multipliers, and the motion they cause.

Drift is removed when a step is accepted, by one Newton step of the same rows on positions and velocities, weighted with
H (Bayo, Ledesma 1996): it does no work on the remaining motion and costs one evaluation per step.
"""

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import cross, join
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, select
from heavylift.kernel.forces.force_law import attachment
from heavylift.kernel.forces.ropes import at_the_hook

from .block_matrix import Blockwise, OpenTree, Unsymmetric
from .loop_closures import CLOSURES
from .row_structure import SLACK, CompiledScene, ConstraintRow, Lengths, Numbers, RigidAt, held_rows

ROUNDED = 1e-12  # part of a row that is round-off
_Parts = dict[tuple[int, int], Scalar]  # per tree and degree of freedom


class ConstraintRows:
    """Solver for the constraint rows at one instant, under the forces that the evaluation has applied so far."""

    def __init__(
        self,
        scene: CompiledScene,
        arguments: dict[int, dict[str, Scalars]],
        ends: Mapping[int, Array],
        numbers: Numbers,
        lengths: Lengths,
    ) -> None:
        """Build and factorise the rows. `arguments`: arguments of the motion of each linked tree; `ends`: bodies (21,)
        by number; `numbers`: returns parts of P; `lengths`: lengths of rigid ropes with their first two derivatives."""
        self.constraints, self._instances = scene.constraints, scene.instances
        self._arguments, self._ends, self._numbers = arguments, ends, numbers
        self._graph, self._lengths = scene.graph, lengths
        self._trees = {i: self._opened(i).factor(**x) for i, x in arguments.items()}
        self.rows = held_rows(scene, ends, numbers, lengths)
        self.slots = self.constraints.contacts.slots(numbers, ends)
        self.rows += self.constraints.contacts.rows(self.slots)
        self._project()
        d = self.constraints.delassus
        if isinstance(d, Blockwise):
            self._entries = [x for R, S in d.couples for x in self._block(d, d.rows(R), d.rows(S))]
        else:
            self._entries = [self._masked(r, s, self._entry(r, s)) for r, s in d.entries]
        soft = {"soft": [row.soft for row in self.rows]} if self.slots else {}
        # rows of contacts carry a softness of their own, as their forces may be indeterminate
        self._factors = self.constraints.delassus.factorise(A=self._entries, size=self._sizes, **soft)
        self.multipliers: Any = None
        self.free: list[Scalar] = []  # second derivatives without multipliers

    @property
    def pivots(self) -> Any:
        """The relative pivots (n,) of the factorised constraint rows: about 1e-6 for a redundant row."""
        return self._factors.pivot

    @property
    def movable(self) -> np.ndarray:
        """Return for each constraint row (n,), in floats, whether a force on it causes motion beyond round-off."""
        each = enumerate(self._sizes)
        return np.array([float(self._entry(r, r)) > ROUNDED * float(size) for r, size in each], dtype=bool)

    def _opened(self, i: int) -> OpenTree:
        opened: OpenTree | None = self._instances[i][1].opened
        assert opened is not None, "a tree that rows touch is open"
        return opened

    def _free(self, i: int) -> list[int]:
        return self._instances[i][0].free_dofs

    def held(self, values: list[Scalar]) -> list[Scalar]:
        """Return values (n,) of the constraint rows with 0 in place of those of inactive rows."""
        return [select(row.on > 0.0, x, 0.0) for row, x in zip(self.rows, values, strict=True)]

    def _masked(self, r: int, s: int, a: Scalar) -> Any:
        """Return the matrix entry a of rows r and s; if one of them is inactive, 1 on the diagonal and 0 elsewhere."""
        # inactive rows become rows of the identity: the structure, and so the machine code, stays the same
        both = select(self.rows[r].on > 0.0, self.rows[s].on, 0.0) if r != s else self.rows[r].on
        return select(both > 0.0, a, 1.0 if r == s else 0.0)

    def _block(self, d: Blockwise, rows: range, columns: range) -> list[Scalar]:
        """Return G H^-1 G^T of two blocks, row by row, summed over trees."""
        A: list[Scalar] = [0.0] * (len(rows) * len(columns))
        shared = [ik for ik in self._Y[rows[0]] if ik in self._Z[columns[0]]]
        for i in dict.fromkeys(i for i, _ in shared):
            dofs = [ik for ik in shared if ik[0] == i]
            Y, Z = [self._Y[r][ik] for r in rows for ik in dofs], [self._Z[r][ik] for ik in dofs for r in columns]
            A = list(d.blocks.gram(len(rows), len(columns), len(dofs))(A=A, Y=Y, Z=Z).A_)
        pairs = [(r, s) for r in rows for s in columns]
        return [self._masked(r, s, a) for (r, s), a in zip(pairs, A, strict=True)]

    def matrix(self) -> Array:
        """Return the Delassus matrix G H^-1 G^T (n, n) of all constraint rows, active or not, as floats."""
        n = len(self.rows)
        return np.array([[float(self._entry(r, s)) for s in range(n)] for r in range(n)])

    def entries(self) -> list[Scalar]:
        """Return the Delassus matrix of active constraint rows, row by row (n * n,), for scenes with contacts."""
        d = self.constraints.delassus
        assert isinstance(d, Unsymmetric), "asked for with contacts only"
        A = dict(zip(d.entries, self._entries, strict=True))
        n = len(self.rows)
        return [A.get((r, s), 0.0) for r in range(n) for s in range(n)]

    def _project(self) -> None:
        """Compute Y = L^-T G^T per row and degree of freedom, the generalised forces on prescribed ones, and the
        mobility of each row with every body taken alone."""
        self._Y: list[_Parts] = []
        self._X: list[_Parts] = []  # of what the rows push
        self._pull: list[_Parts] = []
        self._sizes: list[Scalar] = []
        for row in self.rows:
            # G H^-1 G^T = Y^T D^-1 Y with Y = L^-T G^T: half of a solution per row suffices
            Y, pull, size = self._half(row.wrenches)
            X, pull, _ = self._half(row.push) if row.push else (Y, pull, size)
            # sliding friction pushes along other directions than the row senses: the matrix becomes unsymmetric
            self._Y.append(Y)
            self._X.append(X)
            self._sizes.append(size)
            self._pull.append(pull)
        self._Z = [{ik: y * self._inverse(*ik) for ik, y in Y.items()} for Y in self._Y]
        self._W = [
            Z if X is Y else {ik: y * self._inverse(*ik) for ik, y in X.items()}
            for X, Y, Z in zip(self._X, self._Y, self._Z, strict=True)
        ]

    def _half(self, wrenches: list[tuple[int, Array]]) -> tuple[_Parts, _Parts, Scalar]:
        size: Scalar = 0.0
        Y: _Parts = {}
        pull: _Parts = {}
        for body, w in wrenches:
            if body >= 0:
                i, b = self.constraints.instance[body]
                opened = self._opened(i)
                x = opened.half[b](F=self._trees[i].F, S=getattr(self._trees[i], f"S{b}"), w=w)
                for k, y in zip(opened.paths[b], x.y, strict=True):
                    # each body alone, so that the size does not vanish where several bodies cancel
                    size = size + y * y * self._inverse(i, k)
                    Y[i, k] = Y[i, k] + y if (i, k) in Y else y
                for k, f in zip(opened.given[b], x.f, strict=True):
                    pull[i, k] = pull[i, k] + f if (i, k) in pull else f
        return Y, pull, size

    def _inverse(self, i: int, k: int) -> Any:
        """Return 1/D for degree of freedom k of tree i: the last numbers of F, in the order of the free ones."""
        F, free = self._trees[i].F, self._free(i)
        return F[len(F) - len(free) + free.index(k)]

    def _entry(self, r: int, s: int) -> Scalar:
        """Return the acceleration of row r by a unit multiplier of row s."""
        return sum((y * self._W[s][ik] for ik, y in self._Y[r].items() if ik in self._W[s]), 0.0)

    def solve(self, b: list[Scalar], prior: list[Scalar] | None = None) -> Any:
        """Return the solution x (n,) of G H^-1 G^T x = b: with contacts the solution nearest to `prior`, otherwise the
        solution of least norm."""
        more = {"prior": prior or [0.0] * len(b)} if self.slots else {}
        return self.constraints.delassus.multipliers(C=self._factors.C, mu=self._factors.mu, b=b, **more).x

    def approach(self) -> list[Scalar]:
        """Return the accelerations (n,) of the constraint residuals under applied forces, without constraint forces."""
        out = []
        for row, Z in zip(self.rows, self._Z, strict=True):
            a = row.bias
            for body, w in row.wrenches:
                # of prescribed joints and of velocities, as spatial accelerations at the bodies
                if body >= 0:
                    i, b = self.constraints.instance[body]
                    a = a + np.array(w, dtype=object) @ getattr(self._trees[i], f"A{b}")
            for (i, k), z in Z.items():
                a = a + z * self._trees[i].half[self._free(i).index(k)]
            out.append(a)
        return out

    def accelerate(self) -> None:
        """Compute the constraint forces (multipliers) that keep the accelerations of active residuals at zero."""
        self.free = self.approach()
        self.multipliers = self.solve(self.held([-a for a in self.free]), [row.prior for row in self.rows])

    @property
    def _rope_rows(self) -> list[ConstraintRow]:
        first = len(self.constraints.of)
        return self.rows[first : first + len(self.constraints.ropes)]

    @property
    def tensions(self) -> dict[str, Scalar]:
        """Tensions of rigid ropes by name [N]."""
        first = len(self.constraints.of)
        return {r.name: self.multipliers[first + i] for i, r in enumerate(self.constraints.ropes)}

    @property
    def end_tensions(self) -> dict[str, Scalar]:
        """Tensions of rigid ropes at their lower ends by name [N]."""
        out = self.tensions
        for r in self.constraints.ropes:
            if r.mass:
                out[r.name] = at_the_hook(out[r.name], self._numbers("weight", r.name)[0])
        return out

    def guards(self) -> dict[str, Scalar]:
        """Return the guards of rigid ropes by name: the tension of a taut rope [N], the slack of a slack one [m]."""
        out = {}
        for r, row in zip(self.constraints.ropes, self._rope_rows, strict=True):
            hooked = self._numbers("rigid", r.name)[RigidAt.HOOKED]
            # an unhooked rope never becomes an event; a slack one fires when its slack is used up
            out[r.name] = select(hooked > 0.0, select(row.on > 0.0, self.tensions[r.name], row.gap + SLACK), 1.0)
        return out

    def wrenches(self) -> list[tuple[int, Array]]:
        """Return the wrenches that all constraint forces exert on bodies, as pairs of body number and wrench (6,)."""
        pairs = zip(self.multipliers, self.rows, strict=True)
        return [(b, x * w) for x, row in pairs for b, w in row.push or row.wrenches]

    def motion(self, i: int) -> SimpleNamespace:
        """Return dq/dt, dv/dt and the reactions of prescribed joints of tree i under all forces."""
        tree, x = self._instances[i][0], self._trees[i]
        half = dict(zip(tree.free_dofs, x.half, strict=True))
        given = dict(zip(tree.prescribed_dofs, x.given, strict=True))
        self._apply(i, self.multipliers, half, given)
        out = self._opened(i).back(
            F=x.F,
            half=list(half.values()),
            a=self._arguments[i]["a"],
            given=list(given.values()) or [0.0],
            cross_=list(x.cross) or [0.0],
        )
        return SimpleNamespace(dq=x.dq, dv=out.dv, reaction=out.reaction)

    def _apply(self, i: int, x: Scalars, half: dict[int, Scalar], given: dict[int, Scalar]) -> None:
        for multiplier, X, pull in zip(x, self._X, self._pull, strict=True):
            for values, parts in ((half, X), (given, pull)):
                for (j, k), y in parts.items():
                    if j == i:
                        values[k] = values[k] + multiplier * y

    def change(self, x: Scalars) -> Mapping[int, Array]:
        """Return each tree's velocity changes (n_v,) under impulses x on the constraint rows; prescribed ones are 0."""
        out = {}
        for i in self.constraints.linked:
            tree = self._instances[i][0]
            half: dict[int, Scalar] = dict.fromkeys(tree.free_dofs, 0.0)
            given: dict[int, Scalar] = dict.fromkeys(tree.prescribed_dofs, 0.0)
            self._apply(i, x, half, {**given})
            zeros = [0.0] * max(1, len(given))
            cross_ = [0.0] * max(1, len(self._trees[i].cross))
            back = self._opened(i).back
            out[i] = back(F=self._trees[i].F, half=list(half.values()), a=zeros, given=zeros, cross_=cross_).dv
        return out

    def loads(self) -> list[Scalar]:
        """Return loads of loop joints on their children [N, N m], and tension [N], slack and length [m] of ropes."""
        out: list[Scalar] = []
        at = 0
        for j in self.constraints.loops:
            n = len(CLOSURES[j.kind])
            wrench = sum((self.multipliers[at + i] * self.rows[at + i].wrenches[1][1] for i in range(n)), np.zeros(6))
            at += n
            p = attachment(self._ends[self._graph.number(j.child)], self._numbers("loop", j.name)[12:15])[0]
            out += [*join(wrench[3:], wrench[:3] - cross(p, wrench[3:]))]
        slack = [row.gap for row in self._rope_rows]
        return [*out, *self.end_tensions.values(), *slack, *(self._lengths[r.name][0] for r in self.constraints.ropes)]
