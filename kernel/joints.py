"""The joint table: everything the kernel knows of a joint type stands in one entry (spatial_v2's `jcalc`).

An entry maps coordinates q and velocities v of the joint to the child's rotation R_JB and place p_JB in the joint
frame, to dq/dt, and to its velocity columns S as functions of the child's frame.  A new joint is a new entry.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .spatial import axis_rotation, cross, join, quaternion_matrix, quaternion_rate

__all__ = ["JOINTS", "JointType"]


@dataclass(frozen=True)
class JointType:
    """One row of the table; `placement(q, axis) -> R_JB, p_JB`, `rate(q, v) -> dq/dt`.

    `columns(R_WJ, R_WB, r, axis)` -> one column S per velocity, in world axes about the tree's point, r from that
    point to the child's origin.  `coordinates` maps the coordinates' names to their values in the undisplaced joint,
    `velocities` names the velocities; `quaternion` is where a unit one starts.
    """

    coordinates: dict[str, float]
    velocities: tuple[str, ...]
    placement: Callable[[Any, Any], tuple[Any, Any]]
    rate: Callable[[Any, Any], Any]
    columns: Callable[[Any, Any, Any, Any], list[Any]]
    quaternion: int | None = None

    @property
    def rest(self) -> tuple[float, ...]:
        return tuple(self.coordinates.values())

    @property
    def n_q(self) -> int:
        return len(self.coordinates)

    @property
    def n_v(self) -> int:
        return len(self.velocities)

    @property
    def one_axis(self) -> bool:
        """Whether a spring, stop, brake or drive can act along it."""
        return self.n_v == 1 and self.n_q == 1


def _slide(e: Any) -> Any:
    return join(np.zeros(3), e)


def _turn(r: Any, e: Any) -> Any:
    return join(e, cross(r, e))


QUATERNION = {"qx": 0.0, "qy": 0.0, "qz": 0.0, "qw": 1.0}

JOINTS: dict[str, JointType] = {
    "fixed": JointType(
        {}, (),
        lambda q, a: (np.eye(3), np.zeros(3)),
        lambda q, v: np.zeros(0),
        lambda R_WJ, R_WB, r, a: [],
    ),
    "revolute": JointType(
        {"angle": 0.0}, ("rate",),
        lambda q, a: (axis_rotation(a, q[0]), np.zeros(3)),
        lambda q, v: v,
        lambda R_WJ, R_WB, r, a: [_turn(r, R_WJ @ a)],
    ),
    "prismatic": JointType(
        {"travel": 0.0}, ("speed",),
        lambda q, a: (np.eye(3), a * q[0]),
        lambda q, v: v,
        lambda R_WJ, R_WB, r, a: [_slide(R_WJ @ a)],
    ),
    "spherical": JointType(
        QUATERNION, ("wx", "wy", "wz"),
        lambda q, a: (quaternion_matrix(*q), np.zeros(3)),
        lambda q, v: quaternion_rate(q, v),
        lambda R_WJ, R_WB, r, a: [_turn(r, e) for e in R_WB.T],
        quaternion=0,
    ),
    "free": JointType(
        {"x": 0.0, "y": 0.0, "z": 0.0, **QUATERNION}, ("vx", "vy", "vz", "wx", "wy", "wz"),
        lambda q, a: (quaternion_matrix(*q[3:]), q[:3]),
        lambda q, v: join(quaternion_matrix(*q[3:]) @ v[:3], quaternion_rate(q[3:], v[3:])),
        lambda R_WJ, R_WB, r, a: [*(_slide(e) for e in R_WB.T), *(_turn(r, e) for e in R_WB.T)],
        quaternion=3,
    ),
}  # fmt: skip
