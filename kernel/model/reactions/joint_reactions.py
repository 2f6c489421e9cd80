"""Joint reactions: the six components of force and moment that every joint transmits at one instant.

The accelerations are those of the forward dynamics, whatever formulation solved them; the balance of the outer bodies
then gives the joint forces, the paper's Fig. 6 (c), (d): f_c,i = f_B,i - f_e,i + sum of f_c,j over the children j.
Components that rigid bodies do not determine are named, and have the values of least norm.

Statically indeterminate forces: multipliers in the null space of the transposed constraint Jacobian load joints, ropes
and contacts against each other without moving anything: two hinges of one door, a body welded twice, rigid ropes side
by side. Only stiffness and clearances, which rigid bodies do not have, would determine them (Wojtyra, Fraczek 2012).
Components that no such pattern involves are determined. The others are shown with least norm: the smallest sum of
squared forces and of squared moments divided by a lever, over all joints, ropes and contacts of a group.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from heavylift.kernel.algebra.dense import dot, norm, solve
from heavylift.kernel.algebra.spatial import cross
from heavylift.kernel.compiler.symbol import Scalar
from heavylift.kernel.constraints.row_structure import ConstraintRow
from heavylift.kernel.description.mechanics import Joint
from heavylift.kernel.forces.force_law import attachment
from heavylift.kernel.model.evaluation import Evaluation
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.dynamics import accelerated, composites

from .jacobian import NOISE, Pose, RowGroup, pose_of

COMPONENTS = ("force x", "force y", "force z", "moment x", "moment y", "moment z")
TOUCHED = 1e-5  # part of the largest of a pattern from which a component belongs to it
Key = tuple[str, str, int]  # "joint" with its component, "rope" or "contact"; the name; the component


@dataclass(frozen=True)
class Indeterminacy:
    """Statically undetermined forces of a group of coupled constraints.

    `patterns`: force [N] or moment [N m] of each component in each self-equilibrated set of forces.
    """

    patterns: dict[Key, list[float]]
    lever: float  # [m] a moment counts as a force on it

    def least(self, given: Mapping[Key, float]) -> dict[Key, float]:
        """Return the least-norm values of the statically undetermined reactions, from their values `given` in any
        solution."""
        keys = list(self.patterns)
        scales = [1.0 if kind == "joint" and i >= 3 else self.lever for kind, _, i in keys]
        distances = [
            [p * s for p, s in zip(distance, scales, strict=True)]
            for distance in zip(*(self.patterns[k] for k in keys), strict=True)
        ]
        x = [given[k] * s for k, s in zip(keys, scales, strict=True)]
        z = solve([[dot(a, b) for b in distances] for a in distances], [-dot(a, x) for a in distances])
        parts = zip(keys, scales, x, zip(*distances, strict=True), strict=True)
        return {k: (a + dot(z, column)) / s for k, s, a, column in parts}


def indeterminacies(pose: Pose) -> list[Indeterminacy]:
    """Return the statically undetermined forces at a pose, for each group of coupled rows that has any."""
    found = []
    for group in pose.groups:
        distances = [_carried(pose, group, multipliers) for multipliers in group.redundancies]
        if not distances:
            continue
        keys = sorted({k for distance in distances for k in distance})
        patterns = {k: [distance.get(k, 0.0) for distance in distances] for k in keys}
        largest = [max(abs(x) for x in distance.values()) for distance in distances]
        touched = {
            k: p
            for k, p in patterns.items()
            if any(abs(x) > TOUCHED * most for x, most in zip(p, largest, strict=True))
        }
        if touched:
            found.append(Indeterminacy(touched, group.lever))
    return found


def _carried(pose: Pose, group: RowGroup, multipliers: Mapping[int, float]) -> dict[Key, float]:
    """Return the forces of joints, ropes and contacts caused by scaled multipliers alone [N, N m]."""
    least, by = NOISE * max(map(abs, multipliers.values())), dict(zip(group.rows, group.rows_by, strict=True))
    values = {r: m / by[r] for r, m in sorted(multipliers.items()) if abs(m) > least}
    wrenches: dict[int, np.ndarray] = {}
    for r, x in values.items():
        for body, w in pose.pushes(r):
            if body >= 0:
                wrenches[body] = wrenches.get(body, np.zeros(6, dtype=object)) + x * np.array(w, dtype=object)
    found: dict[Key, float] = {}
    for i in sorted({pose.program.constraints.instance[b][0] for b in wrenches}):
        _in_tree(pose, i, wrenches, found)
    _between(pose, values, found)
    return found


def _in_tree(pose: Pose, i: int, wrenches: Mapping[int, np.ndarray], found: dict[Key, float]) -> None:
    """Add the joint wrenches of tree i to `found`: each joint transmits the wrenches on the bodies further out."""
    tree, K, links = pose.tree(i), pose.kinematics(i), pose.program.graph.links
    F = [-wrenches.get(tree.first + n, np.zeros(6, dtype=object)) for n in range(len(tree.bodies))]
    for n in reversed(range(len(tree.bodies))):
        b = tree.bodies[n]
        if b.parent >= 0:
            F[b.parent] = F[b.parent] + F[n]
        if any(F[n]):
            R_WJ = (K.R[b.parent] if b.parent >= 0 else np.eye(3)) @ b.R_PJ
            _put(found, links[tree.first + n].joint.name, R_WJ, K.r[n] + K.R[n] @ b.p_CJ, F[n])


def _between(pose: Pose, values: Mapping[int, float], found: dict[Key, float]) -> None:
    """Add the forces of loop joints, ropes and contacts to `found`."""
    c = pose.program.constraints
    loops: dict[str, tuple[Joint, np.ndarray]] = {}
    for r, x in values.items():
        row: ConstraintRow = pose.rows[r]
        if r < len(c.of):
            j = c.of[r][0]
            before = loops[j.name][1] if j.name in loops else np.zeros(6, dtype=object)
            loops[j.name] = j, before + x * np.array(row.wrenches[1][1], dtype=object)
        elif r < len(c.of) + len(c.ropes):
            key = ("rope", c.ropes[r - len(c.of)].name, 0)
            found[key] = found.get(key, 0.0) + x
        elif pose.normal(r):
            key = ("contact", c.contacts.names[r - len(c.of) - len(c.ropes)], 0)
            found[key] = found.get(key, 0.0) + x
    for name, (j, w) in loops.items():
        a, b = (pose.ends[pose.program.graph.number(x)] for x in (j.parent, j.child))
        R_WJ = np.reshape(a[:9], (3, 3)) @ np.array(j.R_PJ, dtype=object)
        _put(found, name, R_WJ, attachment(b, np.array(j.p_CJ, dtype=object))[0], w)


def _put(found: dict[Key, float], name: str, R_WJ: np.ndarray, p: np.ndarray, F: np.ndarray) -> None:
    """Put the six components of wrench F at a joint into `found`; p: position of the joint from the tree's point."""
    arm = cross(p, F[3:])
    size = norm([float(x) for x in (*F, *arm)])
    for k, f in enumerate((F[3:], F[:3] - arm)):
        for n, x in enumerate(R_WJ.T @ f):
            found["joint", name, 3 * k + n] = float(x) if abs(x) > NOISE * size else 0.0


class Running(Protocol):
    """Interface of a simulation, or of its native state, from which joint reactions are computed.

    `[name]` reads a part of its state block X.
    """

    @property
    def program(self) -> Program: ...
    @property
    def P(self) -> np.ndarray: ...
    @property
    def state(self) -> np.ndarray: ...
    def __getitem__(self, name: str) -> float: ...
    def instant(self) -> Evaluation: ...


@dataclass(frozen=True)
class Reaction:
    """Action of a joint on its child: `force` (3,) [N] and `moment` (3,) [N m] about the joint's point on the child.

    Both are in the axes of the joint's frame on the parent, R_WJ; along free axes they are the forces of the joint's
    laws. `indeterminate`: components, such as "force z", that rigid bodies do not determine (see `Reactions`).
    """

    force: np.ndarray
    moment: np.ndarray
    indeterminate: tuple[str, ...] = ()


@dataclass
class Reactions(dict[str, Reaction]):
    """Joint reactions by the name of the joint; `tensions` [N] of rigid ropes, and `contacts` with undetermined loads.

    Undetermined components have the smallest sum of squares of forces, and of moments divided by `lever` [m]. If a rope
    would have to push in that solution, they are the values from the solver of the motion, and `least` is false.
    """

    tensions: dict[str, float] = field(default_factory=dict)
    contacts: tuple[str, ...] = ()
    groups: list[tuple[Key, ...]] = field(default_factory=list)  # components that share one thing
    lever: float = 0.0
    least: bool = True

    @property
    def shared(self) -> bool:
        """Whether any component of the reactions is statically undetermined."""
        return bool(self.tensions or self.contacts or any(r.indeterminate for r in self.values()))


def reactions(simulation: Running, least: bool = True) -> Reactions:
    """Return the reactions of all joints by name at the present time; loop joints come last.

    If `least`, statically undetermined components get the values of least norm, otherwise those that the simulation
    uses.
    """
    program, x = simulation.program, simulation.instant()
    dv = x.dy[program.nq : program.nq + program.nv]
    found = Reactions()
    R_W = {-1: np.eye(3)}
    for tree in program.trees:
        q, v = np.array(x.q[tree.q]), np.array(x.v[tree.v])
        W = x.wrenches[tree.first : tree.first + len(tree.bodies)]
        K = accelerated(tree, q, v, dv[tree.v], x.gravity)
        _, F = composites(tree, K, W)
        for n, b in enumerate(tree.bodies):
            R_WJ = (K.R[b.parent] if b.parent >= 0 else np.eye(3)) @ b.R_PJ
            R_W[tree.first + n] = K.R[n]
            moment, force = F[n][:3] - cross(K.r[n] + K.R[n] @ b.p_CJ, F[n][3:]), F[n][3:]
            joint = program.graph.links[tree.first + n].joint.name
            found[joint] = _in_axes(R_WJ, force, moment)
    joints = x.loads()[: 6 * len(program.graph.loops)]  # rigid ropes stand behind them
    loads = np.reshape(np.array(joints, dtype=float), (-1, 2, 3))
    for j, load in zip(program.graph.loops, loads, strict=True):
        R_WJ = R_W[program.graph.number(j.parent)] @ np.array(j.R_PJ)
        found[j.name] = _in_axes(R_WJ, *load)
    if len(program.constraints):
        pose = pose_of(program, simulation.state, simulation.P, simulation["t"])
        ropes = [r.name for r in program.system.rigid_ropes]
        pulls = dict(zip(ropes, x.pulls[len(program.system.ropes) :], strict=True))
        for part in indeterminacies(pose):
            _choose(found, part, pulls, least)
    return found


def _in_axes(R_WJ: np.ndarray, force: np.ndarray, moment: np.ndarray) -> Reaction:
    return Reaction(np.array(R_WJ.T @ force, dtype=float), np.array(R_WJ.T @ moment, dtype=float))


def _choose(found: Reactions, part: Indeterminacy, pulls: Mapping[str, Scalar], least: bool) -> None:
    """Replace the undetermined components of a group by the values of least norm, or keep those of the solver."""
    given: dict[Key, float] = {}
    for key in part.patterns:
        kind, name, i = key
        if kind == "joint":
            given[key] = float((found[name].force, found[name].moment)[i // 3][i % 3])
        else:
            given[key] = float(pulls[name]) if kind == "rope" else 0.0
    chosen = part.least(given) if least else given
    if any(x < 0.0 for (kind, *_), x in chosen.items() if kind == "rope"):
        chosen, least = given, False
    for (kind, name, i), x in chosen.items():
        if kind == "joint":
            old = found[name]
            (old.force, old.moment)[i // 3][i % 3] = x
            found[name] = replace(old, indeterminate=(*old.indeterminate, COMPONENTS[i]))
        elif kind == "rope":
            found.tensions[name] = x
        else:
            found.contacts += (name,)
    found.groups.append(tuple(part.patterns))
    found.least = found.least and least
    found.lever = max(found.lever, part.lever)
