"""The islands of a system: sets of coupled bodies, with all that acts on them.

Joints, forces, contacts and ropes couple bodies; the ground couples nothing, nor does a *loose* rope, which is never
hooked: a loose rope belongs to the island of its first end, and its other end counts as ground. A commanded master is a
function of time, so each island with actuators has its own copy; a measured master couples its body to all actuators
that may follow it.
"""

from collections.abc import Collection, Iterator
from dataclasses import fields, replace
from typing import Any

from heavylift.kernel.description.mechanics import JOINTS, WORLD, AnyRope, Point, System
from heavylift.kernel.forces.table import signals
from heavylift.kernel.model.quantities import OF_GROUPS, points

GROUPS = tuple(f.name for f in fields(System) if f.name not in ("masters", "gravity"))


def islands_of(system: System, loose: Collection[str] = ()) -> list[System]:
    """Return one system per island (independent part), in the order of their first bodies.

    `loose`: ropes that are unhooked and couple no bodies. Fixed parts, and items without a body, belong to the first
    island that can move.
    """
    child = {j.name: j.child if j.child != WORLD else j.parent for j in system.joints}
    ropes = {r.name: _ends(r)[: 1 if r.name in loose else None] for r in system.all_ropes}
    held = {(group, i): _bodies(group, x, system, child, ropes) for group, i, x in _items(system)}
    island = {b.name: b.name for b in system.bodies}

    def root(body: str) -> str:
        while island[body] != body:
            body = island[body]
        return body

    def tie(bodies: list[str]) -> None:
        for b in bodies[1:]:
            island[root(b)] = root(bodies[0])

    for bodies in held.values():
        tie(bodies)
    actors = {name for name, signal in signals(system.forces).items() if signal.driven}
    actors |= {*(d.name for d in system.drives), *(r.name for r in system.straight_ropes if r.winch)}
    acting = {(g, i): name for g, i in held if (name := getattr(system, g)[i].name) in actors}
    led = [b for key in acting for b in held[key]]
    for i, measured in enumerate(system.measured if led else ()):
        may = measured.followers or acting.values()
        tie([*held["measured", i], *(b for key, name in acting.items() if name in may for b in held[key])])
    moving = [root(j.child) for j in system.joints if j.child != WORLD and JOINTS[j.kind].n_v]
    moving += [root(b.name) for b in system.bodies if b.flexible]
    for b in system.bodies:
        if moving and root(b.name) not in moving:
            island[root(b.name)] = moving[0]
    number: dict[str, int] = {}  # of the island of a root
    for b in system.bodies:
        number.setdefault(root(b.name), len(number))
    parts: list[dict[str, list[Any]]] = [{group: [] for group in GROUPS} for _ in number]
    for group, i, x in _items(system):
        parts[number[root(bodies[0])] if (bodies := held[group, i]) else 0][group].append(x)
    leads = {number[root(b)] for b in led} or {0}
    return [_island(system, part, k in leads) for k, part in enumerate(parts)]


def loose_ropes(system: System, ties: Collection[str]) -> frozenset[str]:
    """Return the names of ropes that are unhooked at the start and never hooked; `ties`: ropes hooked later."""
    return frozenset(r.name for r in system.straight_ropes if not r.hooked and r.name not in ties)


def _island(system: System, part: dict[str, list[Any]], led: bool) -> System:
    parts: dict[str, Any] = {group: tuple(of) for group, of in part.items()}
    own = {WORLD, *(b.name for b in parts["bodies"])}

    def here(p: Point) -> Point:
        return p if p.body in own else Point(WORLD, p.p)

    for group in ("ropes", "rigid_ropes"):
        parts[group] = tuple(
            replace(r, lines=tuple(replace(x, a=here(x.a), b=here(x.b)) for x in r.lines)) for r in parts[group]
        )
    return replace(system, **parts, masters=system.masters if led else ())


def _items(system: System) -> Iterator[tuple[str, int, Any]]:
    for group in GROUPS:
        for i, x in enumerate(getattr(system, group)):
            yield group, i, x


def _ends(rope: AnyRope) -> list[str]:
    """Return the bodies of a rope, without the ground."""
    return [b for b in dict.fromkeys(p.body for line in rope.lines for p in (line.a, line.b)) if b != WORLD]


def _bodies(group: str, x: Any, system: System, child: dict[str, str], ropes: dict[str, list[str]]) -> list[str]:
    """Return the bodies coupled by an item of a system, without the ground; `child`: by joint; `ropes`: by rope."""
    match group:
        case "bodies":
            found = [x.name, *([x.shared.beside] if x.shared else [])]
        case "joints":
            found = [x.parent, x.child]
        case "ropes" | "rigid_ropes":
            found = ropes[x.name]
        case "supports":
            found = [p.body for p in x.points]
        case "forces":
            found = [p.body for p in x.points] + ([child[x.along[0]]] if x.along else [])
        case "contacts":
            found = [x.a.body, x.b.body]
        case "measured":
            found = [child[x.of] if x.kind == "joint" else x.of]
        case "thresholds":
            found = [b for r in x.ropes for b in ropes[r]] + [p.body for p in (x.point, x.origin) if p]
            found += [p.body for p in points(x, system)] if x.quantity in OF_GROUPS else []
            found += [child.get(x.of, x.of)] if x.of and x.quantity != "wind" else []
        case _:
            found = [child[x.joint]]
    return [b for b in dict.fromkeys(found) if b != WORLD]
