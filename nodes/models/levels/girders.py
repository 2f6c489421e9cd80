"""A girder as a beam between its feet, of which the first vertical mode is modelled.

A uniform beam of stiffness k at midspan has EI = k L^3 / 48; its first mode is sin(pi y / L). It starts deflected by
its own weight and its load, so that nothing swings before something moves, and is cambered: at the start, trolleys on
it are level and where they would be on a rigid girder, although a bent girder is shorter, by half its slopes squared.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi

import msgspec
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.flexible import Beam, Flexible
from heavylift.kernel.description.mechanics import Body, Joint, Matrix, Vector
from heavylift.nodes.plan.fidelity import Fidelity
from heavylift.nodes.plan.mechanism import Girder, Mechanism

ALONG_Y: Matrix = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))  # the beam's x is the y of what holds it
X: Vector = (1.0, 0.0, 0.0)


def bending(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return the machine with its girders as beams."""
    if fidelity.girder == "rigid":
        return machine
    system, heavy = machine.system, fidelity.ropes == "massive" or fidelity.rope_mass == "lumped"
    bodies, joints = {b.name: b for b in system.bodies}, {j.name: j for j in system.joints}
    for girder in machine.girders:
        name, down = beam_of(girder), sag(machine, girder, heavy=heavy)
        bodies[girder.body] = _stiff_part(bodies[girder.body], girder)
        bodies[name] = Body(name, 0.0, flexible=_flexible(girder, down))
        feet = f"{name}-feet"
        joints[feet] = Joint(feet, "fixed", girder.body, name, (0.0, 0.0, girder.height), ALONG_Y)
        joints |= {slide: _on_girder(girder, joints[slide], down) for slide in girder.slides}
    changed = replace(system, bodies=tuple(bodies.values()), joints=tuple(joints.values()))
    return msgspec.structs.replace(machine, system=changed, girders=())


def beam_of(girder: Girder) -> str:
    """Return the name of the body that bends."""
    return f"{girder.body.rpartition('.')[0]}.girder"


def _stiff_part(body: Body, girder: Girder) -> Body:
    """Return the part of a body that does not bend."""
    left = (body.mass - girder.mass) / body.mass
    x, y, z = ((a * left, b * left, c * left) for a, b, c in body.inertia)
    return replace(body, mass=body.mass * left, inertia=(x, y, z))


def _flexible(girder: Girder, down: float) -> Flexible:
    L = girder.span
    beam = Beam(L, girder.mass / L, EI_y=girder.stiffness * L * L * L / 48.0)
    return Flexible(1, beam, frame="simply supported", damping=girder.damping, start=(-down,))


def _on_girder(girder: Girder, joint: Joint, down: float) -> Joint:
    """Return the joint of a trolley that starts at y on the bending girder: a slider, or fixed there."""
    fixed = joint.kind == "fixed"
    y = joint.p_PJ[1] if fixed else joint.q0[0]
    phase = pi * y / girder.span
    slope = down * pi / girder.span * cos(phase)  # about the beam's y
    c, s = cos(slope), sin(slope)
    level: Matrix = ((0.0, -1.0, 0.0), (c, 0.0, s), (-s, 0.0, c))
    bent = down * pi / girder.span
    shorter = bent * bent * (y / 4.0 + girder.span * sin(2.0 * phase) / (8.0 * pi))
    name, at = beam_of(girder), (0.0, -shorter, girder.height - down * sin(phase))
    if fixed:
        return Joint(joint.name, "fixed", name, joint.child, (y, 0.0, 0.0), p_CJ=at, R_CJ=level)
    return Joint(joint.name, "slider", name, joint.child, axis=X, q0=joint.q0, v0=joint.v0, p_CJ=at, R_CJ=level)


def sag(machine: Mechanism, girder: Girder, *, heavy: bool) -> float:
    """Return the static deflection at midspan [m]: F / (pi^4 EI / 2 L^3) with F = sum of P sin(pi y / L) + 2 m g / pi;
    `heavy`: hook ropes have a mass."""
    g, system = machine.system.gravity, machine.system
    bodies, joints = {b.name: b for b in system.bodies}, {j.name: j for j in system.joints}
    lengths = {rope.name: rope.L0 for rope in system.all_ropes}
    force = 2.0 * girder.mass * g / pi
    for slide in (joints[name] for name in girder.slides):
        ropes = [row for row in machine.heavy if row.on == slide.child]
        hanging = sum(row.below for row in ropes)
        if heavy:
            hanging += sum(row.line * lengths[row.rope] for row in ropes)
        y = slide.p_PJ[1] if slide.kind == "fixed" else slide.q0[0]
        force += (bodies[slide.child].mass + hanging) * g * sin(pi * y / girder.span)
    return force / (pi * pi * pi * pi / 2.0 * girder.stiffness / 48.0)
