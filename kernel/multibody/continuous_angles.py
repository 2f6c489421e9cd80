"""Angles over several turns: a rotation matrix gives an angle within +-180 degrees, an integral selects the turn.

The integral of an angle's rate is a number of the state, after the energy accounts; the angle is that of the rotation
plus the whole turns that bring it nearest to the integral. So the angle is exact as long as the integral's error is
less than half a turn, and its history is part of the state: of dense output, snapshots and islands. At the start, the
turns are those of the joints between the bodies whose axes are parallel to the angle's axis.
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
    """Return the angle [rad] that equals `wrapped` modulo 2 pi and is nearest to its integrated rate `counted`."""
    # whole turns that bring the exact, wrapped angle nearest to its integral
    return wrapped + TURN * nearest((counted - wrapped) * (1.0 / TURN))


def starting(wrapped: float, turned: float) -> float:
    """Return the angle [rad] equal to `wrapped` modulo 2 pi that is nearest to `turned`, the rotation by the joints."""
    # EVEN: half a turn counts upwards even where rounding makes it a little less
    return wrapped + TURN * floor((turned - wrapped) / TURN + 0.5 + EVEN)


def between(graph: "Graph", poses: Poses, a: str, b: str) -> Iterator[tuple[np.ndarray | None, float]]:
    """Yield the world axis and the angle [rad] of each joint between bodies a and b.

    The axis is None for a joint, or a bending body, without a fixed axis.
    """

    def path(body: str) -> list[int]:
        i, out = graph.number(body), list[int]()
        while i >= 0:
            out.append(i)
            i = graph.links[i].parent
        return out

    up, down = path(a), path(b)
    for side, sign in ((up, -1.0), (down, 1.0)):
        for i in side:
            # joints above the common ancestor turn both bodies alike
            if i in up and i in down:
                continue
            k = graph.links[i]
            on = graph.links[k.parent] if k.parent >= 0 else None
            # modes of a flexible body tilt its children about no fixed axis
            if on and on.n_modes:
                yield None, 0.0
            kind = JOINTS[k.joint.kind]
            turns = [m for m in kind.motions if m.turns]
            # spherical or universal joints have no axis about which whole turns could be counted
            if kind.quaternion is not None or len(turns) > 1:
                yield None, 0.0
            elif turns:
                R = np.eye(3) if on is None else np.asarray(poses(on.body.name)[0], float)
                axis = R @ np.array(k.joint.R_PJ) @ np.array(k.joint.axis)
                yield sign * axis, float(k.q0[turns[0].coordinate])


def hinge(graph: "Graph", poses: Poses, a: str, b: str) -> np.ndarray | None:
    """Return the common world axis of all joints between bodies a and b; None if they do not share a single axis."""
    axes = [axis for axis, _ in between(graph, poses, a, b)]
    first = axes[0] if axes else None
    if first is None or any(x is None or np.linalg.norm(np.cross(x, first)) > PARALLEL for x in axes):
        return None
    return first


def turned_at_start(graph: "Graph", poses: Poses, a: str, b: str, axis: np.ndarray) -> float:
    """Return the rotation [rad] of body b relative to body a about a world axis: the sum of joint angles."""
    along = [(x, q) for x, q in between(graph, poses, a, b) if x is not None]
    return float(sum((x @ axis) * q for x, q in along if np.linalg.norm(np.cross(x, axis)) <= PARALLEL))
