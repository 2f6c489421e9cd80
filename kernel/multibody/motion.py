"""Motion of one joint from its entry in the joint table: pose, rates, velocity columns and bias, on floats and symbols.

A chain of elementary motions is a chain of massless links: motion i turns about or slides along an axis that the
motions before it carry, S_i in world axes about the tree's point. The joint's twist is the sum of S_i times its speed,
and its acceleration at zero coordinate accelerations, beyond that of its parent and V_P x V_J, is the sum over j < i of
(S_j u_j) x (S_i u_i) (Featherstone 2008, section 4.4, with S as a product of one-axis joints).
"""

from typing import Any, Protocol

import numpy as np
from heavylift.kernel.algebra.spatial import (
    axis_rotation,
    cross,
    join,
    motion_cross,
    quaternion_matrix,
    quaternion_rate,
)
from heavylift.kernel.compiler.symbol import Array, Scalar
from heavylift.kernel.description.mechanics import JOINTS, Joint, JointKind, JointMotion


class Jointed(Protocol):
    """Interface of a body with its joint, implemented by `trees.TreeBody`, with numbers or symbols."""

    @property
    def kind(self) -> JointKind: ...
    @property
    def axes(self) -> Array: ...
    @property
    def pitch(self) -> Scalar: ...


def axes_of(joint: Joint) -> np.ndarray:
    """Return the axes of a joint: its axis as (1, 3), or axis, second and axis x second as (3, 3)."""
    axis = np.array(joint.axis, float)
    if JOINTS[joint.kind].axes < 3:
        return axis[None]
    second = np.array(joint.second, float)
    return np.array([axis, second, np.cross(axis, second)])


def placement(kind: JointKind, axes: Array, pitch: Scalar, q: Any) -> tuple[Array, Array]:
    """Return rotation R_JB (3, 3) and position p_JB (3,) [m] of a joint's child in the joint frame, with its `axes`."""
    joint = JOINTS[kind]
    if joint.quaternion is not None:
        return quaternion_matrix(*q[joint.quaternion :]), q[: joint.quaternion] if joint.quaternion else np.zeros(3)
    R, p = None, None
    for m in joint.motions:
        x = (pitch if m.factor is None else m.factor) * q[m.coordinate]
        if m.turns:
            turned = axis_rotation(axes[m.axis], x)
            R = turned if R is None else R @ turned
        else:
            slid = axes[m.axis] * x
            p = slid if p is None else p + slid
    return np.eye(3) if R is None else R, np.zeros(3) if p is None else p


def rates(kind: JointKind, q: Array, v: Array) -> Any:
    """Return the coordinate rates dq/dt (n_q,) of a joint for its velocities v (n_v,)."""
    i = JOINTS[kind].quaternion
    if i is None:
        return v
    return join(quaternion_matrix(*q[i:]) @ v[:i], quaternion_rate(q[i:], v[i:])) if i else quaternion_rate(q, v)


def speeds(kind: JointKind, q: Array, rate: Array) -> Any:
    """Return the velocities (n_v,) of a joint that cause the given coordinate rates, as nearly as the joint allows."""
    i = JOINTS[kind].quaternion
    if i is None:
        return rate
    x, y, z, w = q[i:]
    a, b, c, d = rate[i:]
    scale = 2.0 / (x * x + y * y + z * z + w * w)
    turning = scale * np.array(
        [w * a + z * b - y * c - x * d, w * b + x * c - z * a - y * d, w * c + y * a - x * b - z * d]
    )
    return join(quaternion_matrix(*q[i:]).T @ rate[:i], turning) if i else turning


def columns(b: Jointed, q: Array, v: Array, R_WJ: Array, R_WB: Array, r: Array) -> tuple[list[Any], Any]:
    """Return the velocity columns S of a joint, each (6,), and its bias (6,) (None if structurally zero).

    World axes about the tree's reference point; r (3,) from that point to the child's origin [m].
    """
    joint = JOINTS[b.kind]
    if joint.quaternion is not None:
        slides = [_column(False, r, e) for e in R_WB.T] if joint.quaternion else []
        return [*slides, *(_column(True, r, e) for e in R_WB.T)], None
    S: list[Any] = [None] * joint.n_v
    R, turned = R_WJ, set[int]()  # what the motions so far have turned, and about which axes
    twists: list[tuple[JointMotion, Array]] = []
    bias = None
    for n, m in enumerate(joint.motions):
        factor = b.pitch if m.factor is None else m.factor
        s = factor * _column(m.turns, r, R @ b.axes[m.axis])
        S[m.coordinate] = s if S[m.coordinate] is None else S[m.coordinate] + s
        twist = s * v[m.coordinate]
        for other, t in twists:
            parallel = other.axis == m.axis and turned <= {m.axis}
            if (m.turns or other.turns) and not parallel:
                pair = motion_cross(t) @ twist
                bias = pair if bias is None else bias + pair
        twists.append((m, twist))
        if m.turns and n + 1 < len(joint.motions):
            R = R @ axis_rotation(b.axes[m.axis], factor * q[m.coordinate])
            turned.add(m.axis)
    return S, bias


def _column(turns: bool, r: Array, e: Array) -> Array:
    """Return the twist (6,) of a unit turn about, or slide along, direction e through the child's origin."""
    return join(e, cross(r, e)) if turns else join(np.zeros(3), e)
