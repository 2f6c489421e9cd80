"""The names by which items of a description mean each other: of each there is one."""

from collections.abc import Iterator
from typing import Any

from heavylift.kernel.errors import KernelError, closest

from .contacts import Contact
from .field_types import item_word
from .laws import Lock
from .mechanics import GROUPS, WORLD, Drive, Joint, Measured, System, Threshold

OF = {"joint": "joint", "speed": "joint", "wind": "wind or other force"}  # what a quantity is of, if not of a body


def check_names(system: System) -> None:
    """Raises KernelError for the first item that names something that is not there, and says what was perhaps meant."""
    known = {
        "body": [*(b.name for b in system.bodies), WORLD],
        "joint": [j.name for j in system.joints],
        "rope": [r.name for r in system.all_ropes],
        "wind or other force": [f.name for f in system.forces],
    }
    sets = {kind: set(names) for kind, names in known.items()}
    for x in (x for group in GROUPS for x in getattr(system, group)):
        for kind, name in _named(x):
            if name not in sets[kind]:
                near = closest(name, known[kind]) or f"the system has no {kind} at all"
                raise KernelError(f"{item_word(x)} '{x.name}': there is no {kind} '{name}'; {near}")


def _named(x: Any) -> Iterator[tuple[str, str]]:
    """Kind and name of what an item means; what it lacks is told elsewhere."""
    match x:
        case Joint():
            yield from (("body", x.parent), ("body", x.child))
        case Lock() | Drive():
            yield "joint", x.joint
        case Contact():
            yield from (("body", x.a.body), ("body", x.b.body))
        case Measured():
            yield "joint" if x.kind == "joint" else "body", x.of
        case Threshold():
            yield from (("body", p.body) for p in (x.point, x.origin) if p)
            yield from (("rope", rope) for rope in x.ropes)
            if x.of:
                yield OF.get(x.quantity, "body"), x.of
        case _:
            yield from (("body", p.body) for p in getattr(x, "points", ()))
            if along := getattr(x, "along", None):
                yield "joint", along[0]
