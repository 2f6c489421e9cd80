"""What viewers draw of a plan: boxes on bodies, and the lines of ropes as they are hooked and unhooked."""

from __future__ import annotations

from heavylift.kernel.describe import Line, Matrix, Point, System
from heavylift.nodes.devs import Event
from heavylift.nodes.models import messages as m
from heavylift.nodes.scene.plan import Crane, Plan
from heavylift.recordings import Box, RopeLine

__all__ = ["RopeLines", "boxes"]

LEG, GIRDER, DECK = 4.0, 8.0, 1.2  # widths of a portal's legs and girder, height of a deck in the picture [m]
YELLOW, BLUE = (0.93, 0.68, 0.13, 1.0), (0.25, 0.45, 0.65, 1.0)
RED, DARK = (0.72, 0.27, 0.20, 1.0), (0.25, 0.09, 0.07, 1.0)


def boxes(plan: Plan, systems: list[System]) -> list[Box]:
    """A portal per crane, and for every other body the homogeneous box of its mass and inertia."""
    portals = {f"{c.name}.main": c for c in plan.cranes}
    out: list[Box] = []
    for body in (b for s in systems for b in s.bodies if b.mass > 0.0):
        if body.name in portals:
            out += _portal(portals[body.name], plan)
        else:
            size = equivalent_box(body.mass, body.inertia)
            block = plan.block is not None and body.name == plan.block.name
            out.append(Box(body.name, body.com, size, RED if block else BLUE))
            if block:  # a dark deck shows which face was up
                x, y, z = body.com
                out.append(Box(body.name, (x, y, z + size[2] / 2), (size[0], size[1], DECK), DARK))
    return out


def _portal(crane: Crane, plan: Plan) -> list[Box]:
    """Girder between the two levels of rope exits, two pairs of legs on the rails, each under a sill."""
    exits = [line.a.p[2] for r in plan.rig.hook_ropes if r.crane == crane.name for line in r.lines]
    low, high = min(exits) + 2.0, max(exits) - 2.0
    span = 2.0 * crane.main.com[1]
    body, half = f"{crane.name}.main", 13.0
    girder = Box(body, (0.0, span / 2, (low + high) / 2), (GIRDER, span + LEG, max(high - low, LEG)), YELLOW)
    legs = [Box(body, (x, y, low / 2), (LEG, LEG, low), YELLOW) for x in (-half, half) for y in (0.0, span)]
    sills = [Box(body, (0.0, y, low + LEG / 2), (2 * half + LEG, LEG, LEG), YELLOW) for y in (0.0, span)]
    return [girder, *legs, *sills]


def equivalent_box(mass: float, inertia: Matrix) -> tuple[float, float, float]:
    """Edges of the homogeneous box of this mass and principal inertia; 1 m where a body has no extent."""
    I = [inertia[i][i] for i in range(3)]
    squares = [6.0 * (sum(I) - 2.0 * I[i]) / mass for i in range(3)]
    x, y, z = (s**0.5 if s > 1e-6 else 1.0 for s in squares)
    return x, y, z


class RopeLines:
    """The ropes that hang in the scene now."""

    def __init__(self, systems: list[System]) -> None:
        ropes = [r for s in systems for r in s.all_ropes]
        self._lines = {r.name: r.lines for r in ropes}
        self._hooked = {r.name: r.hooked for r in ropes}

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
