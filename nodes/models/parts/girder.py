"""The girder of a crane as a beam between its legs, whose first vertical mode is modelled.

A uniform beam of stiffness k at midspan has EI = k L^3 / 48; its first mode is sin(pi y / L).  It starts bent by its
own weight and by all that hangs on it, so that nothing swings before something moves, and is cambered: where they start
its trolleys are level and where they were on a rigid girder, though a bent one is shorter, by half its slopes squared.
"""

from __future__ import annotations

from math import pi

from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.flexible import Beam, Flexible
from heavylift.kernel.description.mechanics import Body, Joint, Matrix, Vector
from heavylift.nodes.plan.plan import Crane, Inertia, Plan

ALONG_Y: Matrix = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))  # the beam's x is the main body's y
X: Vector = (1.0, 0.0, 0.0)


def stiff_part(crane: Crane) -> Inertia:
    """What of the main body does not bend."""
    left = (crane.main.mass - crane.girder.mass) / crane.main.mass
    x, y, z = crane.main.moments
    return Inertia(mass=crane.main.mass * left, com=crane.main.com, moments=(x * left, y * left, z * left))


def girder(plan: Plan, crane: Crane) -> tuple[Joint, Body]:
    """How the main body holds the girder, and the girder."""
    given, name = crane.girder, f"{crane.name}.girder"
    at: Vector = (0.0, 0.0, given.height)
    beam = Beam(given.span, given.mass / given.span, EI_y=given.stiffness * given.span * given.span * given.span / 48.0)
    bent = Flexible(1, beam, frame="simply supported", damping=given.damping, start=(-sag(plan, crane),))
    return Joint(f"{name}-feet", "fixed", f"{crane.name}.main", name, at, ALONG_Y), Body(name, 0.0, flexible=bent)


def on_girder(plan: Plan, crane: Crane, joint: Joint, y: float) -> Joint:
    """The joint of a trolley that starts at y of the bending girder: a slider, or fixed there."""
    down, phase = sag(plan, crane), pi * y / crane.girder.span
    slope = down * pi / crane.girder.span * cos(phase)  # about the beam's y
    c, s = cos(slope), sin(slope)
    level: Matrix = ((0.0, -1.0, 0.0), (c, 0.0, s), (-s, 0.0, c))
    bent = down * pi / crane.girder.span
    shorter = bent * bent * (y / 4.0 + crane.girder.span * sin(2.0 * phase) / (8.0 * pi))
    name, at = f"{crane.name}.girder", (0.0, -shorter, crane.girder.height - down * sin(phase))
    if joint.kind == "fixed":
        return Joint(joint.name, "fixed", name, joint.child, (y, 0.0, 0.0), p_CJ=at, R_CJ=level)
    return Joint(joint.name, "slider", name, joint.child, axis=X, q0=joint.q0, v0=joint.v0, p_CJ=at, R_CJ=level)


def sag(plan: Plan, crane: Crane) -> float:
    """Static deflection of midspan [m]: F / (pi^4 EI / 2 L^3) with F = sum of P sin(pi y / L) + 2 m g / pi."""
    given, L = crane.girder, crane.girder.span
    force = 2.0 * given.mass * plan.gravity / pi
    for trolley in (crane.upper, crane.lower):
        hooks = [h.name for h in crane.hooks if h.trolley == trolley.name]
        loaders = [r.carries for r in plan.rig.hook_ropes if r.crane == crane.name and r.hook in hooks]
        hanging = sum(x.upper.mass + x.lower.mass for x in plan.loaders if x.name in loaders)
        if plan.fidelity.ropes == "massive" or plan.fidelity.rope_mass == "lumped":
            hanging += sum(r.line * r.L0 for r in plan.rig.hook_ropes if r.carries in loaders)
        force += (trolley.body.mass + hanging) * plan.gravity * sin(pi * trolley.axis.start / L)
    return force / (pi * pi * pi * pi / 2.0 * given.stiffness / 48.0)
