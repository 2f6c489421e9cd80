"""A rope with mass as a chain of lumps.

Two lumps sit at the places of Gauss, so that they already have the mass, the centre of mass and the inertia of the rope
that is straight and evenly stretched, and so its swing; what is left to more lumps is how it vibrates.  These sit in
the middles of equal parts: so they come closer to the rope with each more, and what they change by tells by how much
they are off.  At the places of Gauss they do not, and the last one draws to the hook as 1/n2, which overtakes it when
it recoils.  Lumps keep the distance of the falls, so that the chain resists yawing as the whole rope does (T b2 / 4 L).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from heavylift.kernel.description.mechanics import WORLD, Body, Joint, Line, Point, Rope, System, Vector
from heavylift.nodes.plan.mechanism import Heavy

X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)
GAUSS = 0.28867513459481287  # 1/sqrt(12): the radius of gyration of a straight rope, as part of its length


def lumped(n: int) -> list[tuple[float, float]]:
    """Places from 0 to 1 and weights, which add up to 1, of the n lumps."""
    if n == 2:
        return [(0.5 - GAUSS, 0.5), (0.5 + GAUSS, 0.5)]
    return [((i + 0.5) / n, 1.0 / n) for i in range(n)]


def pieces(rope: str, lumps: int) -> dict[str, float]:
    """Names of the pieces of a hook rope with their shares of its length, from the top.

    The ends pull with the tensions of the rope's ends; the last piece, at the hook, bears its name.
    """
    places = [0.0, *(x for x, _ in lumped(lumps)), 1.0]
    names = [*(f"{rope}~{i}" for i in range(1, lumps + 1)), rope]
    return {name: b - a for name, (a, b) in zip(names, pairwise(places), strict=True)}


def chain(row: Heavy, rope: Rope, gravity: float, lumps: int, motion: str) -> System:
    """A rope as a chain of pieces and lumps, at rest under its load at the start.

    What of it does not hang, such as the part to the drum, belongs to the first piece and has no mass.  Each piece is
    damped as its share of the whole length is, so that the chain is damped as the rope.
    """
    (x, y, top), (_, _, eye) = row.ends
    parts, falls = pieces(rope.name, lumps), rope.lines[: len(row.beside)]
    masses = [w * row.line * (rope.L0 - row.lead) for _, w in lumped(lumps)]
    shares = [line.share for line in falls]
    bodies, joints, ropes = [], [], []
    above, z = [line.a for line in falls], top
    for i, (name, part) in enumerate(parts.items()):
        below = row.below + sum(masses[i:])
        z -= part * (top - eye)
        last = name == rope.name
        here = f"{rope.name}.lump-{i + 1}"
        ends = [line.b if last else Point(here, p) for line, p in zip(falls, row.beside, strict=True)]
        if not last:
            lump, moved = _lump(here, masses[i], row.beside, shares, (x, y, z), motion)
            bodies += lump
            joints += moved
        lines = tuple(Line(a, b, share) for a, b, share in zip(above, ends, shares, strict=True))
        length = part * (top - eye)
        if i == 0:
            lines, length = lines + rope.lines[len(falls) :], length + row.lead
        L0 = length / (1.0 + below * gravity / rope.EA)
        damping = rope.damping * (top - eye + row.lead) / length
        ropes.append(Rope(name, lines, rope.EA, L0, damping, rope.winch, rope.hooked))
        above = ends
    return System(tuple(bodies), tuple(joints), ropes=tuple(ropes))


def _lump(
    name: str, mass: float, beside: Sequence[Vector], shares: Sequence[float], at: Vector, motion: str
) -> tuple[list[Body], list[Joint]]:
    """Lumps of all falls with their shares of the mass, free along the motion, with yaw in space."""

    def product(i: int, j: int) -> float:
        return sum((share * mass * p[i] * p[j] for share, p in zip(shares, beside, strict=True)), 0.0)

    x, y, z = (product(i, i) for i in range(3))
    a, b, c = (0.0 - product(i, j) for i, j in ((0, 1), (0, 2), (1, 2)))
    ball = Body(name, mass, inertia=((y + z, a, b), (a, x + z, c), (b, c, x + y)))
    directions = {"spatial": (X, Y), "across": (Y,), "along": (X,)}[motion]
    bodies, joints, parent, place = [], [], WORLD, at
    for axis, letter in ((X, "x"), (Y, "y")):
        if axis in directions:
            child = f"{name}-{letter}"
            bodies.append(Body(child, 0.0))
            joints.append(Joint(child, "prismatic", parent, child, place, axis=axis, q0=(0.0,), v0=(0.0,)))
            parent, place = child, (0.0, 0.0, 0.0)
    yaws = motion == "spatial" and x + y > 0.0
    rest = (0.0, 0.0) if yaws else (0.0,)
    last = Joint(f"{name}-z", "cylindrical" if yaws else "prismatic", parent, name, place, axis=Z, q0=rest, v0=rest)
    return [*bodies, ball], [*joints, last]
