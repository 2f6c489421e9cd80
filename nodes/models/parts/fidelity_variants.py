"""What a machine declares of a joint or a rope under the fidelity of its plan: all of it, less, or nothing.

A locked joint is fixed where it starts; a body in planar motion has three degrees of freedom; a rigid rope is as long
as it hangs at the start; one with mass is a chain of lumps (`chains`), or its ends bear the mass.
"""

from __future__ import annotations

from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description.forces import Reeving, Signal
from heavylift.kernel.description.mechanics import Joint, Line, Point, RigidRope, Rope, System, Vector
from heavylift.kernel.errors import ModelError
from heavylift.nodes.plan.plan import Fidelity, HookRope, Plan, Sling

from .chains import chain, hangs

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
            return System(rigid_ropes=(RigidRope(rope.name, rope.lines, hangs(plan, rope), winch=True, mass=mass),))
        case "massive":
            return chain(plan, rope)
    L0 = _unstretched(plan, rope, mass / 2.0) if mass else rope.L0
    return System(ropes=(Rope(rope.name, rope.lines, rope.EA, L0, rope.damping, winch=True, mass=mass),))


def sling(plan: Plan, given: Sling, lug: Point) -> System:
    """A sling as it is declared."""
    lines, hooked = (Line(given.beam, lug),), bool(given.lug)
    if given.over:
        length = Signal(given.L0)
        return System(
            forces=(Reeving(given.name, given.beam, given.over, lug, given.EA, length, given.damping, hooked),)
        )
    if plan.fidelity.slings == "rigid":
        return System(rigid_ropes=(RigidRope(given.name, lines, given.L0, hooked=hooked),))
    return System(ropes=(Rope(given.name, lines, given.EA, given.L0, given.damping, hooked=hooked),))


def _unstretched(plan: Plan, rope: HookRope, more: float) -> float:
    """Length of a hook rope that hangs at rest at the start if so much hangs on it besides its loader [m]."""
    loader = next(x for x in plan.loaders if x.name == rope.carries)
    below = loader.upper.mass + loader.lower.mass + more
    return hangs(plan, rope) / (1.0 + below * plan.gravity / rope.EA)
