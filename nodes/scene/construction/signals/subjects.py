"""Subjects of signals by name (hooks, ropes, points, boxes and winds), and the signals of their quantities."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import cast

from heavylift.kernel.description.forces import Wind
from heavylift.kernel.description.mechanics import WORLD, Point, Quantity, Vector
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.nodes.limits.named import LOADS, signal_of
from heavylift.nodes.plan.limit import RatedLimit
from heavylift.nodes.plan.shapes import around
from heavylift.nodes.scene.construction.limiting import rated_limits
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.recordings.format.spellings import BEAM_LOAD

RATINGS = {
    "load": (*LOADS, BEAM_LOAD),
    "tension": ("sling tension", "rope tension"),
}  # rows of the table of limits that a share is of
WIDE = 1e4  # [m] half edges of the floor
EMPTY = 1.1  # times its hook block: with less on its rope a hook is empty, as in `limits.reading`


class Subjects:
    """All objects of a scene that have signals, by name, each with the model that watches it."""

    def __init__(self, builder: SceneBuilder) -> None:
        self.yard, self.gravity, machines = builder, builder.scene.gravity, builder.machines
        self.hooks = {hook.rope: hook for m in machines for hook in m.hooks}
        self.ropes = {rope.name: m.name for m in machines for rope in m.system.all_ropes}
        own = {beam: f"{crane}.{hook}" for beam, (crane, hook) in builder.hooks.items()}
        own |= {m.name: m.hooks[0].rope for m in machines if len(m.hooks) == 1}
        self.hooks |= {name: self.hooks[rope] for name, rope in own.items() if rope in self.hooks}
        self.points = {cargo.body: (cargo.body, Point(cargo.body)) for cargo in builder.cargo}
        self.points |= {body.name: (m.name, Point(body.name)) for m in machines for body in m.system.bodies}
        of = self.ropes
        self.points |= {name: (of[x.rope], x.eye) for name, x in self.hooks.items() if name not in self.points}
        self.points |= {beam: (beam, self.hooks[beam].eye) for beam in builder.hooks if beam in self.hooks}
        self.straight = [rope.name for m in machines for rope in m.system.straight_ropes]
        self.boxes = _boxes(builder)
        self.winds = [(m.name, f) for m in machines for f in m.system.forces if isinstance(f, Wind)]

    def signal(self, quantity: str, of: str) -> tuple[str, ScalarSignal] | None:
        """Return the watching model and the signal of a quantity of a hook, rope, point, pair of boxes or wind.

        None if there is no such signal."""
        kind, word = cast(Quantity, quantity), ".".join(of.split())
        hook, names = self.hooks.get(word), of.split()
        model = self.ropes[hook.rope] if hook else ""
        match quantity:
            case "height" if word in self.points:
                model, point = self.points[word]
                return model, ScalarSignal("height", point=point)
            case "height difference" if all(name in self.points for name in names):
                (model, point), (_, origin) = (self.points[name] for name in names)
                return model, ScalarSignal(kind, point=point, origin=origin)
            case "load" if hook:
                return model, ScalarSignal(kind, ropes=(hook.rope,), numbers=(1.0 / self.gravity, hook.block_mass))
            case "load" if (row := self.ratings[quantity].get(word)) and row.unit == "kg":
                each = signal_of(row, self.yard.machines, self.gravity)
                return (self.ropes[row.elements[0]], each) if each else None
            case "radius" if hook and hook.axis:
                return model, ScalarSignal(kind, point=hook.eye, origin=hook.axis)
            case "moment" if hook and hook.chart:
                chart = [x for radius, mass in hook.chart for x in (radius, mass * self.gravity)]
                numbers = EMPTY * hook.block_mass * self.gravity, *chart
                return model, ScalarSignal(kind, ropes=(hook.rope,), point=hook.eye, origin=hook.axis, numbers=numbers)
            case "off-lead" | "swing along" | "swing across" if (rope := hook.rope if hook else word) in self.straight:
                return self.ropes[rope], ScalarSignal(kind, ropes=(rope,))
            case "gap" if all(name in self.boxes for name in names):
                (model, a, half), (_, b, other) = (self.boxes[name] for name in names)
                return model, ScalarSignal(kind, point=a, origin=b, numbers=(*half, *other))
            case "wind" if self.winds:
                model, force = self.winds[0]
                return model, ScalarSignal(kind, of=force.name, point=force.at)
        return None

    @cached_property
    def ratings(self) -> dict[str, dict[str, RatedLimit]]:
        """The limits to which values in per cent refer, by quantity and subject."""
        rows = self.yard.limits or rated_limits(self.yard)
        found = {q: {x.subject.replace(" ", "."): x for x in rows if x.quantity in of} for q, of in RATINGS.items()}
        found["load"] |= {word: found["load"][x.rope] for word, x in self.hooks.items() if word not in found["load"]}
        return found

    def share(self, row: RatedLimit) -> tuple[str, ScalarSignal] | None:
        """Return the watching model and the signal of a load or tension in per cent of its limit; None if unlimited."""
        if row.over == "radius":
            return self.signal("moment", row.elements[0])
        if row.over == "trolley":
            hook = self.hooks[row.elements[0]]
            chart = [x for place, mass in row.chart for x in (place, mass)]
            numbers = 1.0 / self.gravity, self._blocks(row), *chart
            place = Point(hook.on)
            return self.ropes[hook.rope], ScalarSignal("use by place", ropes=row.elements, point=place, numbers=numbers)
        if row.value is None:
            return None
        own = self.gravity * row.value, self._blocks(row) / row.value
        numbers = (1.0 / row.value, 0.0) if row.unit == "N" else (1.0 / own[0], own[1])
        return self.ropes[row.elements[0]], ScalarSignal("load", ropes=row.elements, numbers=numbers)

    def _blocks(self, row: RatedLimit) -> float:
        return sum(self.hooks[rope].block_mass for rope in row.elements if rope in self.hooks)

    def known(self, quantity: str) -> list[str]:
        """Return the names of the objects that have a quantity."""
        hooks = self.hooks
        of: Mapping[str, Sequence[str]] = {
            "height": [*self.points],
            "height difference": [*self.points],
            "radius": [name for name, hook in hooks.items() if hook.axis],
            "moment": [name for name, hook in hooks.items() if hook.chart],
            "gap": [*self.boxes],
        }
        if quantity == "load":
            return [*hooks, *(subject for subject, row in self.ratings[quantity].items() if row.unit == "kg")]
        return list(of.get(quantity, self.straight if quantity in ("off-lead", "swing along", "swing across") else ()))


def _boxes(builder: SceneBuilder) -> dict[str, tuple[str, Point, Vector]]:
    """Return the boxes of loads, portals, floor and machine bodies, as (watching model, centre, half-extents) by
    name."""
    found: dict[str, tuple[str, Point, Vector]] = {}
    for cargo in builder.cargo:
        found[cargo.body] = cargo.body, Point(cargo.body), _half(cargo.size)
    for crane, girder in [(x, girder) for x in builder.cranes for girder in x.girders]:
        keys, com = builder.scene.machines.get(crane.name), {x.name: x.com for x in crane.system.bodies}[girder.body]
        boxes = [(x.centre, x.size) for x in crane.shapes if x.body == girder.body]
        size = (keys.bodies[girder.body].box if keys else None) or (around(boxes)[1] if boxes else None)
        if size:  # it stands on the ground
            found[crane.name] = crane.name, Point(girder.body, (com[0], com[1], size[2] / 2)), _half(size)
    if floor := builder.scene.floor:
        found["floor"] = "obstacles", Point(WORLD, (0.0, 0.0, floor.height - WIDE)), (WIDE, WIDE, WIDE)
    for m in builder.machines:
        for body in dict.fromkeys(shape.body for shape in m.shapes if shape.body not in found):
            centre, size = around([(x.centre, x.size) for x in m.shapes if x.body == body])
            found[body] = m.name, Point(body, centre), _half(size)
    return found


def _half(size: Vector) -> Vector:
    return size[0] / 2, size[1] / 2, size[2] / 2
