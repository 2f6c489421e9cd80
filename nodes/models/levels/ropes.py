"""Rigid hook ropes and slings, and hook ropes with mass: at their ends, or as lumps.

A rigid hook rope has the length at which it hangs at the start; if its mass is lumped at its ends, the unstretched
length is chosen so that it hangs there at rest. If a part of the rope continues to a drum, the falls have one lump in
their middle instead, and rigid ropes have no mass.

A rope with mass can be a chain of lumps.

Two lumps are placed at the Gauss points, so that they already have the mass, the centre of mass and the inertia of a
straight, evenly stretched rope, and therefore its swing; more lumps only improve the vibrations of the rope. Three or
more lumps are placed in the middles of equal parts: then each further lump brings the chain closer to the rope, and the
change shows the remaining error. At Gauss points this would not hold: the last lump would approach the hook as 1/n2 and
be overtaken by it in a recoil. The lumps keep the distances between the falls, so that the chain resists yawing as the
whole rope does (T b2 / 4 L).
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import msgspec
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.description.mechanics import (
    WORLD,
    Body,
    Joint,
    Line,
    Measured,
    Point,
    RigidRope,
    Rope,
    System,
    Vector,
)
from heavylift.nodes.plan.fidelity import Fidelity
from heavylift.nodes.plan.mechanism import Heavy, Mechanism

X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)
GAUSS = 0.28867513459481287  # 1/sqrt(12): the radius of gyration of a straight rope, as part of its length


def lumped(n: int) -> list[tuple[float, float]]:
    """Return the positions (0 to 1 along the rope) and the mass fractions of n lumped masses of a rope."""
    if n == 2:
        return [(0.5 - GAUSS, 0.5), (0.5 + GAUSS, 0.5)]
    return [((i + 0.5) / n, 1.0 / n) for i in range(n)]


def pieces(rope: str, lumps: int) -> dict[str, float]:
    """Return the names of the pieces of a hook rope, from the top, with their shares of its length.

    The first and last pieces have the tensions of the rope's ends; the last piece, at the hook, has the name of the
    rope."""
    places = [0.0, *(x for x, _ in lumped(lumps)), 1.0]
    names = [*(f"{rope}~{i}" for i in range(1, lumps + 1)), rope]
    return {name: b - a for name, (a, b) in zip(names, pairwise(places), strict=True)}


def chain(row: Heavy, rope: Rope, gravity: float, lumps: int, motion: str) -> System:
    """Return a rope as a chain of elastic pieces and lumped masses, in equilibrium under its load at the start.

    The part of the rope that does not hang, such as the part to the drum, belongs to the first piece and has no mass.
    The damping of each piece is scaled so that the whole chain is damped like the rope.
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
    """Return the bodies and joints of one lump, shared by all falls; it moves freely in the plane or space of `motion`,
    and can yaw in space."""

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


def heavy(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return the machine with its hook ropes rigid, with mass, or both, as the model level requires."""
    if fidelity.ropes == "elastic" and fidelity.rope_mass == "none":
        return machine
    system, parts = machine.system, dict[str, dict[str, float]]()
    for row in (row for row in machine.heavy if not row.why):
        rope = next((r for r in system.ropes if r.name == row.rope), None)
        if rope is None:
            continue
        made = _made(row, rope, system.gravity, fidelity)
        system = replace(
            system,
            bodies=system.bodies + made.bodies,
            joints=system.joints + made.joints,
            ropes=tuple(r for r in system.ropes if r is not rope) + made.ropes,
            rigid_ropes=system.rigid_ropes + made.rigid_ropes,
        )
        if made.bodies:
            parts[rope.name] = pieces(rope.name, len(made.ropes) - 1)
            measured = tuple(_followed(x, rope.name, tuple(parts[rope.name])) for x in system.measured)
            system = replace(system, measured=measured)
    heavy = tuple(row for row in machine.heavy if row.why)  # the others have what there is to be had
    return msgspec.structs.replace(machine, system=system, heavy=heavy, pieces=machine.pieces | parts)


def _followed(measured: Measured, rope: str, parts: tuple[str, ...]) -> Measured:
    """Return a measured scalar in which the pieces of a rope replace the rope as followers."""
    others = tuple(x for x in measured.followers if x != rope)
    return measured if len(others) == len(measured.followers) else replace(measured, followers=others + parts)


def _made(row: Heavy, rope: Rope, gravity: float, fidelity: Fidelity) -> System:
    lumped, leads = fidelity.rope_mass == "lumped", len(rope.lines) > len(row.beside)
    mass = row.line * rope.L0 if lumped and not leads else 0.0
    length = norm([p - q for p, q in zip(*row.ends, strict=True)]) + row.lead  # under what hangs on it at the start [m]
    if fidelity.ropes == "rigid":
        return System(rigid_ropes=(RigidRope(rope.name, rope.lines, length, rope.winch, rope.hooked, mass),))
    if fidelity.ropes == "massive":
        return chain(row, rope, gravity, fidelity.lumps, fidelity.motion)
    if lumped and leads:
        return chain(row, rope, gravity, 1, fidelity.motion)
    L0 = length / (1.0 + (row.below + mass / 2.0) * gravity / rope.EA) if mass else rope.L0
    return System(ropes=(replace(rope, L0=L0, mass=mass),))


def rigid_slings(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return the machine with inextensible slings, except slings that run over edges."""
    ties = {tie.rope: tie.spans for tie in machine.ties}
    if fidelity.slings == "elastic" or not ties:
        return machine
    system = machine.system
    rigid = (RigidRope(r.name, r.lines, ties[r.name] or r.L0, hooked=r.hooked) for r in system.ropes if r.name in ties)
    ropes = tuple(r for r in system.ropes if r.name not in ties)
    return msgspec.structs.replace(
        machine, system=replace(system, ropes=ropes, rigid_ropes=(*system.rigid_ropes, *rigid))
    )
