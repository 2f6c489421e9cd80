"""Closure under coupling, made executable: dissolve a model tree into atomics with direct routes.

Every way from an atomic's out port through couplings to an atomic's in port (a route) or to an out port of
the root (an exit) gets a place. Places order the bag of the target as nested simulators would: its ports by name, and
in each of them the union over all couplings into it by (source model, its port), what comes from outside first, and
inside each of those the order of that port's own bag, recursively. So a bag does not depend on how deep models are
nested or where a tree is cut into nodes.
"""

from typing import Never

from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Atomic, Coupled, Model
from heavylift.nodes.devs.ports import InPort, OutPort, Port

_Way = tuple[str, Port[Message]]  # its hops (source model's name, "" from outside; port) backwards, and where it begins


def flatten(root: Model) -> list[Atomic]:
    """The atomics of a tree in path order; their out ports and the root's in ports keep their routes and exits."""
    models: list[Model] = []
    _collect(root, root.path, models)
    atomics = [m for m in models if isinstance(m, Atomic)]
    ahead: dict[Port[Message], list[Port[Message]]] = {}
    for model in models:
        if isinstance(model, Coupled):
            for source, target in model._coupled:
                ahead.setdefault(source, []).append(target)
    for index, atomic in enumerate(atomics):
        atomic._index = index

    starts: list[Port[Message]] = [p for m in atomics for p in m.ports.values() if isinstance(p, OutPort)]
    starts += [p for p in root.ports.values() if isinstance(p, InPort)]
    into: dict[Port[Message], list[_Way]] = {}
    for start in starts:
        if root is start.owner and isinstance(root, Atomic):
            into[start] = [("", start)]
        else:
            _follow(start, ahead, root, into)

    routes: dict[Port[Message], list[tuple[Atomic, InPort[Message], int]]] = {port: [] for port in starts}
    exits: dict[Port[Message], list[tuple[OutPort[Never], int]]] = {port: [] for port in starts}
    for m in atomics if isinstance(root, Atomic) else [*atomics, root]:
        place = 0
        for name in sorted(m.ports):
            port = m.ports[name]
            for _, start in sorted(into.get(port, ()), key=_hops):
                if isinstance(port, OutPort):
                    exits[start].append((port, place))
                elif isinstance(port, InPort) and isinstance(m, Atomic):
                    routes[start].append((m, port, place))
                place += 1
    for start in starts:
        start.routes = tuple(routes[start])
        if isinstance(start, OutPort):
            start.exits = tuple(exits[start])
    return atomics


def _collect(model: Model, path: str, models: list[Model]) -> None:
    """The models of a tree in the order of their paths, which they keep while they run."""
    model._path = path
    models.append(model)
    if isinstance(model, Coupled):
        for name in sorted(model.children):
            _collect(model.children[name], f"{path}.{name}", models)


def _follow(
    start: Port[Message],
    ahead: dict[Port[Message], list[Port[Message]]],
    root: Model,
    into: dict[Port[Message], list[_Way]],
) -> None:
    """All ways from a port, noted at their ends."""
    going = [(start, "")]
    while going:
        port, hops = going.pop()
        for target in ahead.get(port, ()):
            owner = target.owner
            source = "" if owner.parent is port.owner else port.owner.name
            way = f"{source}\0{port.name}\1{hops}"  # sorts as the tuple of its names would, and is no container
            if isinstance(owner, Atomic) or owner is root:
                into.setdefault(target, []).append((way, start))
            else:
                going.append((target, way))


def _hops(way: _Way) -> str:
    return way[0]
