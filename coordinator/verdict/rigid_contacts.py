"""Speeds at which blocks touch rigid things, by which no support stands: obstacles, the floor, other blocks.

The kernel reports each impact, and a sample shows it after its impulse. The speed before it follows from where the
touching points were at the sample before, and how fast they moved there: exact for a constant acceleration.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from heavylift.kernel.description.contacts import Ball, Box, Contact, Plane
from heavylift.kernel.description.units import WORLD
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.shapes import GROUND
from numpy.typing import NDArray

from .distance import Placed, exactly, separation
from .history import History, RunHistory, blocks
from .rotating import FREE, matrices

Floats = NDArray[np.float64]
Reported = Sequence[tuple[float, str, str]]  # time [s], contact, what happened
LEFT = "open"  # of what the kernel reports of a contact
BOUNCE = 0.01  # [m] a point that comes down from less has landed before
GAP_AT_TOUCH = 1e-6  # [m] at an impact; the kernel closes a gap to 1e-8
SHORT = 1e-6  # [s] in which a place, exact to 1e-14 m, shows no speed; nothing accelerates in it
BELOW = 0.7  # of the upward part of a normal: what is no steeper than 45 degrees bears
CORNERS = np.array([*product((-1.0, 1.0), repeat=3)])


@dataclass(frozen=True)
class RigidTouch:
    """The instant [s] at which a block touched or left another body or obstacle in rigid contact."""

    block: str
    other: str
    t: float
    speed: float | None  # closing speed [m/s]; None as it left
    up: float  # cosine between upwards and the direction from the thing to the block
    part: History
    i: int  # sample of the part

    @property
    def below(self) -> bool:
        """Whether the other body is below the block and can carry it."""
        return self.up > BELOW


def touches_of(plan: Plan, past: RunHistory, reported: Reported) -> Iterator[RigidTouch]:
    """Yield each instant at which a rigid contact of a block closed or opened, except bounces and loads landing on the
    block."""
    cargo = {cargo.body for machine in plan.machines for cargo in machine.cargo}
    known = {c.name: c for machine in plan.machines for c in machine.system.contacts}
    joints = {j.child: j.name for machine in plan.machines for j in machine.system.joints}
    events = sorted({(t, name, what == LEFT) for t, name, what in reported if name in known})
    for part in blocks(past) if events else ():
        since = dict[frozenset[str], int]()  # pair of bodies -> sample at which it touched or parted last
        for t, name, left in (x for x in events if part.t[0] < x[0] <= part.t[-1]):
            i, contact = int(np.searchsorted(part.t, t)), known[name]
            a, b = contact.a.body, contact.b.body
            if not {a, b} - {WORLD} <= {*part.poses}:
                continue
            points, n = _touching(contact, part, i)
            begin = since.get(frozenset((a, b)), 0)
            since[frozenset((a, b))] = i
            fell = [x for x in points if not left and _height(part, begin, i, x, a, b, n) >= BOUNCE]
            closing = [_before(part, i, x, a, joints) - _before(part, i, x, b, joints) for x in fell]
            speed = max((float(v @ n) for v in closing), default=None)
            for body, other, up in ((a, b, -float(n[2])), (b, a, float(n[2]))):
                if body in cargo and (up > -BELOW or other not in cargo) and (left or speed is not None):
                    yield RigidTouch(body, GROUND if other == WORLD else other, t, speed, up, part, i)


def pressing(plan: Plan, past: RunHistory) -> dict[str, tuple[float, float]]:
    """Return, for each rigid obstacle, the largest force [N] with which blocks press on it, and the time [s]."""
    cargo = {cargo.body for machine in plan.machines for cargo in machine.cargo}
    names: dict[str, list[str]] = {}
    for c in (c for machine in plan.machines for c in machine.system.contacts):
        one, other = c.a.body, c.b.body
        if cargo & {one, other}:
            names.setdefault(one if other in cargo and one not in cargo else other, []).append(c.name)
    found: dict[str, tuple[float, float]] = {}
    for part in blocks(past) if names else ():
        for other, some in names.items():
            F = np.sum([part.tensions[name] for name in some if name in part.tensions] or [np.zeros(1)], axis=0)
            k = int(F.argmax()) if F.any() else 0
            if F.any() and F[k] > found.get(other, (0.0, 0.0))[0]:
                found[other] = float(F[k]), float(part.t[k])
    return found


def _touching(c: Contact, part: History, i: int) -> tuple[Floats, Floats]:
    """Return the points (m, 3) at which two shapes touch at sample i, and the normal (3,) from the first to the
    second."""
    a = _placed(c.a, part, i)
    if isinstance(c.b, Plane):
        _, R = _pose(part, c.b.body, i)
        n = -R @ np.array(c.b.normal) / np.linalg.norm(c.b.normal)
        own = _corners(a) + float(a.radius) * n
        reach = own @ n
        return own[reach >= reach.max() - GAP_AT_TOUCH], n
    b = _placed(c.b, part, i)
    near = exactly(a, b)
    rounded = float(a.radius) + float(b.radius) > 0.0
    n = near.normal[0] if rounded else separation(a, b)[1][0]
    found = [*_corners(a)[_inside(_corners(a), b)], *_corners(b)[_inside(_corners(b), a)]] if not rounded else []
    return np.array(found or [near.a[0]]), n


def _placed(x: Ball | Box, part: History, i: int) -> Placed:
    p, R = _pose(part, x.body, i)
    own, half = (np.array(x.R), np.array(x.size) / 2.0) if isinstance(x, Box) else (np.eye(3), np.zeros(3))
    return Placed((p + R @ np.array(x.p))[None], (R @ own)[None], half[None], getattr(x, "radius", 0.0))


def _pose(part: History, body: str, i: int) -> tuple[Floats, Floats]:
    if body == WORLD:
        return np.zeros(3), np.eye(3)
    pose = part.poses[body][i]
    return pose[:3], matrices(pose[None, 3:])[0]


def _corners(x: Placed) -> Floats:
    found: Floats = x.centre[0] + (CORNERS * x.half[0]) @ x.R[0].T
    return found if x.half.any() else found[:1]


def _inside(points: Floats, box: Placed) -> NDArray[np.bool_]:
    return np.asarray((np.abs((points - box.centre[0]) @ box.R[0]) <= box.half[0] + GAP_AT_TOUCH).all(axis=1))


def _height(part: History, begin: int, i: int, x: Floats, a: str, b: str, n: Floats) -> float:
    """Return how far [m] the points of two bodies that are both at x at sample i were apart, at most, from sample
    `begin` on, along a normal n (3,)."""
    one, other = (_path(part, slice(begin, i + 1), x, body) for body in (a, b))
    return float(((other - one) @ n).max())


def _path(part: History, samples: slice, x: Floats, body: str) -> Floats:
    """Return the places (n, 3) [m] at some samples of the point of a body that is at x at the last one."""
    if body == WORLD:
        return x[None]
    pose = part.poses[body][samples]
    R = matrices(pose[:, 3:])
    found: Floats = pose[:, :3] + R @ (R[-1].T @ (x - pose[-1, :3]))
    return found


def _before(part: History, i: int, x: Floats, body: str, joints: Mapping[str, str]) -> Floats:
    """Return the velocity (3,) [m/s] of the point of a body that is at x at sample i, just before it."""
    at, seconds = _path(part, slice(i - 1, i + 1), x, body), float(part.t[i] - part.t[i - 1])
    mean = np.zeros(3) if seconds < SHORT else (at[-1] - at[0]) / seconds
    then = velocity(part, body, joints.get(body, ""), at[0], i - 1)
    if then is None:
        return mean
    return then if seconds < SHORT else np.asarray(2.0 * mean - then)


def velocity(part: History, body: str, joint: str, at: Floats, i: int) -> Floats | None:
    """Return the velocity (3,) [m/s] of a body at a point (3,) and sample i, from the speeds of its free joint; None if
    unrecorded."""
    names = [f"{joint}.{column}" for group in FREE for column in group]
    if not {*names} <= {*part.speeds} or body not in part.poses:
        return None
    p, R = _pose(part, body, i)
    v, w = np.array([part.speeds[name][i] for name in names]).reshape(2, 3)
    return np.asarray(R @ (v + np.cross(w, R.T @ (at - p))))
