"""What a machine declares of a joint or a rope under the fidelity of its plan: all of it, less, or nothing.

A locked joint is fixed where it starts; a body in planar motion has three degrees of freedom; a rigid rope is as long
as it hangs at the start; one with mass is a chain of lumps that keep the distance of the falls, so that it resists
yawing as the whole rope does (T b2 / 4 L).
"""

from __future__ import annotations

from math import atan2, dist

from heavylift.kernel.describe import WORLD, Body, Joint, Line, Point, RigidRope, Rope, System, Vector
from heavylift.kernel.errors import ModelError
from heavylift.nodes.scene.plan import Fidelity, HookRope, Plan, Sling

__all__ = ["hook_rope", "modelled", "pieces", "sling"]

X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
Z: Vector = (0.0, 0.0, 1.0)
NORMAL = {"across": (X, Y), "along": ((0.0, -1.0, 0.0), X)}  # of the plane, and its first direction; the second is z
LEVEL = 1e-9  # of a quaternion's part that is out of the plane


def modelled(joint: Joint, fidelity: Fidelity) -> Joint:
    """The joint as it is declared."""
    if joint.name in fidelity.locked:
        slides = joint.kind == "prismatic"
        x, y, z = (p + slides * joint.q0[0] * a for p, a in zip(joint.p_PJ, joint.axis, strict=True))
        return Joint(joint.name, "fixed", joint.parent, joint.child, (x, y, z), joint.R_PJ)
    if joint.kind == "free" and fidelity.motion != "spatial":
        return _planar(joint, fidelity.motion)
    return joint


def _planar(joint: Joint, motion: str) -> Joint:
    """A free joint whose child stays in its plane."""
    normal, first = NORMAL[motion]
    x, y, z, *q = joint.q0
    turned = sum(a * b for a, b in zip(normal, q[:3], strict=True))
    if any(abs(c - turned * n) > LEVEL for c, n in zip(q[:3], normal, strict=True)):
        raise ModelError(
            f"{joint.child}: it starts turned out of the plane of its motion, '{motion}'; model it in space: "
            "fidelity: {motion: spatial}"
        )
    angle = 2.0 * atan2(turned, q[3])
    return Joint(
        joint.name, "planar", joint.parent, joint.child, (x, y, z), axis=normal, second=first, q0=(0.0, 0.0, angle),
        v0=(0.0,) * 3,
    )  # fmt: skip


def hook_rope(plan: Plan, rope: HookRope) -> System:
    """A hook rope as it is declared."""
    mass = rope.line * rope.L0 if plan.fidelity.rope_mass == "lumped" else 0.0
    match plan.fidelity.ropes:
        case "rigid":
            return System(rigid_ropes=(RigidRope(rope.name, rope.lines, _hangs(plan, rope), winch=True, mass=mass),))
        case "massive":
            return _chain(plan, rope)
    L0 = _unstretched(plan, rope, mass / 2.0) if mass else rope.L0
    return System(ropes=(Rope(rope.name, rope.lines, rope.EA, L0, rope.damping, winch=True, mass=mass),))


def sling(plan: Plan, given: Sling, lug: Point) -> System:
    """A sling as it is declared."""
    lines, hooked = (Line(given.beam, lug),), bool(given.lug)
    if plan.fidelity.slings == "rigid":
        return System(rigid_ropes=(RigidRope(given.name, lines, given.L0, hooked=hooked),))
    return System(ropes=(Rope(given.name, lines, given.EA, given.L0, given.damping, hooked=hooked),))


def pieces(fidelity: Fidelity, rope: str) -> dict[str, float]:
    """The ropes that a hook rope is made of, with their parts of its length, from the trolley down.

    Lumps sit in the middle of equal parts, so that the ends pull with the tensions of the rope's ends; the last piece,
    at the hook, bears its name.
    """
    if fidelity.ropes != "massive":
        return {rope: 1.0}
    n = fidelity.lumps
    return {f"{rope}~1": 0.5 / n, **{f"{rope}~{i}": 1.0 / n for i in range(2, n + 1)}, rope: 0.5 / n}


def _unstretched(plan: Plan, rope: HookRope, more: float) -> float:
    """Length of a hook rope that hangs at rest at the start if so much hangs on it besides its loader [m]."""
    loader = next(x for x in plan.loaders if x.name == rope.carries)
    below = loader.upper.mass + loader.lower.mass + more
    return _hangs(plan, rope) / (1.0 + below * plan.gravity / rope.EA)


def _chain(plan: Plan, rope: HookRope) -> System:
    """A hook rope as its pieces with lumps between them, at rest under what hangs on it at the start."""
    (x, y, top), (_, _, eye) = _ends(plan, rope)
    parts, mass = pieces(plan.fidelity, rope.name), rope.line * rope.L0 / plan.fidelity.lumps
    loader = next(x for x in plan.loaders if x.name == rope.carries)
    half = max(abs(line.b.p[0]) for line in rope.lines)
    bodies, joints, ropes = [], [], []
    above, z = [line.a for line in rope.lines], top
    for i, (name, part) in enumerate(parts.items(), 1):
        below = loader.upper.mass + loader.lower.mass + (len(parts) - i) * mass
        z -= part * (top - eye)
        last = i == len(parts)
        here = f"{rope.name}.lump-{i}"
        ends = [line.b if last else Point(here, (line.b.p[0], 0.0, 0.0)) for line in rope.lines]
        if not last:
            chain, moved = _lump(here, mass, half, (x, y, z), plan.fidelity.motion)
            bodies += chain
            joints += moved
        lines = tuple(Line(a, b, line.share) for a, b, line in zip(above, ends, rope.lines, strict=True))
        L0 = part * (top - eye) / (1.0 + below * plan.gravity / rope.EA)
        ropes.append(Rope(name, lines, rope.EA, L0, rope.damping / part, winch=True))
        above = ends
    return System(tuple(bodies), tuple(joints), ropes=tuple(ropes))


def _lump(name: str, mass: float, half: float, at: Vector, motion: str) -> tuple[list[Body], list[Joint]]:
    """Two points of half the mass at +-half along x; it moves as far as the motion goes, and yaws in space."""
    turns = mass * half**2
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


def _hangs(plan: Plan, rope: HookRope) -> float:
    """Length of a hook rope at the start, under what hangs on it then [m]."""
    return dist(*_ends(plan, rope))
