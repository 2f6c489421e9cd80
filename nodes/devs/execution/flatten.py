"""Flattening (closure under coupling): replace a tree of coupled models by its atomic models with direct routes.

Each path through couplings from an output port of an atomic model, either to an input port of an atomic model (a route)
or to an output port of a root model (an exit), gets a place number. Place numbers order the messages in a receiver's
bag as nested simulators would: by input port name; in each port by source model and its port, over all couplings into
the port, with messages from outside first; and for each source in the order of that port's own bag, recursively. So the
order in a bag does not depend on how deeply models are nested or how a tree is divided into nodes.

Several roots are siblings that share a node. They are coupled to each other and to models in other nodes. Each output
port of another node is an entry here, with routes and places like any port; its messages keep the order in which they
arrive.
"""

from collections.abc import Iterable, Sequence
from operator import itemgetter
from typing import Never

from heavylift.nodes.devs.messages import Message
from heavylift.nodes.devs.models import Atomic, Coupled, Model
from heavylift.nodes.devs.ports import InPort, OutPort, Port

_Way = tuple[str, Port[Message]]  # its hops (source model's name, "" from outside; port) backwards, and where it begins
Wire = tuple[str, str, str, str]  # a coupling: source model, its port, target model, its port
Ahead = dict[Port[Message], list[Port[Message]]]
Entries = dict[tuple[str, str], tuple[Port[Message], list[Port[Message]]]]  # by source and port; the in ports reached


def flatten(roots: Sequence[Model], wires: Iterable[Wire] | None = None) -> tuple[list[Atomic], Entries]:
    """Return the atomic models below the root models, sorted by path, and the input ports where events from outside
    enter.

    Without `wires`, each input port of a root takes messages, and each of its output ports is an exit. With `wires`
    (the couplings of the node's models), output ports coupled to a model in another node are exits; the others are
    `inner`.
    """
    tops = {root.name: root for root in sorted(roots, key=lambda root: root.name)}
    models: list[Model] = []
    for root in tops.values():
        path = root.path
        for model in tree(root):  # which keep their paths while they run
            model._path = path if model is root or model.parent is None else f"{model.parent._path}.{model.name}"
            models.append(model)
    atomics = [m for m in models if isinstance(m, Atomic)]
    ahead: Ahead = {}
    for model in models:
        if isinstance(model, Coupled):
            for source, target in model._coupled:
                ahead.setdefault(source, []).append(target)
    for index, atomic in enumerate(atomics):
        atomic._index = index
    entries, leaving = _wired(tops, wires or (), ahead)

    starts: list[Port[Message]] = [p for m in atomics for p in m.ports.values() if isinstance(p, OutPort)]
    starts += [entry for entry, _ in entries.values()]
    starts += [p for m in tops.values() for p in m.ports.values() if isinstance(p, InPort) and wires is None]
    into: dict[Port[Message], list[_Way]] = {}
    for start in starts:
        if isinstance(start.owner, Atomic) and tops.get(start.owner.name) is start.owner:
            into[start] = [("", start)]
        _follow(start, ahead, tops, into)

    routes: dict[Port[Message], list[tuple[Atomic, InPort[Message], int]]] = {port: [] for port in starts}
    exits: dict[Port[Message], list[tuple[OutPort[Never], int]]] = {port: [] for port in starts}
    for m in [*atomics, *(root for root in tops.values() if isinstance(root, Coupled))]:
        place = 0
        for name in sorted(m.ports):
            port = m.ports[name]
            for _, start in sorted(into.get(port, ()), key=itemgetter(0)):
                if isinstance(port, OutPort):
                    exits[start].append((port, place))
                elif isinstance(port, InPort) and isinstance(m, Atomic):
                    routes[start].append((m, port, place))
                place += 1
    for start in starts:
        start.routes = tuple(routes[start])
        if isinstance(start, OutPort):
            start.exits = tuple(distance for distance in exits[start] if wires is None or distance[0] in leaving)
            start.inner = tuple(
                distance for distance in exits[start] if wires is not None and distance[0] not in leaving
            )
    return atomics, entries


def tree(model: Model) -> list[Model]:
    """Return a model and all its descendants, parents first, children by name."""
    found, waiting = list[Model](), [model]
    while waiting:
        model = waiting.pop()
        found.append(model)
        if isinstance(model, Coupled):
            waiting += (model.children[name] for name in sorted(model.children, reverse=True))
    return found


def _wired(tops: dict[str, Model], wires: Iterable[Wire], ahead: Ahead) -> tuple[Entries, set[Port[Message]]]:
    """Apply the couplings between roots; return the ports where messages from outside enter, and the ports that lead to
    other nodes."""
    entries: Entries = {}
    leaving = set[Port[Message]]()
    for source, port, target, into in wires:
        if source in tops:
            start: Port[Message] = tops[source].ports[port]
            if target not in tops:
                leaving.add(start)
        elif target in tops:
            start, targets = entries.setdefault(
                (source, port), (OutPort[Message](Model(source), port, Message, 0), list[Port[Message]]())
            )
            targets.append(tops[target].ports[into])
        if target in tops:
            ahead.setdefault(start, []).append(tops[target].ports[into])
    return entries, leaving


def _follow(start: Port[Message], ahead: Ahead, tops: dict[str, Model], into: dict[Port[Message], list[_Way]]) -> None:
    """Find all routes that start at a port, and add each to the port where it ends."""
    going = [(start, "")]
    while going:
        port, hops = going.pop()
        for target in ahead.get(port, ()):
            owner = target.owner
            source = "" if owner.parent is port.owner else port.owner.name
            distance = f"{source}\0{port.name}\1{hops}"  # sorts as the tuple of its names would, and is no container
            inward = isinstance(owner, Atomic)
            if inward or (isinstance(target, OutPort) and tops.get(owner.name) is owner):
                into.setdefault(target, []).append((distance, start))
            if not inward:
                going.append((target, distance))
