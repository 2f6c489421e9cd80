"""The shapes of a lift: what collides and what is drawn, from the numbers of the plan alone; data without a library.

A `Solid` is a box or a ball fixed on a body; a `Strand` is a straight piece of rope, thick as the steel of its
stiffness.  Solids and strands of one `thing` make up what a planner names: the block, a portal, a loader.
`relation` says how two things may meet: kept apart, allowed near but not through each other, or joined.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from heavylift.kernel.description.points import Matrix, Vector

    from .plan import Block, Crane, Loader, Mechanism, Plan

Kind = Literal["block", "portal", "trolley", "loader", "rope", "sling", "stools", "mechanism"]
Relation = Literal["apart", "through", "joined"]

WORLD, GROUND, STOOLS = "world", "ground", "stools"
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
LEG, GIRDER = 4.0, 8.0  # widths of a portal's legs and of its girder [m]
DECK = 2.0  # from the exits of the ropes to the girder, which lies between their two levels [m]
TROLLEY = 4.0  # height of a trolley [m]
STOOL = 1.0  # edge of a stool [m]
E_STEEL, FILL = 105e9, 0.586  # of a wire rope [Pa], and its metal over the circle around it: 44 mm 6x36, 890.6 mm2


@dataclass(frozen=True)
class Solid:
    """A box, edges `size` along the columns of R, or a ball of diameter size[0]; `centre` in its frame [m]."""

    thing: str
    part: str
    kind: Kind
    body: str
    centre: Vector
    size: Vector
    R: Matrix = IDENTITY
    form: Literal["box", "ball"] = "box"


@dataclass(frozen=True)
class Strand:
    """The lines of the rope `rope` are cylinders of this radius [m]; `ends`: things that it is fastened to."""

    thing: str
    kind: Kind
    rope: str
    radius: float
    ends: tuple[str, ...]


def solids(plan: Plan) -> tuple[Solid, ...]:
    """The shapes of all bodies that have one."""
    found: list[Solid] = []
    for crane in plan.cranes:
        found += [*_portal(crane, plan), *_trolleys(crane)]
    for loader in plan.loaders:
        found += _loader(loader, plan)
    for block in plan.all_blocks:
        found += [*_block(block), *_stools(block)]
    return (*found, *(shape for mechanism in plan.mechanisms for shape in _contacts(mechanism)))


def strands(plan: Plan) -> dict[str, Strand]:
    """Hook ropes and slings by the name of the rope."""
    found = {}
    for rope in plan.rig.hook_ropes:
        ends = (rope.carries, f"{rope.crane} {rope.hook}")
        radius = wire_radius(rope.EA / max(1, len(rope.lines)))
        found[rope.name] = Strand(f"rope {rope.name}", "rope", rope.name, radius, ends)
    for sling in (sling for sling in plan.rig.slings if not sling.over):
        found[sling.name] = Strand(sling.name, "sling", sling.name, wire_radius(sling.EA), (sling.loader,))
    return found


def wire_radius(EA: float) -> float:
    """Radius of the steel wire rope of a stiffness [N], or of the bundle of falls that has it together [m]."""
    return sqrt(EA / (pi * FILL * E_STEEL))


def _portal(crane: Crane, plan: Plan) -> Iterator[Solid]:
    """Girder between the two levels of rope exits (about its axis if nothing hangs from it), two pairs of legs on the
    rails under cross beams, each on a sill as long as the portal is wide over its buffers."""
    exits = [line.a.p[2] for r in plan.rig.hook_ropes if r.crane == crane.name for line in r.lines]
    axis = crane.girder.height
    low, high = (min(exits) + DECK, max(exits) - DECK) if exits else (axis - LEG, axis + LEG)
    span, half = 2.0 * crane.main.com[1], crane.width / 2 - LEG
    thing, body = f"portal of {crane.name}", f"{crane.name}.main"
    size = (GIRDER, span + LEG, max(high - low, LEG))
    yield Solid(thing, "girder", "portal", body, (0.0, span / 2, (low + high) / 2), size)
    for x in (-half, half):
        for y in (0.0, span):
            yield Solid(thing, "leg", "portal", body, (x, y, low / 2), (LEG, LEG, low))
    for y in (0.0, span):
        yield Solid(thing, "sill", "portal", body, (0.0, y, LEG / 4), (crane.width, LEG, LEG / 2))
        yield Solid(thing, "cross beam", "portal", body, (0.0, y, low + LEG / 2), (crane.width - LEG, LEG, LEG))


def _trolleys(crane: Crane) -> Iterator[Solid]:
    for trolley in (crane.upper, crane.lower):
        thing = f"{trolley.name} trolley of {crane.name}"
        size = edges(trolley.body.mass, trolley.body.moments)
        yield Solid(thing, "", "trolley", f"{crane.name}.{trolley.name}", trolley.body.com, (*size[:2], TROLLEY))


def _loader(loader: Loader, plan: Plan) -> Iterator[Solid]:
    """Hook block from the eye down to the hinge, as wide as its ropes are apart; beam between its slings."""
    x, y, z = loader.hinge
    apart = [abs(line.b.p[0]) for r in plan.rig.hook_ropes if r.carries == loader.name for line in r.lines]
    wide = 2.0 * max(apart, default=STOOL / 2) or STOOL
    size = (wide, min(wide, 2.0), max(-z, STOOL))
    yield Solid(loader.name, "hook block", "loader", f"{loader.name}.upper", (x / 2, y / 2, z / 2), size)
    beams = [s.beam.p for s in plan.rig.slings if s.loader == loader.name] or [(0.0, 0.0, -STOOL)]
    mid = [sum(p[i] for p in beams) / len(beams) for i in range(3)]
    length = max(p[0] for p in beams) - min(p[0] for p in beams) + STOOL
    size = (length, STOOL, max(-mid[2], STOOL))
    yield Solid(loader.name, "beam", "loader", f"{loader.name}.lower", (mid[0], mid[1], mid[2] / 2), size)


def _block(block: Block) -> Iterator[Solid]:
    """The slices or the box that the scene gives; of a plan without one, that of its mass and inertia."""
    size = (0.0, 0.0, 0.0), block.size
    own = size if any(block.size) else (block.body.com, edges(block.body.mass, block.body.moments))
    for centre, sides in block.slices or (own,):
        yield Solid(block.name, "", "block", block.name, centre, sides)


def _stools(block: Block) -> Iterator[Solid]:
    """The stools on which the block stands at the start."""
    x, y, *_ = block.pose
    for pad in block.pads:
        if pad.closed:
            u, v, _ = pad.support.point.p
            h = pad.support.height
            yield Solid(STOOLS, pad.support.name, "stools", WORLD, (x + u, y + v, h / 2), (STOOL, STOOL, h))


def _contacts(mechanism: Mechanism) -> Iterator[Solid]:
    """The boxes and balls with which bodies of a mechanism touch others."""
    from heavylift.kernel.description.contacts import Ball, Box

    shapes = dict.fromkeys(s for c in mechanism.system.contacts for s in (c.a, c.b))
    for shape in shapes:
        match shape:
            case Box():
                yield Solid(shape.body, "", "mechanism", shape.body, shape.p, shape.size, shape.R)
            case Ball() if shape.radius > 0.0:
                size = (2.0 * shape.radius,) * 3
                yield Solid(shape.body, "", "mechanism", shape.body, shape.p, size, form="ball")


def around(boxes: Sequence[tuple[Vector, Vector]]) -> tuple[Vector, Vector]:
    """Middle and edges of the box around boxes that lie alike [m]."""
    if len(boxes) == 1:
        return boxes[0]
    low = [min(c[i] - s[i] / 2 for c, s in boxes) for i in range(3)]
    high = [max(c[i] + s[i] / 2 for c, s in boxes) for i in range(3)]
    x, y, z = ((p + q) / 2 for p, q in zip(low, high, strict=True))
    a, b, c = (q - p for p, q in zip(low, high, strict=True))
    return (x, y, z), (a, b, c)


def edges(mass: float, moments: Vector) -> Vector:
    """Edges of the uniform box of a mass [kg] and moments of inertia about its middle [kg m2]."""
    total = sum(moments)
    x, y, z = (round(sqrt(max(0.0, 6.0 * (total - 2.0 * m) / mass)), 9) for m in moments)
    return x, y, z


def relation(plan: Plan, a: Solid | Strand, b: Solid | Strand) -> Relation:
    """How two shapes of different things may meet."""
    if "mechanism" in (a.kind, b.kind):
        return _of_mechanism(plan, a, b)
    one, two = sorted((a, b), key=lambda s: s.kind)
    kinds = one.kind, two.kind
    owners = {*_owner(plan, one), *_owner(plan, two)}
    same_crane = len(owners) == 1 and "" not in owners
    match kinds:
        case ("block", "stools"):
            return "joined"
        case ("block", "sling") | ("sling", "sling" | "stools"):
            joined = isinstance(one, Strand) and isinstance(two, Strand) and one.ends == two.ends
            return "joined" if joined else "through"
        case ("portal", "trolley") | ("portal" | "rope", "rope" | "trolley") if same_crane and kinds != (
            "rope",
            "rope",
        ):
            return "joined"
        case ("loader", "sling" | "rope") | ("rope", "sling"):
            return "joined" if _carried(one) & _carried(two) else "apart"
    return "apart"


def _owner(plan: Plan, shape: Solid | Strand) -> set[str]:
    """The crane whose steel or rope a shape is, or ""."""
    if isinstance(shape, Strand):
        return {next((r.crane for r in plan.rig.hook_ropes if r.name == shape.rope), "")}
    return {next((c.name for c in plan.cranes if shape.body.startswith(f"{c.name}.")), "")}


def _carried(shape: Solid | Strand) -> set[str]:
    """The loader that a shape is, or hangs on or from."""
    return {shape.ends[0]} if isinstance(shape, Strand) else {shape.thing}


def _of_mechanism(plan: Plan, a: Solid | Strand, b: Solid | Strand) -> Relation:
    """Bodies of one mechanism that neither a joint nor a contact of their shapes ties must not go through each other,
    nor what touches another thing by its corners alone."""
    if not (isinstance(a, Solid) and isinstance(b, Solid)):
        return "joined"
    joints = [{j.parent, j.child} for m in plan.mechanisms for j in m.system.joints]
    if {a.body, b.body} in joints:
        return "joined"
    if by_corners(plan, a.body, b.body):
        return "through"
    tied = [{c.a.body, c.b.body} for m in plan.mechanisms for c in m.system.contacts]
    return "joined" if a.kind != b.kind or {a.body, b.body} in tied else "through"


def by_corners(plan: Plan, a: str, b: str) -> bool:
    """Whether two bodies touch by contacts of points alone, so that one may go through the other beside those."""
    found = [c for m in plan.mechanisms for c in m.system.contacts if {c.a.body, c.b.body} == {a, b}]
    return bool(found) and all(getattr(c.a, "radius", 1.0) == 0.0 for c in found)


def untouched(plan: Plan) -> tuple[str, ...]:
    """What `relation` does not check, for planners."""
    found = []
    if plan.cranes:
        found.append("ropes beside the girder and the trolleys of their own crane, whose openings no scene gives")
        found.append(f"what shakes faster than samples of places and speeds show, {plan.samples_hz:g} in a second")
    if plan.block:
        found.append("the block beside its stools, and near the ground while it is lifted off or set down")
    if plan.rig.slings:
        found.append("slings while they are slack")
    if any(sling.over for sling in plan.rig.slings):
        found.append("slings that bend over edges")
    shaped = {s.body for s in solids(plan)}
    for mechanism in plan.mechanisms:
        bare = [b.name for b in mechanism.system.bodies if b.name not in shaped]
        if bare:
            more = f" and {len(bare) - 3} more" if len(bare) > 3 else ""
            found.append(f"whether {', '.join(bare[:3])}{more} of {mechanism.name} meet anything: they have no shapes")
        if mechanism.system.all_ropes:
            found.append(f"whether ropes of {mechanism.name} meet anything")
        if mechanism.system.reevings:
            found.append("what ropes over sheaves carry between samples")
        if plan.cranes:
            found.append(f"whether {mechanism.name} meets cranes, block or loaders")
    return tuple(found)
