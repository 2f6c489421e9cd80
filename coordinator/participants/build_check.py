"""What coordinator and node must find alike before a run: each builds the whole model, and must have built the same.

A declaration holds, of each child of a node, its ports and a fingerprint of each attribute of each model in it, before
`start`; of the root, its children and couplings, told by the first of them.  What cannot be told by bytes, such as a
lambda, stands for its class.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from hashlib import blake2b

import msgspec
from heavylift.kernel.errors import UNREADABLE
from heavylift.nodes.devs import Coupled, InPort, Model, Port
from heavylift.nodes.devs.execution.canonical import Freezer
from heavylift.nodes.devs.execution.flatten import tree

_Declared = tuple[list[tuple[str, str, str]], dict[str, dict[str, bytes]]]  # ports; path, attribute, fingerprint
_DECODER: msgspec.msgpack.Decoder[dict[str, _Declared]] = msgspec.msgpack.Decoder(dict[str, _Declared])


def declarations(root: Coupled, nodes: Iterable[Sequence[str]]) -> Iterator[bytes]:
    """Of the children of each node, of a root that has just been built."""
    freezer, first = Freezer(tree(root)), min(root.children)
    for names in nodes:
        yield msgspec.msgpack.encode({name: _declared(root, name, freezer, name == first) for name in names})


def _declared(root: Coupled, name: str, freezer: Freezer, first: bool) -> _Declared:
    freezer.forget()
    child = root.children[name]
    ports = sorted((p.name, "in" if isinstance(p, InPort) else "out", p.type.__name__) for p in child.ports.values())
    found = {root.path: {"structure": _fingerprint(freezer, _structure(root))}} if first else {}
    for model in tree(child):
        own = {"class": type(model), "structure": _structure(model)}
        own |= {key: x for key, x in vars(model).items() if key not in ("children", "_coupled")}
        found[model.path] = {key: _fingerprint(freezer, own[key]) for key in sorted(own)}
    return ports, found


def difference(here: bytes, there: bytes) -> tuple[str, str]:
    """The first child that differs and what does; ("", "") if none is found."""
    try:
        all_here, all_there = _DECODER.decode(here), _DECODER.decode(there)
    except UNREADABLE:
        return "", "what it declares"
    for name in sorted({*all_here, *all_there}):
        (ports, found), (its_ports, its) = (x.get(name, ([], {})) for x in (all_here, all_there))
        if ports != its_ports:
            return name, "its ports"
        for path in sorted({*found, *its}):
            a, b = found.get(path, {}), its.get(path, {})
            for key in sorted({*a, *b}):
                if a.get(key) != b.get(key):
                    return name, f"the {key} of {path}" if key in ("class", "structure") else f"{path}.{key}"
    return "", ""


def _structure(model: Model) -> Sequence[object]:
    """Ports, children and couplings, in an order of their own."""
    ports = [(p.name, type(p).__name__, p.type.__name__, getattr(p, "lookahead", 0)) for p in model.ports.values()]
    if not isinstance(model, Coupled):
        return sorted(ports)
    return [sorted(ports), sorted(model.children), sorted((repr(a), repr(b)) for a, b in model.couplings)]


def _fingerprint(freezer: Freezer, x: object) -> bytes:
    if isinstance(x, Port) and x.owner.ports.get(x.name) is x:
        told: object = repr(x)
    else:
        bits = getattr(x, "bit_generator", None)  # of a random generator of NumPy's
        try:
            told = freezer.fold(x if bits is None else bits.state)
        except Exception:  # whatever a class of a user's raises when it is looked at
            told = type(x).__qualname__
    return blake2b(msgspec.msgpack.encode(told), digest_size=8).digest()
