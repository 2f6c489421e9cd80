"""Rigid hook ropes and slings, and hook ropes with mass: at their ends, or as lumps.

A rigid hook rope has the length with which it hangs at the start; if its mass is lumped at its ends, the unstretched
length is chosen so that it hangs there at rest. If a part leads on to a drum, the falls have one lump in their middle
instead, and rigid ropes have no mass.
"""

from __future__ import annotations

from dataclasses import replace

import msgspec
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.description.mechanics import RigidRope, Rope, System
from heavylift.nodes.plan.fidelity import Fidelity
from heavylift.nodes.plan.mechanism import Heavy, Mechanism

from .lumps import chain, pieces


def heavy(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return the machine with its heavy ropes rigid, with mass, or both."""
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
    heavy = tuple(row for row in machine.heavy if row.why)  # the others have what there is to be had
    return msgspec.structs.replace(machine, system=system, heavy=heavy, pieces=machine.pieces | parts)


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
    """Return the machine with inextensible slings, except those over edges."""
    ties = {tie.rope: tie.spans for tie in machine.ties}
    if fidelity.slings == "elastic" or not ties:
        return machine
    system = machine.system
    rigid = (RigidRope(r.name, r.lines, ties[r.name] or r.L0, hooked=r.hooked) for r in system.ropes if r.name in ties)
    ropes = tuple(r for r in system.ropes if r.name not in ties)
    return msgspec.structs.replace(
        machine, system=replace(system, ropes=ropes, rigid_ropes=(*system.rigid_ropes, *rigid))
    )
