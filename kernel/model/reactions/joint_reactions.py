"""Joint reactions: the six components of force and moment that every joint transmits at one instant.

The accelerations are those of the forward dynamics, whatever solved it; the balance of the outer bodies then gives the
joint forces, the paper's Fig. 6 (c), (d): f_c,i = f_B,i - f_e,i + sum of f_c,j over the children j.  Components that
rigid bodies do not determine are named, and are those of least norm (see `indeterminacy`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from heavylift.kernel.algebra.spatial import cross
from heavylift.kernel.compiler.symbol import Scalar
from heavylift.kernel.model.evaluation import Evaluation
from heavylift.kernel.model.program import Program
from heavylift.kernel.multibody.dynamics import composites
from heavylift.kernel.multibody.inverse_dynamics import accelerated

from .indeterminacy import COMPONENTS, Indeterminacy, Key, indeterminacies
from .jacobian import pose_of


class Running(Protocol):
    """A simulation, or its native state, as it stands; `[name]` of its state vector X included."""

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
    """What a joint does to its child: `force` (3,) [N] and `moment` (3,) [N m] about the joint's place on the child.

    Both in the axes of the joint's frame on the parent, R_WJ; along free axes they are the forces of the joint's laws.
    `indeterminate`: components, such as "force z", that rigid bodies do not determine (see `Reactions`).
    """

    force: np.ndarray
    moment: np.ndarray
    indeterminate: tuple[str, ...] = ()


@dataclass
class Reactions(dict[str, Reaction]):
    """Reactions by joint; `tensions` [N] of the rigid ropes and `contacts` whose loads rigid bodies do not determine.

    What is not determined has the smallest sum of squares of forces, and of moments divided by `lever` [m]; where a
    rope would have to push for that, it is what the solver of the motion found, and `least` is false.
    """

    tensions: dict[str, float] = field(default_factory=dict)
    contacts: tuple[str, ...] = ()
    groups: list[tuple[Key, ...]] = field(default_factory=list)  # components that share one thing
    lever: float = 0.0
    least: bool = True

    @property
    def shared(self) -> bool:
        """Whether anything is not determined."""
        return bool(self.tensions or self.contacts or any(r.indeterminate for r in self.values()))


def reactions(simulation: Running, least: bool = True) -> Reactions:
    """Reaction of every joint by name, at the present instant of a simulation; those that close loops come last.

    `least`: whether what rigid bodies do not determine is of least norm, not what the solver of the motion found.
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
    """Put the values of least norm in place of those that the solver happened to find."""
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
