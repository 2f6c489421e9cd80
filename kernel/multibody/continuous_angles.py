"""Angles that go on beyond half a turn: a rotation shows them within +-180 degrees, an integral says in which turn.

Each has a place in the state behind the accounts, whose derivative is the angle's rate; the angle is what the rotation
shows plus the whole turns that bring it next to that integral.  So it is exact, whatever the integral's error below
half a turn, and it has a history that goes where the state goes: into dense output, snapshots and islands.
At the start the turns are those of the joints in between whose axes are parallel to the angle's.
"""

from collections.abc import Callable, Iterator
from math import floor, pi
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.algebra.elementary import nearest
from heavylift.kernel.compiler.symbol import Array, Scalar
from heavylift.kernel.description.mechanics import JOINTS

if TYPE_CHECKING:
    from .graph import Graph

TURN = 2.0 * pi
PARALLEL = 1e-9  # sine of the angle between axes that are parallel but for rounding
EVEN = 1e-9  # part of a turn: half a turn, rounded either way, counts upwards
AXES = ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0))  # that attitudes turn about, see `poses.attitude`

Label = tuple[str, str, int]  # "body", its name, axis of its attitude; or "force", its name, which of its own
Poses = Callable[[str], tuple[Array, Array]]


def on_turn(wrapped: Scalar, counted: Scalar) -> Scalar:
    """The angle [rad] equal to `wrapped` modulo 2 pi, nearest to its integral."""
    return wrapped + TURN * nearest((counted - wrapped) * (1.0 / TURN))


def starting(wrapped: float, turned: float) -> float:
    """The angle equal to `wrapped` modulo 2 pi, nearest to the joints' rotation `turned`."""
    return wrapped + TURN * floor((turned - wrapped) / TURN + 0.5 + EVEN)


def between(graph: "Graph", poses: Poses, a: str, b: str) -> Iterator[tuple[np.ndarray | None, float]]:
    """World axis and angle of each joint between a and b; None for a joint, or bending, without fixed axis."""

    def path(body: str) -> list[int]:
        i, out = graph.number(body), list[int]()
        while i >= 0:
            out.append(i)
            i = graph.links[i].parent
        return out

    up, down = path(a), path(b)
    for side, sign in ((up, -1.0), (down, 1.0)):
        for i in side:
            if i in up and i in down:
                continue
            k = graph.links[i]
            on = graph.links[k.parent] if k.parent >= 0 else None
            if on and on.n_modes:
                yield None, 0.0
            kind = JOINTS[k.joint.kind]
            turns = [m for m in kind.motions if m.turns]
            if kind.quaternion is not None or len(turns) > 1:
                yield None, 0.0
            elif turns:
                R = np.eye(3) if on is None else np.asarray(poses(on.body.name)[0], float)
                axis = R @ np.array(k.joint.R_PJ) @ np.array(k.joint.axis)
                yield sign * axis, float(k.q0[turns[0].coordinate])


def hinge(graph: "Graph", poses: Poses, a: str, b: str) -> np.ndarray | None:
    """The common world axis of all joints between a and b, if there is only one."""
    axes = [axis for axis, _ in between(graph, poses, a, b)]
    first = axes[0] if axes else None
    if first is None or any(x is None or np.linalg.norm(np.cross(x, first)) > PARALLEL for x in axes):
        return None
    return first


def turned_at_start(graph: "Graph", poses: Poses, a: str, b: str, axis: np.ndarray) -> float:
    """Rotation of b against a by joints about a world axis [rad]."""
    along = [(x, q) for x, q in between(graph, poses, a, b) if x is not None]
    return float(sum((x @ axis) * q for x, q in along if np.linalg.norm(np.cross(x, axis)) <= PARALLEL))
