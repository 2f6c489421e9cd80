"""Springs and dampers between two bodies: along a line, about an axis, and in all six directions.

Twist angles count all turns. Rotations about several axes come as quaternions (w, v) proportional to (1 + tr R, axial
vector of R), valid below 180 degrees: beyond FARTHEST the law ends the run. The moment is always the gradient of the
stored energy, so that the energy balance closes however the bodies tumble.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from typing import Any

import numpy as np
from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.algebra.spatial import cross, join, skew
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, sqrt
from heavylift.kernel.description.forces import Bushing, Spring, Torsion
from heavylift.kernel.multibody.continuous_angles import hinge, on_turn

from .force_law import ForceLaw, LawBreakdown, LawOutput, Poses, SampledQuantity, Setting, attachment, wrench

TINY = 1e-160  # keeps 0/0 away; vanishes beside any real number, and its root is one that atan2 takes
ALIGNED = 1e-9  # by how much an axis may differ in two frames by rounding
FARTHEST, AGAINST = -0.9961946980917455, "175 degrees"  # cosine and angle of the last rotation that is good
UNIT = 1e-6  # how far an axis, a rotation or a symmetry may be off by rounding


def _rotation(body: Array) -> Array:
    return np.reshape(body[:9], (3, 3))


def _half_turn(R: Array) -> tuple[Any, Any]:
    """Return w and v (3,) proportional to the quaternion of a rotation matrix."""
    # 4 w times the quaternion (w, v): no root and no division, but zero at half a turn
    return 1.0 + R[0, 0] + R[1, 1] + R[2, 2], np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])


def _twist(R: Array, axis: Array, lean: Scalar) -> Any:
    """Return the angle of a rotation about an axis (swing-twist), within half a turn; `lean`: axis . R axis."""
    _, v = _half_turn(R)
    # 2 sin and 2 cos of the angle if R turns about the axis only
    return atan2(v @ axis, R[0, 0] + R[1, 1] + R[2, 2] - lean)


def _rotation_vector(R: Array) -> tuple[Any, Any]:
    """Return the rotation vector theta (3,) of a rotation below half a turn, and J of `BushingLaw`."""
    w, v = _half_turn(R)
    n = sqrt(v @ v + TINY)
    # half the angle by atan2, accurate for small and large angles alike
    half = atan2(n, w)
    theta = (2.0 * half * (1.0 / n)) * v
    T = skew(theta)
    # tends to 1/12 at zero, where TINY keeps 0/0 away
    bend = (1.0 - half * w * (1.0 / n)) * (1.0 / (theta @ theta + TINY))
    return theta, np.eye(3) - 0.5 * T + bend * (T @ T)


class SpringLaw(ForceLaw[Spring]):
    """Force law of a spring and damper along the line between two points, which pulls and pushes."""

    def check(self, f: Spring) -> None:
        self.demand(f, "b", f.a != f.b, "is the same point as a; it has no direction")

    def numbers(self, f: Spring, poses: Poses) -> list[float]:
        return [*f.a.p, *f.b.p, f.k, f.d, f.rest]

    def answer(self, f: Spring, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        (x_a, p_a, v_a), (x_b, p_b, v_b) = attachment(ends[0], p[:3], "a"), attachment(ends[1], p[3:6], "b")
        k, d, rest = p[6:9]
        s = p_b - p_a
        length = sqrt(s @ s + TINY)
        u = s * (1.0 / length)
        stretch, rate = length - rest, u @ (v_b - v_a)
        tension = k * stretch + d * rate
        force = tension * u
        return LawOutput(
            [wrench(x_a, force), -wrench(x_b, force)],
            heat=d * rate * rate,
            stored=0.5 * k * stretch * stretch,
            shown=[tension, stretch],
        )

    def shows(self, f: Spring) -> list[SampledQuantity]:
        return [SampledQuantity("spring/tension", f.name, "N"), SampledQuantity("spring/elongation", f.name, "m")]


class TorsionLaw(ForceLaw[Torsion]):
    """Force law of a torsional spring on the twist angle, independent of tilt (swing-twist decomposition)."""

    def check(self, f: Torsion) -> None:
        size = float(np.linalg.norm(f.axis))
        self.demand(f, "axis", abs(size - 1.0) < UNIT, f"has length {size:g}; it must be a unit vector")
        self.demand(f, "b", f.a != f.b, f"is the same body as a, '{f.a}'; it must be another one")

    def numbers(self, f: Torsion, poses: Poses) -> list[float]:
        return [*f.axis, f.k, f.d, f.rest]

    def angles(self, f: Torsion) -> int:
        return 1

    def turns(self, f: Torsion, poses: Poses) -> tuple[str, str, Array]:
        return f.a, f.b, np.asarray(poses(f.a)[0], float) @ np.array(f.axis)

    def guards(self, f: Torsion) -> tuple[str, ...]:
        return ("lean",)

    def switch(self, f: Torsion, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        why = (
            f"its axis on '{f.b}' points {AGAINST} against that on '{f.a}', so the twist is undefined; guide the axis "
            "by a joint, or remove the torsion spring"
        )
        raise LawBreakdown(f"torsion '{f.name}'", why)

    def answer(
        self, f: Torsion, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar, counted: Scalars = ()
    ) -> LawOutput:
        axis, (k, d, rest) = p[:3], p[3:6]
        R_a = _rotation(ends[0])
        R = R_a.T @ _rotation(ends[1])
        swung = R @ axis
        lean = axis @ swung
        angle = on_turn(_twist(R, axis, lean), counted[0])
        # the rate of the twist depends on the tilt of the axis: this gradient keeps energy and moment consistent
        J = R_a @ (axis + swung) * (1.0 / (1.0 + lean))  # angle' = J . w_ab
        rate = J @ (ends[1][15:18] - ends[0][15:18])
        moment = k * (rest - angle) - d * rate
        turn = join(moment * J, np.zeros(3))
        return LawOutput(
            [-turn, turn],
            heat=d * rate * rate,
            stored=0.5 * k * (angle - rest) * (angle - rest),
            guards=[lean - FARTHEST],
            shown=[angle, moment],
            turned=[angle],
            turning=[rate],
        )

    def shows(self, f: Torsion) -> list[SampledQuantity]:
        return [SampledQuantity("torsion/angle", f.name, "rad"), SampledQuantity("torsion/moment", f.name, "N m")]


class BushingLaw(ForceLaw[Bushing]):
    """Force law of a 6x6 spring and damper between two frames.

    The rotation vector's rate is J(theta) times the relative angular velocity.

    `axis` (3,), in frame a: the axis of all rotation that the joints in between allow, if there is only one; theta is
    then the angle about it, over all turns, and J = 1. Otherwise J = 1 - theta x / 2 + (1 - theta/2 cot theta/2) /
    theta^2 (theta x)^2 (Bullo, Murray 1995, eq. for log on SO(3)).
    """

    def __init__(self, axis: Array | None = None) -> None:
        self._axis = axis

    def within(self, f: Bushing, setting: Setting) -> BushingLaw:
        poses = setting.poses
        axis = hinge(setting.graph, poses, f.a.body, f.b.body)
        if axis is None:
            return self
        R_a, R_b = (np.asarray(poses(x.body)[0], float) @ np.array(R) for x, R in ((f.a, f.R_a), (f.b, f.R_b)))
        in_a = R_a.T @ axis
        return BushingLaw(in_a) if np.abs(R_a.T @ R_b @ in_a - in_a).max() < ALIGNED else self

    def angles(self, f: Bushing) -> int:
        return int(self._axis is not None)

    def turns(self, f: Bushing, poses: Poses) -> tuple[str, str, Array]:
        R_a = np.asarray(poses(f.a.body)[0], float) @ np.array(f.R_a)
        return f.a.body, f.b.body, R_a @ self._axis

    def guards(self, f: Bushing) -> tuple[str, ...]:
        return ("turn",) if self._axis is None else ()

    def switch(self, f: Bushing, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        raise LawBreakdown(
            f"bushing '{f.name}'",
            f"'{f.b.body}' is turned by {AGAINST} relative to '{f.a.body}', about more than one axis, but a bushing is "
            "valid only below 180 degrees: make it stiffer, or connect the bodies by a hinge",
        )

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

    def shape(self, f: Bushing) -> Hashable:
        return self._axis is None, self._patterns(f)

    def _patterns(self, f: Bushing) -> list[list[int]]:
        return [[i for i, x in enumerate(np.ravel(A).tolist()) if x] for A in (f.K, f.D)]

    def numbers(self, f: Bushing, poses: Poses) -> list[float]:
        rotations = [*np.ravel(f.R_a), *np.ravel(f.R_b)]
        axis = [] if self._axis is None else self._axis.tolist()
        return [
            *f.a.p,
            *f.b.p,
            *map(float, rotations),
            *axis,
            *(x for A in (f.K, f.D) for x in np.ravel(A).tolist() if x),
        ]

    def answer(
        self, f: Bushing, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar, counted: Scalars = ()
    ) -> LawOutput:
        A, B = ends
        (x_a, p_a, v_a), (x_b, p_b, v_b) = attachment(A, p[:3], "a"), attachment(B, p[3:6], "b")
        R_a, R_b = (_rotation(X) @ np.reshape(q, (3, 3)) for X, q in ((A, p[6:15]), (B, p[15:24])))
        given = iter(p[24:] if self._axis is None else p[27:])
        K, D = (filled(pattern, given, (6, 6)) for pattern in self._patterns(f))
        s = p_b - p_a
        R = R_a.T @ R_b
        if self._axis is None:
            theta, J = _rotation_vector(R)
            # trace of R at FARTHEST: fires before the rotation vector becomes singular at half a turn
            guards, turned, turning = [R[0, 0] + R[1, 1] + R[2, 2] - (1.0 + 2.0 * FARTHEST)], [], []
        else:
            axis = p[24:27]
            angle = on_turn(_twist(R, axis, 1.0), counted[0])
            theta, J, guards, turned = angle * axis, np.eye(3), [], [angle]
            # about a fixed axis the relative angular velocity is the rate of the angle
            turning = [axis @ (R_a.T @ (B[15:18] - A[15:18]))]
        x = join(R_a.T @ s, theta)
        dx = join(R_a.T @ (v_b - v_a - cross(A[15:18], s)), J @ (R_a.T @ (B[15:18] - A[15:18])))
        elastic, damped = K @ x, D @ dx
        f_b = -(elastic + damped)
        force, moment = R_a @ f_b[:3], R_a @ (J.T @ f_b[3:])
        return LawOutput(
            # the force on a acts at the point of b: otherwise the pair would have a moment without energy
            [-wrench(x_a + s, force, moment), wrench(x_b, force, moment)],
            heat=damped @ dx,
            stored=0.5 * (elastic @ x),
            guards=guards,
            shown=[*x, *f_b],
            turned=turned,
            turning=turning,
        )

    def shows(self, f: Bushing) -> list[SampledQuantity]:
        place = [
            SampledQuantity("bushing/displacement", f"{f.name}.{c}", "m or rad")
            for c in ("x", "y", "z", "rx", "ry", "rz")
        ]
        return place + [SampledQuantity("bushing/force", x.name, "N or N m") for x in place]


def filled(pattern: list[int], given: Iterator[Scalar], shape: tuple[int, int]) -> Any:
    """Return a matrix of a given shape with given numbers at the flat indices `pattern`, zeros elsewhere."""
    places = set(pattern)
    flat = [next(given) if i in places else 0.0 for i in range(shape[0] * shape[1])]
    return np.array([*flat, None], dtype=object)[:-1].reshape(shape)
