"""Closure under coupling, made executable: dissolve a model tree into atomics with direct routes.

Every way from an atomic's out port through couplings to an atomic's in port (a route) or to an out port of
the root (an exit) gets a rank. Ranks order the bag of the target as nested simulators would: the union
over all couplings into a port by (source model, its port), what comes from outside first, and inside each
of them the order of that port's own bag, recursively. So a bag does not depend on how deep models are
nested or where a tree is cut into nodes.
"""

from collections.abc import Iterator
from typing import Any

from .models import Atomic, Coupled, Model
from .ports import InPort, OutPort, Port

_Hop = tuple[str, str]  # (source model's name, its port); "" is the parent: messages from outside
_Hops = tuple[_Hop, ...]  # from the target backwards
Route = tuple[InPort[Any], Atomic, int]  # target, its owner, rank


def flatten(root: Model) -> list[Atomic]:
    """The atomics of a tree in path order; their out ports and the root's in ports keep their routes and exits."""
    models: list[Model] = []
    _collect(root, root.path, models)
    atomics = [m for m in models if isinstance(m, Atomic)]
    ahead: dict[Port[Any], list[Port[Any]]] = {}
    for model in models:
        if isinstance(model, Coupled):
            for source, target in model.couplings:
                ahead.setdefault(source, []).append(target)

    starts: list[Port[Any]] = [p for m in atomics for p in m.ports.values() if isinstance(p, OutPort)]
    starts += [p for p in root.ports.values() if isinstance(p, InPort)]
    if isinstance(root, Atomic):
        ways: dict[Port[Any], list[tuple[Port[Any], _Hops]]] = {p: [(p, ())] for p in starts}
    else:
        ways = {p: list(_ways(p, (), ahead, root)) for p in starts}

    into: dict[Port[Any], list[_Hops]] = {}
    for ends in ways.values():
        for target, hops in ends:
            into.setdefault(target, []).append(hops)
    rank = {target: {hops: i for i, hops in enumerate(sorted(all_))} for target, all_ in into.items()}

    for index, atomic in enumerate(atomics):
        atomic._index = index
        for port in atomic.ports.values():
            if isinstance(port, OutPort):
                port.exits = tuple((t, rank[t][hops]) for t, hops in ways[port] if isinstance(t, OutPort))
    for port in starts:
        port.routes = _routes(ways[port], rank)
    return atomics


def _collect(model: Model, path: str, models: list[Model]) -> None:
    """The models of a tree in the order of their paths, which they keep while they run."""
    model._path = path
    models.append(model)
    if isinstance(model, Coupled):
        for name in sorted(model.children):
            _collect(model.children[name], f"{path}.{name}", models)


def _ways(
    port: Port[Any], hops: _Hops, ahead: dict[Port[Any], list[Port[Any]]], root: Model
) -> Iterator[tuple[Port[Any], _Hops]]:
    for target in ahead.get(port, ()):
        hop = ("" if target.owner.parent is port.owner else port.owner.name, port.name)
        if isinstance(target.owner, Atomic) or target.owner is root:
            yield target, (hop, *hops)
        else:
            yield from _ways(target, (hop, *hops), ahead, root)


def _routes(ends: list[tuple[Port[Any], _Hops]], rank: dict[Port[Any], dict[_Hops, int]]) -> tuple[Route, ...]:
    found = [(t, t.owner, rank[t][hops]) for t, hops in ends if isinstance(t, InPort)]
    return tuple((t, m, r) for t, m, r in found if isinstance(m, Atomic))
