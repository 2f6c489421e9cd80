"""What scenes must have in common to share machine code: everything that the traced text branches or indexes on.

All else (masses, places, stiffnesses, names of laws) is a number in P and may differ.  What is left out here and yet
traced would run as another scene's code, so a new feature adds its line.
"""

from __future__ import annotations

from typing import Any

from .rate import Program
from .trees import kind_of

__all__ = ["structure"]


def structure(program: Program, *method: Any) -> str:
    """Equal for scenes that share machine code; `method`: what the code depends on besides the scene."""
    p, s = program, program.system
    number = p.graph.number
    return repr(
        [
            method,
            p.formulation,
            [(kind_of(t), x.ends, x.held) for t, x in p.instances],
            [(j.kind, number(j.parent), number(j.child)) for j in p.graph.loops],
            p.contacts.structure,
            [(d.kind, d.joint, d.coordinate) for d in s.drives],
            [x.joint for x in s.locks],
            [[(x.joint, x.coordinate) for x in group] for group in (s.springs, s.stops, s.brakes)],
            len(s.masters),
            [(r.winch, [(number(k.a.body), number(k.b.body)) for k in r.lines]) for r in s.rigid_ropes],
            [(r.winch, [(number(k.a.body), number(k.b.body)) for k in r.lines]) for r in s.ropes],
            [number(u.point.body) for u in s.supports],
            [x.structure for x in p.forces],
            [(m.kind, m.of, m.axis, m.coordinate) for m in s.measured],
            [(h.quantity, h.of, h.coordinate, h.ropes, h.axis, h.point and h.point.body) for h in s.thresholds],
            [(k.body.name, k.joint.name, k.q.start, k.v.start) for k in p.graph.links],
            [r.name for r in s.ropes],
            sorted(p.calm),
        ]
    )
