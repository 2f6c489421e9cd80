"""The rows of loops and rigid ropes where bodies are at an instant.

A row is a wrench on each body that it holds together: the twists V fulfil sum(w . V) = 0, the accelerations
sum(w . A) + bias = 0, and multiplier * w acts on the bodies.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from heavylift.kernel.compiler.symbol import Array, Scalar, select
from heavylift.kernel.description.mechanics import Joint, RigidRope
from heavylift.kernel.multibody.graph import Graph
from heavylift.kernel.multibody.trees import Tree

from .loop_closures import CLOSURES
from .rigid_ropes import RigidAt
from .row_structure import Constraints

Numbers = Callable[[str, str], Array]  # kind, name -> its part of P
Lengths = Mapping[str, tuple[Scalar, Scalar, Scalar]]  # of rigid ropes, with two rates


class CompiledScene(Protocol):
    """What rows depend on of a compiled scene."""

    @property
    def graph(self) -> Graph: ...
    @property
    def constraints(self) -> Constraints: ...
    @property
    def instances(self) -> Sequence[tuple[Tree, Any]]: ...


@dataclass(frozen=True)
class ConstraintRow:
    """One row at an instant; `wrenches`: body number and (6,) wrench about the point of that body's tree."""

    wrenches: list[tuple[int, Array]]
    gap: Scalar
    rate: Scalar
    bias: Scalar
    on: Scalar = 1.0  # 0: absent, as of a slack rope
    push: list[tuple[int, Array]] | None = None  # what it does where it senses otherwise: sliding friction
    soft: Scalar = 1.0  # factor of its regularisation: of redundant rows, a soft one carries less
    prior: Scalar = 0.0  # force next to which that of a redundant row is


def held_rows(
    scene: CompiledScene, ends: Mapping[int, Array], numbers: Numbers, lengths: Lengths
) -> list[ConstraintRow]:
    """The rows of loops, then of rigid ropes, where bodies are at `ends`; arguments as of `Rows`."""
    rows = [row for j in scene.constraints.loops for row in _loop(scene, j, ends, numbers("loop", j.name))]
    ropes = scene.constraints.ropes
    return rows + [_rope(scene, r, ends, numbers("rigid", r.name), lengths[r.name]) for r in ropes]


def _loop(scene: CompiledScene, j: Joint, ends: Mapping[int, Array], p: Array) -> list[ConstraintRow]:
    a, b = (scene.graph.number(x) for x in (j.parent, j.child))
    x = scene.constraints.closures[j.kind](p=p, A=ends[a], B=ends[b])
    return [
        ConstraintRow([(a, -x.wa[6 * i : 6 * i + 6]), (b, x.wb[6 * i : 6 * i + 6])], x.gap[i], x.rate[i], x.bias[i])
        for i in range(len(CLOSURES[j.kind]))
    ]


def _rope(
    scene: CompiledScene, r: RigidRope, ends: Mapping[int, Array], p: Array, L: tuple[Scalar, Scalar, Scalar]
) -> ConstraintRow:
    bodies = [(scene.graph.number(line.a.body), scene.graph.number(line.b.body)) for line in r.lines]
    at = {f"{e}{n}": ends[i] for n, ab in enumerate(bodies) for e, i in zip("ab", ab, strict=True)}
    x = scene.constraints.pulls[len(r.lines)](L=list(L), p=p, **at)
    wrenches = [(i, getattr(x, f"w{e}{n}")) for n, ab in enumerate(bodies) for e, i in zip("ab", ab, strict=True)]
    on = select(p[RigidAt.HOOKED] > 0.0, p[RigidAt.TAUT], 0.0)
    return ConstraintRow(wrenches, x.gap[0], x.rate[0], x.bias[0], on)
