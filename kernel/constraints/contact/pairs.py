"""The table of pairs of contact shapes: gap functions, number of slots for touching points, and contact frames of each
pair.

A *candidate* is watched by its witness. One that touches takes a *slot*, which has the three rows of a contact; rows
are expensive, so a pair has only as many slots as places that can push at once. The numbers of a slot are parameters of
the run, written at the touch; a new pair of shapes is one entry.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.compiler.symbol import Array, Scalar, select
from heavylift.kernel.description.contacts import Ball, Box, Contact, Plane, Shape
from heavylift.kernel.errors import KernelError

from . import candidates, frames
from .candidates import SIGNS, VERTICES, Gap, OrientedBox as BoxAt, edge
from .frames import BALLS, CORNER, EDGE, EDGES, FACE, ContactFrame, Side

HELD = 19  # numbers of what a slot holds: kind, those of its frame, half widths of the face or edges
UNIT = 1e-6  # how far a rotation may be off by rounding
EVERYWHERE = 1e9  # [m] half width of a plane
Pose = tuple[np.ndarray, np.ndarray]  # position [m], rotation matrix
ON_B, ON_A, CROSSING = 0.0, 1.0, 2.0  # kinds between two boxes: vertex of A on a face of B, of B on A, edges
ON_EDGE, ON_CORNER = 1.0, 2.0  # kinds of a ball on a box, beside ON_B
PARALLEL = 1e-12  # [m, m2] of edges that have a direction
NEAREST = 1e-12  # [m] beyond a face where a ball lies at its edge


@dataclass(frozen=True)
class ContactPair:
    """A pair of contact shapes, such as ball and plane, with its gap functions and contact frames."""

    candidates: int
    slots: int
    watch: Callable[[Array, Array, Array, Array], list[Gap]]  # (a, b, A, B) -> gap functions
    frame: Callable[[Array, Array, Array], ContactFrame]  # (h, A, B) -> frame of a touching point
    hold: Callable[[int, np.ndarray, np.ndarray, np.ndarray, np.ndarray], list[float]]  # candidate, a, b, A, B -> (19,)


def shape_numbers(s: Shape) -> list[float]:
    """Return the numbers that describe a contact shape.

    Ball: centre, radius; box: centre, axes as rows, half edges; plane: point, normal.
    """
    if isinstance(s, Ball):
        return [*s.p, s.radius]
    if isinstance(s, Box):
        return [*s.p, *(s.R[i][j] for j in range(3) for i in range(3)), *(0.5 * e for e in s.size)]
    return [*s.p, *(e / norm(s.normal) for e in s.normal)]


def _axes(n: np.ndarray) -> np.ndarray:
    """Return n and two orthogonal directions, the first perpendicular to the axis of n's smallest component."""
    t = np.cross(np.eye(3)[int(np.argmin(np.abs(n)))], n)
    t = t / norm(t.tolist())
    return np.array([n, t, np.cross(n, t)])


def _held(kind: float, numbers: list[float], half: tuple[float, float] = (EVERYWHERE, EVERYWHERE)) -> list[float]:
    return [kind, *numbers, *[0.0] * (HELD - 3 - len(numbers)), *half]


def _on_plane(centre: Array, radius: float, plane: np.ndarray) -> list[float]:
    return _held(ON_B, [*centre, radius, *plane[:3], *_axes(plane[3:6]).ravel()])


def _vertex(i: int, box: np.ndarray) -> np.ndarray:
    """Return the i-th vertex of a box in its body's frame."""
    p: np.ndarray = box[:3] + (np.array(VERTICES[i]) * box[12:15]) @ np.reshape(box[3:12], (3, 3))
    return p


def _two_balls(i: int, a: np.ndarray, b: np.ndarray, A: np.ndarray, B: np.ndarray) -> list[float]:
    n = Side(B).R.T @ (Side(A).place(a[:3]) - Side(B).place(b[:3]))
    return _held(ON_B, [*a, *b, *np.eye(3)[int(np.argmin(np.abs(n)))]])


def _on_face(kind: float, p: np.ndarray, radius: float, box: np.ndarray, own: np.ndarray, other: np.ndarray,
             between: np.ndarray) -> list[float]:  # fmt: skip
    """Return the slot numbers of a ball at p of body `own` on the face of a box of `other` that separates the shapes
    best; `between`: vector from the centre of the box to that of the other shape."""
    at = BoxAt(box, other)
    d = at.axes @ (Side(own).place(p) - at.c)
    outside = np.abs(d) - at.h
    near = outside >= outside.max() - candidates.NEAR
    k = int(np.argmax(np.where(near, np.abs(at.axes @ between) - at.h, -np.inf)))
    axes = np.reshape(box[3:12], (3, 3))
    n = axes[k] * (1.0 if d[k] > 0.0 else -1.0)
    t, s = (k + 1) % 3, (k + 2) % 3
    F = np.array([n, axes[t], np.cross(n, axes[t])])
    return _held(kind, [*p, radius, *(box[:3] + at.h[k] * n), *F.ravel()], (float(at.h[t]), float(at.h[s])))


def _ball_on_box(i: int, a: np.ndarray, b: np.ndarray, A: np.ndarray, B: np.ndarray) -> list[float]:
    """Return the slot numbers for the face, edge or corner nearest to the ball's centre; points touch faces only."""
    at = BoxAt(b, B)
    between = Side(A).place(a[:3]) - at.c
    d = at.axes @ between
    beyond = [k for k in range(3) if abs(d[k]) > at.h[k] + NEAREST]
    axes = np.reshape(b[3:12], (3, 3)) * np.where(d > 0.0, 1.0, -1.0)[:, None]
    if len(beyond) < 2 or a[3] == 0.0:
        return _on_face(ON_B, a[:3], float(a[3]), b, A, B, between)
    q = b[:3] + sum(at.h[k] * axes[k] for k in beyond)
    if len(beyond) == 3:
        return _held(ON_CORNER, [*a[:4], *q, *axes.ravel()], (1.0, 1.0))
    along = 3 - sum(beyond)
    across = axes[beyond[0]] - axes[beyond[1]]
    return _held(ON_EDGE, [*a[:4], *q, *axes[along], *across], (float(at.h[along]), 1.0))


def _frame_of_ball_on_box(h: Array, A: Array, B: Array) -> ContactFrame:
    """Return the frame of a ball on a face, an edge or a corner of a box; the numbers h of the slot select which."""
    g = h[1:]
    kinds = frames.face(g[:FACE], A, B), frames.edge(g[:EDGE], A, B), frames.corner(g[:CORNER], A, B)
    return _chosen(h[0], kinds)


def _two_boxes(i: int, a: np.ndarray, b: np.ndarray, A: np.ndarray, B: np.ndarray) -> list[float]:
    between = BoxAt(a, A).c - BoxAt(b, B).c
    n = len(VERTICES)
    if i < n:
        return _on_face(ON_B, _vertex(i, a), 0.0, b, A, B, between)
    if i < 2 * n:
        return _on_face(ON_A, _vertex(i - n, b), 0.0, a, B, A, between)
    at_a, at_b = BoxAt(a, A), BoxAt(b, B)
    x = candidates.crossings(at_a, at_b)[(i - 2 * n) // 16]
    p, q = (edge(at, j, SIGNS[k]) for at, j, k in ((at_a, x.i, (i - 2 * n) % 16 // 4), (at_b, x.j, (i - 2 * n) % 4)))
    along, across = at_a.axes[x.i], at_b.axes[x.j]
    sign = 1.0 if np.cross(along, across) @ x.n > 0.0 else -1.0
    ends = [(Side(A), p, sign * along), (Side(B), q, across)]
    numbers = [e for s, at, along in ends for e in (*(s.R.T @ (at - s.o - s.r)), *(s.R.T @ along))]
    return _held(CROSSING, numbers, (float(at_a.h[x.i]), float(at_b.h[x.j])))


def _frame_of_boxes(h: Array, A: Array, B: Array) -> ContactFrame:
    """Return the frame of two boxes; the numbers h of the slot select a face of B, one of A, or crossing edges."""
    g = h[1:]
    on_b, on_a = frames.face(g[:FACE], A, B), _turned(frames.face(g[:FACE], B, A))
    crossed = frames.edges(g[:EDGES], A, B)
    return _chosen(h[0], (on_b, on_a, crossed))


def _chosen(kind: Scalar, found: tuple[ContactFrame, ContactFrame, ContactFrame]) -> ContactFrame:
    def choose(name: str) -> Any:
        x, y, z = (getattr(f, name) for f in found)
        return select(kind > 1.5, z, select(kind > 0.5, y, x))

    return ContactFrame(*(choose(name) for name in ("gap", "x", "dx", "F", "dF", "along")))


def _turned(f: ContactFrame) -> ContactFrame:
    """Return the same contact with the normal from A to B."""
    return ContactFrame(f.gap, f.x, f.dx, -f.F, -f.dF, f.along)


PAIRS: dict[tuple[type, type], ContactPair] = {
    (Ball, Plane): ContactPair(
        1, 1, candidates.ball_plane,
        lambda h, A, B: frames.face(h[1 : 1 + FACE], A, B),
        lambda i, a, b, A, B: _on_plane(a[:3], a[3], b),
    ),
    (Ball, Ball): ContactPair(
        1, 1, candidates.ball_ball, lambda h, A, B: frames.balls(h[1 : 1 + BALLS], A, B), _two_balls
    ),
    (Ball, Box): ContactPair(1, 1, candidates.ball_box, _frame_of_ball_on_box, _ball_on_box),
    (Box, Plane): ContactPair(
        8, 4, candidates.box_plane,
        lambda h, A, B: frames.face(h[1 : 1 + FACE], A, B),
        lambda i, a, b, A, B: _on_plane(_vertex(i, a), 0.0, b),
    ),
    (Box, Box): ContactPair(160, 4, candidates.box_box, _frame_of_boxes, _two_boxes),
}  # fmt: skip


def pair_of(c: Contact) -> ContactPair:
    """Return the table entry for the two shapes of a contact; raises KernelError if there is none."""
    pair = PAIRS.get((type(c.a), type(c.b)))
    if pair is None:
        a, b = type(c.a).__name__.lower(), type(c.b).__name__.lower()
        known = ", ".join(f"{x.__name__.lower()} - {y.__name__.lower()}" for x, y in PAIRS)
        raise KernelError(f"contact '{c.name}': {a} against {b} is not possible; pairs, in this order, are {known}")
    return pair


def check_contact(c: Contact) -> None:
    """Raise KernelError for a contact with invalid shapes, friction or restitution."""
    where = f"contact '{c.name}'"
    pair_of(c)
    if c.a.body == c.b.body:
        raise KernelError(f"{where}: both shapes belong to '{c.a.body}'; a body cannot touch itself")
    if not 0.0 <= c.restitution <= 1.0:
        raise KernelError(f"{where}: restitution is {c.restitution:g}; it must lie between 0 and 1")
    for shape in (c.a, c.b):
        if isinstance(shape, Ball) and shape.radius < 0.0:
            raise KernelError(f"{where}: radius {shape.radius:g} m of '{shape.body}'; it cannot be negative")
        if isinstance(shape, Box) and min(shape.size) <= 0.0:
            raise KernelError(f"{where}: the edges of the box of '{shape.body}' are {shape.size} m; make them positive")
        if isinstance(shape, Box) and np.abs(np.array(shape.R) @ np.transpose(shape.R) - np.eye(3)).max() > UNIT:
            raise KernelError(f"{where}: R of the box of '{shape.body}' is not a rotation; give unit vectors")
        if isinstance(shape, Plane) and not norm(shape.normal) > 0.0:
            raise KernelError(f"{where}: the normal of its plane is zero; give it a direction")


def gap(c: Contact, a: Pose, b: Pose) -> float:
    """Return the gap [m] of two contact shapes, for bodies at given poses; the negative depth if they overlap.

    Along the best separating axis: otherwise a lower bound of their distance.
    """
    (p, E, r), (q, F, s) = _solid(c.a, a), _solid(c.b, b)
    d = p - q
    if isinstance(c.b, Plane):
        n = (b[1] * np.array(c.b.normal)).sum(axis=1)[None] / norm(c.b.normal)
    else:
        across = [np.cross(x, y) for x in E for y in F]
        n = np.array([x for x in (*E, *F, *across, d) if norm(x.tolist()) > PARALLEL])
        n = n / np.sqrt((n * n).sum(axis=1))[:, None]
        n = n * np.where((n * d).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    reach = sum((np.abs((n * edge).sum(axis=1)) for edge in (*E, *F)), np.zeros(len(n)))
    return float(((n * d).sum(axis=1) - reach).max(initial=-np.inf if len(n) else 0.0) - r - s)


def _solid(s: Shape, at: Pose) -> tuple[np.ndarray, np.ndarray, float]:
    """Return centre (3,), half edges as rows (n, 3) in the world, and radius of a shape; for a plane a point [m]."""
    place, R = at
    middle = place + (R * np.array(s.p)).sum(axis=1)
    if not isinstance(s, Box):
        return middle, np.zeros((0, 3)), s.radius if isinstance(s, Ball) else 0.0
    axes = np.array([[(R[i] * column).sum() for i in range(3)] for column in np.array(s.R).T])
    return middle, axes * (np.array(s.size) / 2)[:, None], 0.0
