"""What viewers draw of a plan: portals on their rails, trolleys, loaders, the block, any mechanism; lines of ropes."""

from __future__ import annotations

from math import hypot

from heavylift.kernel.describe import Body, Line, Point, System
from heavylift.kernel.forces.describe import Spring
from heavylift.nodes.devs import Event
from heavylift.nodes.models import messages as m
from heavylift.nodes.scene.plan import Block, Crane, Loader, Plan
from heavylift.recordings import Box, RopeLine

from .shapes import GREY, equivalent_box, shapes_of

__all__ = ["RopeLines", "boxes", "surroundings"]

LEG, GIRDER, DECK = 4.0, 8.0, 1.2  # widths of a portal's legs and girder, height of a deck in the picture [m]
HALF_BASE, RAIL = 13.0, 1.0  # half the base of a portal along its rails, edge of a rail [m]
BEAM = 1.2  # edge of a loader's beam [m]
YELLOW, TROLLEY, LOADER = (0.93, 0.68, 0.13, 1.0), (0.25, 0.45, 0.65, 1.0), (0.13, 0.48, 0.46, 1.0)
RED, DARK = (0.72, 0.27, 0.20, 1.0), (0.25, 0.09, 0.07, 1.0)


def boxes(plan: Plan, systems: list[System]) -> list[Box]:
    """All that is drawn of a plan and its mechanics."""
    bodies = {b.name: b for s in systems for b in s.bodies}
    out = _rails(plan)
    for crane in plan.cranes:
        out += _portal(crane, plan)
        for trolley in (f"{crane.name}.upper", f"{crane.name}.lower"):
            body = bodies[trolley]
            out.append(Box(trolley, body.com, equivalent_box(body)[0], TROLLEY))
    for loader in plan.loaders:
        out += _loader(loader, plan)
    if plan.block:
        out += _block(plan.block, bodies[plan.block.name])
    return [*out, *(box for mechanism in plan.mechanisms for box in shapes_of(mechanism.system))]


def surroundings(plan: Plan) -> tuple[tuple[float, float, float], float]:
    """Middle and radius [m] of what is to be seen of a plan at its start."""
    if plan.cranes:
        x = sum(c.gantry.start for c in plan.cranes) / len(plan.cranes)
        y = sum(c.main.com[1] for c in plan.cranes) / len(plan.cranes)
        return (x, y, 0.6 * y), 1.3 * y
    arms = [p for m in plan.mechanisms for p in (*(b.com for b in m.system.bodies), *(j.p_PJ for j in m.system.joints))]
    reach = sum(hypot(*p) for p in arms) / max(1, len(plan.mechanisms))
    return (0.0, 0.0, 0.0), max(reach, 1.0)


def _rails(plan: Plan) -> list[Box]:
    """Two rails along x, as far as a crane can go."""
    if not plan.cranes:
        return []
    low = min(c.gantry.lower for c in plan.cranes) - HALF_BASE - LEG
    high = max(c.gantry.upper for c in plan.cranes) + HALF_BASE + LEG
    spans = sorted({2.0 * c.main.com[1] for c in plan.cranes} | {0.0})
    return [Box("world", ((low + high) / 2, y, RAIL / 4), (high - low, RAIL, RAIL / 2), GREY) for y in spans]


def _portal(crane: Crane, plan: Plan) -> list[Box]:
    """Girder between the two levels of rope exits (about its axis if nothing hangs from it), two pairs of legs on the
    rails, each under a sill."""
    exits = [line.a.p[2] for r in plan.rig.hook_ropes if r.crane == crane.name for line in r.lines]
    low, high = (
        (min(exits) + 2.0, max(exits) - 2.0) if exits else (crane.girder.height - LEG, crane.girder.height + LEG)
    )
    span = 2.0 * crane.main.com[1]
    body, half = f"{crane.name}.main", HALF_BASE
    girder = Box(body, (0.0, span / 2, (low + high) / 2), (GIRDER, span + LEG, max(high - low, LEG)), YELLOW)
    legs = [Box(body, (x, y, low / 2), (LEG, LEG, low), YELLOW) for x in (-half, half) for y in (0.0, span)]
    sills = [Box(body, (0.0, y, low + LEG / 2), (2 * half + LEG, LEG, LEG), YELLOW) for y in (0.0, span)]
    return [girder, *legs, *sills]


def _loader(loader: Loader, plan: Plan) -> list[Box]:
    """Hook block from the eye down to the hinge, beam between its slings."""
    x, y, z = loader.hinge
    beams = [s.beam.p for s in plan.rig.slings if s.loader == loader.name]
    middle = [sum(p[i] for p in beams) / len(beams) for i in range(3)] if beams else [0.0, 0.0, -BEAM]
    length = max((p[0] for p in beams), default=1.0) - min((p[0] for p in beams), default=-1.0) + BEAM
    beam = Box(
        f"{loader.name}.lower", (middle[0], middle[1], middle[2] / 2), (length, BEAM, max(-middle[2], BEAM)), LOADER
    )
    return [Box(f"{loader.name}.upper", (x / 2, y / 2, z / 2), (BEAM, BEAM, max(-z, BEAM)), LOADER), beam]


def _block(block: Block, body: Body) -> list[Box]:
    """The block, with a dark deck that shows which face was up."""
    (x, y, z), size = body.com, equivalent_box(body)[0]
    deck = Box(block.name, (x, y, z + size[2] / 2 - 0.48 * DECK), (1.002 * size[0], 1.002 * size[1], DECK), DARK)
    return [Box(block.name, body.com, size, RED), deck]


class RopeLines:
    """The ropes that hang in the scene now."""

    def __init__(self, systems: list[System]) -> None:
        ropes = [r for s in systems for r in s.all_ropes]
        self._lines = {r.name: r.lines for r in ropes}
        self._hooked = {r.name: r.hooked for r in ropes}
        springs = [f for s in systems for f in s.forces if isinstance(f, Spring)]
        self._lines |= {f.name: (Line(f.a, f.b),) for f in springs}
        self._hooked |= {f.name: True for f in springs}

    def change(self, event: Event) -> bool:
        """Whether an event hooked or unhooked something."""
        if event.type not in ("Hook", "Unhook"):
            return False
        value = event.value
        if isinstance(value, m.Unhook):
            self._hooked[value.rope] = False
        elif isinstance(value, m.Hook):
            line = self._lines[value.rope][0]
            a, b = Point(line.a.body, value.a or line.a.p), Point(line.b.body, value.b or line.b.p)
            self._lines[value.rope] = (Line(a, b),)
            self._hooked[value.rope] = True
        return True

    def drawn(self) -> list[RopeLine]:
        """The lines of all hooked ropes."""
        lines = [(name, x) for name, lines in self._lines.items() if self._hooked[name] for x in lines]
        return [RopeLine(name, x.a.body, x.a.p, x.b.body, x.b.p) for name, x in lines]
