"""Key of scenes that share machine code: everything on which the traced code branches or indexes.

All else (masses, places, stiffnesses) is a number in P and may differ; names are replaced by their places in lists, so
that equal machines share code whatever they are called. A traced property missing here would run another scene's code,
so each new feature adds its line.
"""

from heavylift.kernel.description.mechanics import Measured, Threshold

from .program import Program
from .quantities import lines, numbers, points


def structure(program: Program, *method: object) -> str:
    """Return a key that is equal for scenes which share machine code; `method`: further properties of the code."""
    p, s = program, program.system
    number, along = p.graph.number, p.graph.coordinate
    ropes, forces = [r.name for r in s.all_ropes], [f.name for f in s.forces]
    drives = [d.name for d in s.drives]

    def of(x: Measured | Threshold) -> object:
        """Return the body number or the coordinate indices from which a measured signal or threshold is computed."""
        if x.of and (kind := x.kind if isinstance(x, Measured) else x.quantity) in ("angle", "joint", "speed"):
            return number(x.of) if kind == "angle" else along(x.name, x.of, x.coordinate)
        return None

    def of_signal(h: Threshold) -> object:
        """Return the properties of a threshold on which its traced code depends: quantity, inputs, number of values."""
        wind = forces.index(h.of) if h.quantity == "wind" else None
        bodies = [number(point.body) for point in points(h, s)]
        over = [ropes.index(r) for r in h.ropes], bodies, len(numbers(h, s)), lines(h, s), wind
        return h.quantity, of(h), h.axis, over

    return repr(
        [
            method,
            p.formulation,
            [(t.kind, x.ends, x.held) for t, x in p.instances],
            [(j.kind, number(j.parent), number(j.child)) for j in p.graph.loops],
            p.contacts.structure,
            [(d.kind, p.driven(d), d.wave is not None, d.waves is not None) for d in s.drives],
            [p.graph.joint(x.joint).v.start for x in s.locks],
            len(s.masters),
            [(r.winch, r.mass > 0.0, [number(p.body) for p in r.points]) for r in s.rigid_ropes],
            [x.structure for x in p.laws],
            [(ropes.index(x.rope.name), x.line, x.end, number(x.body), [*map(drives.index, x.drives)]) for x in p.led],
            [(m.kind, of(m), m.axis) for m in s.measured],
            [of_signal(h) for h in s.thresholds],
            [(k.q.start, k.v.start) for k in p.graph.links],
            [k.modes.smallness.groups for k in p.graph.links if k.modes and k.n_modes],
        ]
    )
