"""A hook rope with mass as a chain of lumps, and where ropes begin and end.

Lumps sit at the places of Gauss and weigh as his quadrature does, so that two of them already have the mass, the centre
of mass and the inertia of the rope that is straight and evenly stretched, and so its swing; what is left to more lumps
is how it vibrates.  They keep the distance of the falls, so that the chain resists yawing as the whole rope does
(T b2 / 4 L).  Golub and Welsch 1969, Calculation of Gauss quadrature rules; here by Newton's method.
"""

from __future__ import annotations

from itertools import pairwise
from math import pi

from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.elementary import cos
from heavylift.kernel.description.mechanics import WORLD, Body, Joint, Line, Point, Rope, System, Vector
from heavylift.nodes.plan.plan import Fidelity, HookRope, Plan

X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)
QUADRATIC = 5  # steps of Newton from places that are right to 1 %


def gauss(n: int) -> list[tuple[float, float]]:
    """Places from 0 to 1 and weights, which add up to 1, of the n lumps."""
    found = []
    for i in range(1, n + 1):
        x = -cos(pi * (i - 0.25) / (n + 0.5))
        for _ in range(QUADRATIC):
            p, slope = _legendre(n, x)
            x -= p / slope
        _, slope = _legendre(n, x)
        found.append(((1.0 + x) / 2.0, 1.0 / ((1.0 - x * x) * slope * slope)))
    return found


def _legendre(n: int, x: float) -> tuple[float, float]:
    """Legendre's polynomial of degree n and its slope."""
    before, p = 1.0, x
    for k in range(2, n + 1):
        before, p = p, ((2 * k - 1) * x * p - (k - 1) * before) / k
    return p, n * (x * p - before) / (x * x - 1.0)


def pieces(fidelity: Fidelity, rope: str) -> dict[str, float]:
    """The ropes that a hook rope is made of, with their parts of its length, from the trolley down.

    The ends pull with the tensions of the rope's ends; the last piece, at the hook, bears its name.
    """
    if fidelity.ropes != "massive":
        return {rope: 1.0}
    places = [0.0, *(x for x, _ in gauss(fidelity.lumps)), 1.0]
    names = [*(f"{rope}~{i}" for i in range(1, fidelity.lumps + 1)), rope]
    return {name: b - a for name, (a, b) in zip(names, pairwise(places), strict=True)}


def chain(plan: Plan, rope: HookRope) -> System:
    """A hook rope as its pieces with lumps between them, at rest under what hangs on it at the start."""
    (x, y, top), (_, _, eye) = _ends(plan, rope)
    parts = pieces(plan.fidelity, rope.name)
    masses = [w * rope.line * rope.L0 for _, w in gauss(plan.fidelity.lumps)]
    loader = next(x for x in plan.loaders if x.name == rope.carries)
    half = max(abs(line.b.p[0]) for line in rope.lines)
    bodies, joints, ropes = [], [], []
    above, z = [line.a for line in rope.lines], top
    for i, (name, part) in enumerate(parts.items()):
        below = loader.upper.mass + loader.lower.mass + sum(masses[i:])
        z -= part * (top - eye)
        last = name == rope.name
        here = f"{rope.name}.lump-{i + 1}"
        ends = [line.b if last else Point(here, (line.b.p[0], 0.0, 0.0)) for line in rope.lines]
        if not last:
            lump, moved = _lump(here, masses[i], half, (x, y, z), plan.fidelity.motion)
            bodies += lump
            joints += moved
        lines = tuple(Line(a, b, line.share) for a, b, line in zip(above, ends, rope.lines, strict=True))
        L0 = part * (top - eye) / (1.0 + below * plan.gravity / rope.EA)
        ropes.append(Rope(name, lines, rope.EA, L0, rope.damping / part, winch=True))
        above = ends
    return System(tuple(bodies), tuple(joints), ropes=tuple(ropes))


def hangs(plan: Plan, rope: HookRope) -> float:
    """Length of a hook rope at the start, under what hangs on it then [m]."""
    return norm([p - q for p, q in zip(*_ends(plan, rope), strict=True)])


def _lump(name: str, mass: float, half: float, at: Vector, motion: str) -> tuple[list[Body], list[Joint]]:
    """Two points of half the mass at +-half along x; it moves as far as the motion goes, and yaws in space."""
    turns = mass * half * half
    ball = Body(name, mass, inertia=((0.0, 0.0, 0.0), (0.0, turns, 0.0), (0.0, 0.0, turns)))
    directions = {"spatial": (X, Y), "across": (Y,), "along": (X,)}[motion]
    bodies, joints, parent, place = [], [], WORLD, at
    for axis, letter in ((X, "x"), (Y, "y")):
        if axis in directions:
            child = f"{name}-{letter}"
            bodies.append(Body(child, 0.0))
            joints.append(Joint(child, "prismatic", parent, child, place, axis=axis, q0=(0.0,), v0=(0.0,)))
            parent, place = child, (0.0, 0.0, 0.0)
    if motion == "spatial":
        last = Joint(f"{name}-z", "cylindrical", parent, name, place, axis=Z, q0=(0.0, 0.0), v0=(0.0, 0.0))
    else:
        last = Joint(f"{name}-z", "prismatic", parent, name, place, axis=Z, q0=(0.0,), v0=(0.0,))
    return [*bodies, ball], [*joints, last]


def _ends(plan: Plan, rope: HookRope) -> tuple[Vector, Vector]:
    """Where a hook rope leaves its trolley and where its eye is at the start, in the world [m]."""
    crane = next(c for c in plan.cranes if c.name == rope.crane)
    hook = next(h for h in crane.hooks if h.rope == rope.name)
    trolley = crane.upper if hook.trolley == "upper" else crane.lower
    loader = next(x for x in plan.loaders if x.name == rope.carries)
    n = len(rope.lines)
    x, y, z = (sum(line.a.p[i] for line in rope.lines) / n for i in range(3))
    ex, ey, ez = (sum(line.b.p[i] for line in rope.lines) / n + loader.pose[i] for i in range(3))
    return (x + crane.gantry.start, y + trolley.axis.start, z), (ex, ey, ez)
