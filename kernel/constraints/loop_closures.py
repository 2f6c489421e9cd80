"""Constraint rows of joints that close loops: one row per direction in which the two sides of a joint cannot move
apart.

Two conditions make every joint type (Haug 1989, section 9.4): the displacement of the joint's point on side B has no
component along a direction e fixed in the parent's side A, `e_A . d = 0`; two directions stay perpendicular, `e_A . e_B
= 0`. Each row has its residual g, its wrench w (g' = w . (V_B - V_A)) and the bias, the part of g'' besides w . (A_B -
A_A). A new joint type is one entry of `CLOSURES`; its wrenches must do no work along the joint's own velocities.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from types import SimpleNamespace

import numpy as np
from heavylift.kernel.algebra.attitudes import quaternions
from heavylift.kernel.algebra.dense import least_norm, norm
from heavylift.kernel.algebra.elementary import atan2, cos, sin
from heavylift.kernel.algebra.spatial import cross, exact, join
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar
from heavylift.kernel.description.mechanics import JOINTS, Joint
from heavylift.kernel.forces.force_law import BODY
from heavylift.kernel.multibody.motion import axes_of, columns

SIDES = 25  # per side the joint's point and the rows axis, second, third of its frame; then the pitch
AXIS, SECOND, THIRD = range(3)
RATES = 1e-9  # singular value of the velocity columns of a joint below which two of its motions are one


@dataclass(frozen=True)
class JointClosure:
    """Geometry of a joint that closes a loop, in world axes: directions of sides A and B, rates, d = p_B - p_A."""

    a: Array  # rows: axis, second, third
    b: Array
    da: Array
    db: Array
    d: Array
    pitch: Scalar


@dataclass(frozen=True)
class Condition:
    """A condition g = 0 of a loop joint: its residual g and generalised force, and the rates of both."""

    g: Scalar
    f: Array  # force at the joint's point on B; opposite on A
    n: Array  # moment on B; opposite on A
    df: Array
    dn: Array


def _slide(i: int) -> Callable[[JointClosure], Condition]:
    def condition(p: JointClosure) -> Condition:
        # displacement along an axis of the parent: moment about the point on B is zero, the parent's arm is in `wa`
        return Condition(p.a[i] @ p.d, p.a[i], np.zeros(3), p.da[i], np.zeros(3))

    return condition


def _turn(i: int, j: int) -> Callable[[JointClosure], Condition]:
    def condition(p: JointClosure) -> Condition:
        a, b, da, db = p.a[i], p.b[j], p.da[i], p.db[j]
        # two directions stay perpendicular: the gradient of a . b by rotations is b x a
        return Condition(a @ b, np.zeros(3), cross(b, a), np.zeros(3), cross(db, a) + cross(b, da))

    return condition


def _twist(p: JointClosure) -> Condition:
    """Return the condition that two bent shafts turn equally: no relative rotation about the bisector of their axes."""
    # equal rotation of both shafts about the bisector, without a singularity at zero bend
    x, y = _turn(SECOND, THIRD)(p), _turn(THIRD, SECOND)(p)
    return Condition(x.g - y.g, np.zeros(3), x.n - y.n, np.zeros(3), x.dn - y.dn)


def _thread(p: JointClosure) -> Condition:
    """Return the condition of a thread: pitch * angle - a . d, periodic, so that any number of turns is the same."""
    c, s = p.a[SECOND] @ p.b[SECOND], p.a[THIRD] @ p.b[SECOND]
    phase = (p.a[AXIS] @ p.d) / p.pitch
    # sin of the difference between angle and phase: the same for any number of turns of the thread
    g = p.pitch * (s * cos(phase) - c * sin(phase))
    return Condition(g, -p.a[AXIS], p.pitch * p.a[AXIS], -p.da[AXIS], p.pitch * p.da[AXIS])


_POINT = (_slide(AXIS), _slide(SECOND), _slide(THIRD))
_LINE = (_slide(SECOND), _slide(THIRD))
_PARALLEL = (_turn(AXIS, SECOND), _turn(AXIS, THIRD))
_ALIGNED = (*_PARALLEL, _turn(SECOND, THIRD))

CLOSURES: dict[str, tuple[Callable[[JointClosure], Condition], ...]] = {
    "fixed": (*_POINT, *_ALIGNED),
    "revolute": (*_POINT, *_PARALLEL),
    "prismatic": (*_LINE, *_ALIGNED),
    "cylindrical": (*_LINE, *_PARALLEL),
    "screw": (*_LINE, *_PARALLEL, _thread),
    "universal": (*_POINT, _turn(AXIS, SECOND)),
    "planar": (_slide(AXIS), *_PARALLEL),
    "constant-velocity": (*_POINT, _twist),
    "spherical": _POINT,
    "free": (),
}


def residual_unit(kind: str, i: int) -> str:
    """Return the unit of the i-th residual of a joint type: m for a displacement, rad for a rotation."""
    return "rad" if CLOSURES[kind][i] in (*_ALIGNED, CLOSURES["universal"][3], _twist) else "m"


def closure_numbers(joint: Joint) -> list[float]:
    """Return the arguments (25,) of `closure_function`: position and directions of the joint in both bodies, pitch."""
    basis = _basis(joint)
    sides = [(joint.p_PJ, basis @ exact(joint.R_PJ).T), (joint.p_CJ, basis @ exact(joint.R_CJ).T)]
    return [*(float(x) for p, rows in sides for x in (*p, *rows.ravel())), joint.pitch]


def closed_coordinates(joint: Joint, A: Array, B: Array) -> list[float]:
    """Return the coordinates (n_q,) of a loop joint from the poses of its sides A and B; angles are nearest to `q0`."""
    a, b, _, _, d, _ = vars(_pair(exact(closure_numbers(joint)), exact(A), exact(B))[0]).values()
    along = [float(x @ d) for x in a]
    M = np.array([[float(x @ y) for y in b] for x in a])  # (3, 3) the child's directions in the parent's
    type_ = JOINTS[joint.kind]
    asked = joint.q0 or type_.rest
    if joint.kind == "spherical":
        basis = _basis(joint).astype(float)
        return [float(x) for x in quaternions((basis.T @ M @ basis)[None])[0]]
    # half angles: a constant-velocity joint is symmetric about the plane that bisects its shafts
    if joint.kind == "constant-velocity":  # M = turn(second, x) turn(third, 2 y) turn(second, x)
        x = 0.5 * atan2(M[AXIS, THIRD] - M[THIRD, AXIS], M[AXIS, AXIS] + M[THIRD, THIRD])
        bent = cos(x) * (M[SECOND, AXIS] - M[AXIS, SECOND]) + sin(x) * (M[SECOND, THIRD] + M[THIRD, SECOND])
        y = 0.5 * atan2(0.5 * bent, M[SECOND, SECOND])
        return min(
            # the same rotation is described by two pairs of angles: take that nearer to the start value
            ([near(z, q) for z, q in zip(p, asked, strict=True)] for p in ((x, y), (x + pi, -y))),
            key=lambda p: sum(abs(z - q) for z, q in zip(p, asked, strict=True)),
        )
    turn = atan2(M[THIRD, SECOND], M[SECOND, SECOND])
    known = {"angle": turn, "angle1": turn, "angle2": atan2(M[AXIS, THIRD], M[AXIS, AXIS])}
    known |= {"travel": along[AXIS], "x": along[SECOND], "y": along[THIRD]}
    if joint.kind == "screw":
        return [along[AXIS] / joint.pitch]
    return [
        near(known[c], q) if type_.turns(i) else known[c]
        for i, (c, q) in enumerate(zip(type_.coordinates, asked, strict=True))
    ]


def closed_rates(joint: Joint, A: Array, B: Array) -> list[float]:
    """Return the velocities (n_v,) of a loop joint from the poses and twists of its sides A and B."""
    R_A, R_B = (np.reshape(exact(e[:9]), (3, 3)) for e in (A, B))
    _, (x_a, _), (V_A, V_B), v = _pair(exact(closure_numbers(joint)), exact(A), exact(B))
    # velocity of the point on B relative to A at the same place, free of the common motion
    twist = join(V_B[:3] - V_A[:3], v - V_A[3:] - cross(V_A[:3], x_a))
    q = exact(closed_coordinates(joint, A, B))
    frames = R_A @ exact(joint.R_PJ), R_B @ exact(joint.R_CJ)
    side = SimpleNamespace(kind=joint.kind, axes=exact(axes_of(joint)), pitch=joint.pitch)
    S, _ = columns(side, q, np.zeros(JOINTS[joint.kind].n_v), *frames, np.zeros(3))
    rows = [[float(x) for x in row] for row in zip(*S, strict=True)]
    return least_norm(rows, [float(x) for x in twist], RATES)


def near(x: float, y: float) -> float:
    """Return the angle that equals x [rad] modulo 2 pi and is nearest to y."""
    # wrapped into half a turn around y
    return float(y + (x - y + pi) % (2.0 * pi) - pi)


def _basis(joint: Joint) -> Array:
    """Return the axis, second and third direction of a joint in its frame as rows (3, 3)."""
    axis = exact(joint.axis)
    second = exact(joint.second) if JOINTS[joint.kind].axes > 1 else _perpendicular(axis)
    return np.array([axis, second, cross(axis, second)])


def _perpendicular(axis: np.ndarray) -> np.ndarray:
    e = exact(np.zeros(3))
    # the coordinate axis most nearly perpendicular to the given one: no division by a small number
    e[int(np.argmin(abs(axis.astype(float))))] = 1.0
    e = e - (e @ axis) * axis
    unit: np.ndarray = e / norm(e.tolist())
    return unit


def closure_function(kind: str) -> Function:
    """Return the traced function that computes the constraint rows of a loop joint of one type.

    `gap`, `rate`, `bias` (n,), and wrenches `wa`, `wb` (6 n,) about the reference points of the trees of A and B.
    """

    def body(p: Array, A: Array, B: Array) -> Outputs:
        pair, (x_a, x_b), (V_A, V_B), v = _pair(p, A, B)
        rows = [condition(pair) for condition in CLOSURES[kind]]
        # f at x on the body about the tree's point: moment x x f plus the free moment
        wa = [join(cross(x_a, c.f) + c.n, c.f) for c in rows]
        wb = [join(cross(x_b, c.f) + c.n, c.f) for c in rows]

        def bias(x: Array, c: Condition) -> Array:
            # derivative of the wrench times the twist: the part of g'' besides w . (A_B - A_A)
            return join(cross(v, c.f) + cross(x, c.df) + c.dn, c.df)

        return {
            "gap": [c.g for c in rows],
            "rate": [b @ V_B - a @ V_A for a, b in zip(wa, wb, strict=True)],
            "bias": [bias(x_b, c) @ V_B - bias(x_a, c) @ V_A for c in rows],
            "wa": np.array(wa),
            "wb": np.array(wb),
        }

    return Function(f"closure_{kind.replace('-', '_')}", body, {"p": SIDES, "A": BODY, "B": BODY})


def _pair(p: Array, A: Array, B: Array) -> tuple[JointClosure, tuple[Array, Array], tuple[Array, Array], Array]:
    """Return the geometry of both sides; the joint's point on B from each tree's point; both twists; its velocity."""
    (R_A, o_A, r_A, V_A), (R_B, o_B, r_B, V_B) = (
        (np.reshape(e[:9], (3, 3)), e[9:12], e[12:15], e[15:]) for e in (A, B)
    )
    p_A, p_B = o_A + r_A + R_A @ p[:3], o_B + r_B + R_B @ p[12:15]
    a = np.array([R_A @ e for e in np.reshape(p[3:12], (3, 3))])
    b = np.array([R_B @ e for e in np.reshape(p[15:24], (3, 3))])
    da = np.array([cross(V_A[:3], e) for e in a])
    db = np.array([cross(V_B[:3], e) for e in b])
    x_b = p_B - o_B
    pair = JointClosure(a, b, da, db, p_B - p_A, p[24])
    return pair, (p_B - o_A, x_b), (V_A, V_B), V_B[3:] + cross(V_B[:3], x_b)
