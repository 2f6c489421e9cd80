"""What viewers draw of a plan: portals on their rails, trolleys, loaders, the block, any mechanism; lines of ropes."""

from __future__ import annotations

from math import hypot

from heavylift.kernel.description.forces import Spring
from heavylift.kernel.description.mechanics import Line, Point, System
from heavylift.nodes.devs import Event
from heavylift.nodes.models.parts import messages as m
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.shapes import Kind, Solid, solids
from heavylift.recordings import Box, RopeLine

from .shapes import GREY, shapes_of

__all__ = ["RopeLines", "boxes", "surroundings"]

DECK = 1.2  # height of a deck in the picture [m]
OVERHANG, RAIL = 17.0, 1.0  # of rails beyond the middle of a portal at their ends, edge of a rail [m]
DARK = (0.25, 0.09, 0.07, 1.0)
COLOURS: dict[Kind, tuple[float, float, float, float]] = {
    "portal": (0.93, 0.68, 0.13, 1.0),
    "trolley": (0.25, 0.45, 0.65, 1.0),
    "loader": (0.13, 0.48, 0.46, 1.0),
    "block": (0.72, 0.27, 0.20, 1.0),
}


def boxes(plan: Plan) -> list[Box]:
    """All that is drawn of a plan; machines and the block are as they collide."""
    out = _rails(plan)
    for solid in solids(plan):
        if solid.kind in COLOURS:
            out.append(Box(solid.body, solid.centre, solid.size, COLOURS[solid.kind]))
        if solid.kind == "block":
            out.append(_deck(solid))
    return [*out, *(box for mechanism in plan.mechanisms for box in shapes_of(mechanism.system, mechanism.shapes))]


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
    low = min(c.gantry.lower for c in plan.cranes) - OVERHANG
    high = max(c.gantry.upper for c in plan.cranes) + OVERHANG
    spans = sorted({2.0 * c.main.com[1] for c in plan.cranes} | {0.0})
    return [Box("world", ((low + high) / 2, y, RAIL / 4), (high - low, RAIL, RAIL / 2), GREY) for y in spans]


def _deck(block: Solid) -> Box:
    """A dark deck that shows which face of the block was up."""
    (x, y, z), (a, b, c) = block.centre, block.size
    return Box(block.body, (x, y, z + c / 2 - 0.48 * DECK), (1.002 * a, 1.002 * b, DECK), DARK)


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
