"""Machine bodies that bend as beams, such as booms.

They start deflected by their own weight and their load, and are cambered: at the start everything they carry is where
it would be on a rigid body, so that nothing swings before something moves; ropes are longer by the shortening of the
bent beam.

A girder is a beam between its legs, of which only the first vertical mode is modelled.

A uniform beam of span L and stiffness k at midspan has EI = k L^3 / 48; its first mode is sin(pi y / L). The girder,
too, starts deflected and is cambered: at the start, trolleys on it are level and where they would be on a rigid girder,
although a bent girder is shorter, by half the integral of its slope squared.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import pi
from typing import Any

import msgspec
from heavylift.kernel.algebra.dense import cross, dot, norm, product
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import Body, Joint, Matrix, Point, System, Vector
from heavylift.nodes.plan.fidelity import Fidelity, times
from heavylift.nodes.plan.mechanism import BeamLoad, Bend, Mechanism

SETTLES = 40  # steps in which what compression adds to a deflection dies away, as far from buckling as booms are
Modes = Any  # of the kernel, which needs NumPy, as a process that only declares does not


def beams(machine: Mechanism, fidelity: Fidelity) -> Mechanism:
    """Return the machine with its bending bodies modelled as flexible beams."""
    if fidelity.girder == "rigid" or not machine.bends:
        return machine
    heavy = fidelity.ropes == "massive" or fidelity.rope_mass == "lumped"
    system, booms = _spanned(machine, heavy=heavy), [row for row in machine.bends if not row.stiffness]
    if not booms:
        return msgspec.structs.replace(machine, system=system, bends=())
    from heavylift.kernel.multibody.flexible.modes import modes_of

    lengths = {rope.name: rope.L0 for rope in system.all_ropes}
    more = {x.rope: x.line * (lengths[x.rope] - x.lead) / x.below for x in machine.heavy if heavy and not x.why}
    longer = dict[str, float]()
    for row in booms:
        modes = modes_of(row.body, row.flexible)
        start = _rest(row, modes, [_scaled(load, 1.0 + more.get(load.rope, 0.0)) for load in row.loads])
        bodies = tuple(_bending(body, row, start) if body.name == row.body else body for body in system.bodies)
        moved = _moved(system, row.body, partial(_cambered, modes, start))
        for load in row.loads:
            distance, size = _cambered(modes, start, load.p)[2], norm(load.force)
            longer[load.rope] = longer.get(load.rope, 0.0) - load.share * dot(distance, load.force) / (size or 1.0)
        system = replace(moved, bodies=bodies)
    ropes = tuple(replace(x, L0=x.L0 + longer[x.name]) if x.name in longer else x for x in system.ropes)
    hang = tuple(msgspec.structs.replace(x, lead=x.lead + longer.get(x.rope, 0.0)) for x in machine.heavy)
    return msgspec.structs.replace(machine, system=replace(system, ropes=ropes), heavy=hang, bends=())


def _scaled(load: BeamLoad, by: float) -> BeamLoad:
    x, y, z = (by * f for f in load.force)
    return msgspec.structs.replace(load, force=(x, y, z))


def _bending(body: Body, row: Bend, start: tuple[float, ...]) -> Body:
    """Return a body of which a part of the mass is modelled as a flexible beam along its x axis; `start`: modal
    coordinates at the start."""
    beam, left = row.flexible.beam, body.mass - row.mass
    assert beam is not None
    middle = (beam.start + beam.length / 2.0, 0.0, 0.0)
    com = body.com
    if left > 0.0:
        x, y, z = ((body.mass * c - row.mass * m) / left for c, m in zip(body.com, middle, strict=True))
        com = (x, y, z)
    part = left / body.mass
    a, b, c = ((part * x, part * y, part * z) for x, y, z in body.inertia)
    return replace(body, mass=left, com=com, inertia=(a, b, c), flexible=replace(row.flexible, start=start))


def _rest(row: Bend, modes: Modes, loads: list[BeamLoad]) -> tuple[float, ...]:
    """Return the modal coordinates at which a beam is at rest under its loads and weight, with the effect of axial
    forces."""
    n, beam = len(modes.mass), row.flexible.beam
    assert beam is not None
    pieces = beam.elements
    weight = row.mass / pieces
    x, y, z = (weight * g for g in row.gravity)
    places = [beam.start + beam.length * (i + 0.5) / pieces for i in range(pieces)]
    whole = [*loads, *(BeamLoad(x=at, p=(at, 0.0, 0.0), force=(x, y, z)) for at in places)]
    pull, soft = [0.0] * n, [[0.0] * n for _ in range(n)]
    for load in whole:
        shapes, g = modes.at(load.x).T.tolist(), modes.shortening(load.x).tolist()
        wrench = (*load.force, *cross([load.p[0] - load.x, *load.p[1:]], load.force))
        pull = [q + dot(shape, wrench) for q, shape in zip(pull, shapes, strict=True)]
        soft = [[s + load.force[0] * x for s, x in zip(*rows, strict=True)] for rows in zip(soft, g, strict=True)]
    bent = [0.0] * n
    for _ in range(SETTLES):
        bent = [(q - s) / k for q, s, k in zip(pull, product(soft, bent), modes.stiffness.tolist(), strict=True)]
    return tuple(bent)


def _cambered(modes: Modes, start: tuple[float, ...], p: Vector) -> tuple[Vector, Matrix, Vector]:
    """Return, for a point given on the bent beam, its position on the straight beam, the rotation (3, 3) there, and the
    offset left by the shortening."""
    station, X = modes.station(p)
    moved = product(modes.at(station).tolist(), start)
    turned = moved[3:]
    part = 1.0 / (1.0 + dot(turned, turned) / 4.0)
    columns = [cross(turned, [float(i == j) for i in range(3)]) for j in range(3)]
    skew = [list(row) for row in zip(*columns, strict=True)]
    square = [[dot(row, column) for column in columns] for row in skew]
    a, b, c = ([float(i == j) + part * (square[j][i] / 2.0 + skew[j][i]) for j in range(3)] for i in range(3))
    back: Matrix = ((a[0], a[1], a[2]), (b[0], b[1], b[2]), (c[0], c[1], c[2]))  # transposed
    arm = [q - x - d for q, x, d in zip(p, X.tolist(), moved, strict=False)]
    along, y, z = product(back, arm)
    shorter = dot(start, product(modes.shortening(station).tolist(), start)) / 2.0
    u, v, w = (-along * row[0] for row in zip(*back, strict=True))  # what no arm can lie along the beam
    return (p[0], X.tolist()[1] + y, X.tolist()[2] + z), back, (u - shorter, v, w)


def _moved(x: Any, body: str, at: Callable[[Vector], tuple[Vector, Matrix, Vector]]) -> Any:
    """Return a description in which the function `at` has moved all points and joints on a body."""
    if isinstance(x, Point):
        return replace(x, p=at(x.p)[0]) if x.body == body else x
    if isinstance(x, Joint):
        if x.parent != body or x.kind == "slider":
            return x
        p, back, _ = at(x.p_PJ)
        return replace(x, p_PJ=p, R_PJ=times(back, x.R_PJ))
    if isinstance(x, tuple):
        return tuple(_moved(each, body, at) for each in x)
    from heavylift.kernel.description.field_types import field_names

    names = () if isinstance(x, Body) else field_names(x.__class__)
    return type(x)(**{name: _moved(getattr(x, name), body, at) for name in names}) if names else x


ALONG_Y: Matrix = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))  # the beam's x is the y of what holds it
X: Vector = (1.0, 0.0, 0.0)


def _spanned(machine: Mechanism, *, heavy: bool) -> System:
    """Return the mechanical system of a machine with its girders as beams between their legs."""
    system = machine.system
    bodies, joints = {b.name: b for b in system.bodies}, {j.name: j for j in system.joints}
    for girder in machine.girders:
        name, down = beam_of(girder), sag(machine, girder, heavy=heavy)
        bodies[girder.body] = _stiff_part(bodies[girder.body], girder)
        bodies[name] = Body(name, 0.0, flexible=replace(girder.flexible, start=(-down,)))
        feet = f"{name}-feet"
        joints[feet] = Joint(feet, "fixed", girder.body, name, (0.0, 0.0, girder.height), ALONG_Y)
        joints |= {slide: _on_girder(girder, joints[slide], down) for slide in girder.slides}
    return replace(system, bodies=tuple(bodies.values()), joints=tuple(joints.values()))


def beam_of(girder: Bend) -> str:
    """Return the name of the flexible body that represents a girder."""
    return f"{girder.body.rpartition('.')[0]}.girder"


def _stiff_part(body: Body, girder: Bend) -> Body:
    """Return the part of a girder's body that stays rigid."""
    left = (body.mass - girder.mass) / body.mass
    x, y, z = ((a * left, b * left, c * left) for a, b, c in body.inertia)
    return replace(body, mass=body.mass * left, inertia=(x, y, z))


def _on_girder(girder: Bend, joint: Joint, down: float) -> Joint:
    """Return the joint of a trolley on the flexible girder: a slider, or a fixed joint if the trolley is fixed; `down`:
    static deflection at midspan [m]."""
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


def sag(machine: Mechanism, girder: Bend, *, heavy: bool) -> float:
    """Return the static deflection at midspan [m] of a girder under the loads P at the positions y.

    This is F / (pi^4 EI / 2 L^3) with F = sum of P sin(pi y / L) + 2 m g / pi; `heavy`: whether hook ropes have
    mass."""
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
