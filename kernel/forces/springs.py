"""Springs and dampers between two bodies: along a line, about an axis, and in all six directions.

Relative rotations come as quaternions (w, v) proportional to (1 + tr R, axial vector of R), good below 180 degrees.
The moment is always the gradient of the stored energy, so that the accounts close however the bodies tumble.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..elementary import atan2
from ..laws import attachment
from ..spatial import cross, join, skew
from ..symbol import sqrt
from .describe import Bushing, Spring, Torsion
from .law import Answer, ForceLaw, Poses, Shown, wrench

__all__ = ["BushingLaw", "SpringLaw", "TorsionLaw"]

TINY = 1e-160  # keeps 0/0 away; vanishes beside any real number, and its root is one that atan2 takes
UNIT = 1e-6  # how far an axis, a rotation or a symmetry may be off by rounding


def _rotation(body: Any) -> Any:
    return np.reshape(body[:9], (3, 3))


def _half_turn(R: Any) -> tuple[Any, Any]:
    """w and v (3,) proportional to the quaternion of a rotation matrix."""
    return 1.0 + R[0, 0] + R[1, 1] + R[2, 2], np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])


class SpringLaw(ForceLaw):
    """Translational: pulls and pushes along the line between its points."""

    def check(self, f: Spring) -> None:
        for field in ("k", "d", "rest"):
            self.demand(f, field, getattr(f, field) >= 0.0, f"is {getattr(f, field):g}; it cannot be negative")
        self.demand(f, "b", f.a != f.b, "is the same point as a; it has no direction")

    def numbers(self, f: Spring, poses: Poses) -> list[float]:
        return [*f.a.p, *f.b.p, f.k, f.d, f.rest]

    def answer(self, f: Spring, p: Any, ends: list[Any], signal: Any, joint: Any, t: Any) -> Answer:
        (x_a, p_a, v_a), (x_b, p_b, v_b) = attachment(ends[0], p[:3], "a"), attachment(ends[1], p[3:6], "b")
        k, d, rest = p[6:9]
        s = p_b - p_a
        length = sqrt(s @ s + TINY)
        u = s * (1.0 / length)
        stretch, rate = length - rest, u @ (v_b - v_a)
        tension = k * stretch + d * rate
        force = tension * u
        return Answer(
            [wrench(x_a, force), -wrench(x_b, force)],
            heat=d * rate * rate,
            stored=0.5 * k * stretch * stretch,
            shown=[tension, stretch],
        )

    def shows(self, f: Spring) -> list[Shown]:
        return [("spring/tension", f.name, "N"), ("spring/elongation", f.name, "m")]


class TorsionLaw(ForceLaw):
    """Torsional: acts on the twist angle, wherever the axes lean (swing-twist decomposition)."""

    def check(self, f: Torsion) -> None:
        for field in ("k", "d"):
            self.demand(f, field, getattr(f, field) >= 0.0, f"is {getattr(f, field):g}; it cannot be negative")
        size = float(np.linalg.norm(f.axis))
        self.demand(f, "axis", abs(size - 1.0) < UNIT, f"has length {size:g}; it must be a unit vector")
        self.demand(f, "b", f.a != f.b, f"is the same body as a, '{f.a}'; it must be another one")

    def numbers(self, f: Torsion, poses: Poses) -> list[float]:
        return [*f.axis, f.k, f.d, f.rest]

    def answer(self, f: Torsion, p: Any, ends: list[Any], signal: Any, joint: Any, t: Any) -> Answer:
        axis, (k, d, rest) = p[:3], p[3:6]
        R_a = _rotation(ends[0])
        w, v = _half_turn(R_a.T @ _rotation(ends[1]))
        s = v @ axis
        angle = 2.0 * atan2(s, w)
        J = R_a @ ((w * w) * axis + w * cross(v, axis) + s * v) * (1.0 / (s * s + w * w))  # angle' = J . w_ab
        rate = J @ (ends[1][15:18] - ends[0][15:18])
        moment = k * (rest - angle) - d * rate
        turn = join(moment * J, np.zeros(3))
        return Answer(
            [-turn, turn], heat=d * rate * rate, stored=0.5 * k * (angle - rest) * (angle - rest), shown=[angle, moment]
        )

    def shows(self, f: Torsion) -> list[Shown]:
        return [("torsion/angle", f.name, "rad"), ("torsion/moment", f.name, "N m")]


class BushingLaw(ForceLaw):
    """A 6x6 spring and damper; the rotation vector's rate is J(theta) times the relative angular velocity.

    J = 1 - theta x / 2 + (1 - theta/2 cot theta/2) / theta^2 (theta x)^2 (Bullo, Murray 1995, eq. for log on SO(3)).
    """

    def check(self, f: Bushing) -> None:
        for field in ("K", "D"):
            A = np.array(getattr(f, field))
            same = np.allclose(A, A.T, rtol=UNIT, atol=UNIT * float(np.abs(A).max(initial=0.0)))
            self.demand(f, field, same, "must be a symmetric matrix, or it would make energy from nothing")
            least = float(np.linalg.eigvalsh(0.5 * (A + A.T)).min())
            good = least >= -UNIT * float(np.abs(A).max())
            self.demand(f, field, good, f"has the eigenvalue {least:g}; it cannot be negative")
        for field in ("R_a", "R_b"):
            R = np.array(getattr(f, field))
            good = bool(np.abs(R @ R.T - np.eye(3)).max() < UNIT and np.linalg.det(R) > 0.0)
            self.demand(f, field, good, "is not a rotation; its rows must be right-handed unit vectors")

    def shape(self, f: Bushing) -> Any:
        return [[i for i, x in enumerate(np.ravel(A).tolist()) if x] for A in (f.K, f.D)]

    def numbers(self, f: Bushing, poses: Poses) -> list[float]:
        rotations = [*np.ravel(f.R_a), *np.ravel(f.R_b)]
        return [*f.a.p, *f.b.p, *map(float, rotations), *(x for A in (f.K, f.D) for x in np.ravel(A).tolist() if x)]

    def answer(self, f: Bushing, p: Any, ends: list[Any], signal: Any, joint: Any, t: Any) -> Answer:
        A, B = ends
        (x_a, p_a, v_a), (x_b, p_b, v_b) = attachment(A, p[:3], "a"), attachment(B, p[3:6], "b")
        R_a, R_b = (_rotation(X) @ np.reshape(q, (3, 3)) for X, q in ((A, p[6:15]), (B, p[15:24])))
        given = iter(p[24:])
        K, D = (_filled(pattern, given) for pattern in self.shape(f))
        s = p_b - p_a
        w, v = _half_turn(R_a.T @ R_b)
        n = sqrt(v @ v + TINY)
        half = atan2(n, w)
        theta = (2.0 * half * (1.0 / n)) * v
        T = skew(theta)
        bend = (1.0 - half * w * (1.0 / n)) * (1.0 / (theta @ theta + TINY))
        J = np.eye(3) - 0.5 * T + bend * (T @ T)
        x = join(R_a.T @ s, theta)
        dx = join(R_a.T @ (v_b - v_a - cross(A[15:18], s)), J @ (R_a.T @ (B[15:18] - A[15:18])))
        elastic, damped = K @ x, D @ dx
        f_b = -(elastic + damped)
        force, moment = R_a @ f_b[:3], R_a @ (J.T @ f_b[3:])
        return Answer(
            [-wrench(x_a + s, force, moment), wrench(x_b, force, moment)],
            heat=damped @ dx,
            stored=0.5 * (elastic @ x),
            shown=[*x, *f_b],
        )

    def shows(self, f: Bushing) -> list[Shown]:
        place = [("bushing/displacement", f"{f.name}.{c}", "m or rad") for c in ("x", "y", "z", "rx", "ry", "rz")]
        return place + [("bushing/force", name, "N or N m") for _, name, _ in place]


def _filled(pattern: list[int], given: Any) -> Any:
    """(6, 6) with the next numbers at the places of `pattern`, zeros elsewhere."""
    places = set(pattern)
    flat = [next(given) if i in places else 0.0 for i in range(36)]
    return np.array([*flat, None], dtype=object)[:-1].reshape(6, 6)
