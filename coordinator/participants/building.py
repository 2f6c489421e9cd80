"""Building of the model that a user names: `package.module:function` or `path/to/file.py:function`, and declarations.

The function may be given literal arguments, as in `heavylift.nodes.zoo.token_ring:ring(4, 2, 500)`. It returns a new
Coupled at each call, always with the same structure; each child becomes a node. Coordinator and nodes each build the
whole model and compare declarations before a run: for each child its ports and, before `start`, a fingerprint of each
attribute of each model in it (without canonical bytes: of its class); with the first child the root's couplings.
"""

import inspect
from collections.abc import Iterable, Iterator, Sequence
from hashlib import blake2b
from pathlib import Path
from weakref import WeakSet

import msgspec
from heavylift.coordinator.protocol.distance import Coupling
from heavylift.kernel.description.user_code import raised
from heavylift.kernel.errors import UNREADABLE, HeavyliftError, ModelError
from heavylift.kernel.trust import foreign, refusal
from heavylift.nodes.devs import Coupled, InPort, Model, OutPort, Port
from heavylift.nodes.devs.execution.canonical import Freezer
from heavylift.nodes.devs.execution.flatten import tree
from heavylift.nodes.devs.references import imported, read

_returned: WeakSet[Model] = WeakSet()


def built(reference: str, by: str = "") -> Coupled:
    """Build the DEVS model that a reference `module:function` names.

    Raises ModelError if that fails, or if the reference comes from the data `by` and names code that the user has not
    trusted.
    """
    where, name, arguments, named = read(reference)
    if by and (why := refusal(where, reference)):
        raise ModelError(f"{by}: {why}")
    found = imported(where)
    function, own, file = getattr(found, name, None), Path(f"{where}.py"), getattr(found, "__file__", None) or where
    if not callable(function):
        if own.exists() and own.resolve() != Path(file).resolve():
            raise ModelError(f"{reference}: {where} is {file}, which has no {name}; rename {own}")
        raise ModelError(f"{reference}: {where} has no function {name}; define one that returns a Coupled")
    if by and (why := foreign(function, reference)):
        raise ModelError(f"{by}: {name} of '{where}' must not be called: {why}")
    try:
        model = function(*arguments, **named)
    except HeavyliftError:
        raise
    except Exception as error:
        raise ModelError(f"{reference}: {name}() raised {raised(error)}") from error
    if not isinstance(model, Coupled):
        raise ModelError(f"{reference}: {name}() returned {type(model).__name__}; the function must return a Coupled")
    if model in _returned:
        raise ModelError(
            f"{reference}: {name}() returned the model of an earlier call; it must create a new one each time"
        )
    _returned.add(model)
    if not model.children:
        raise ModelError(
            f"{reference}: {model.name} has no children; add at least one, since each child becomes a node"
        )
    return model


def seeded(reference: str, seed: int) -> str:
    """Add the argument `seed` to a reference `module:function(...)`; raises ModelError if the function takes no
    seed."""
    where, name, arguments, named = read(reference)
    function = getattr(imported(where), name, None)
    parameters = inspect.signature(function).parameters if callable(function) else {}
    if callable(function) and "seed" not in parameters:
        raise ModelError(
            f"{reference}: {name}() takes no seed, so all runs would be identical; give it a parameter `seed`"
        )
    if "seed" in named or "seed" in [*parameters][: len(arguments)]:
        raise ModelError(f"{reference}: the seed is given twice; leave it out of the arguments")
    given = [*map(repr, arguments), *(f"{key}={x!r}" for key, x in named.items()), f"seed={seed}"]
    return f"{where}:{name}({', '.join(given)})"


def module(reference: str) -> str:
    """Return the module or file that a reference names."""
    return read(reference)[0]


def with_children(reference: str, names: Iterable[str], by: str) -> Coupled:
    """Build the model that `reference` names, and check that it has children with these names."""
    model = built(reference, by)
    for name in names:
        if name not in model.children:
            raise ModelError(
                f"{reference}: {model.name} has no child {name} here, it has {', '.join(model.children)}; let the "
                "function build the same model each time"
            )
    return model


def stopping(model: Coupled, stop: str) -> tuple[str, str] | None:
    """Return the port whose first message ends a run, given as the text "child.port"; None for ""."""
    if not stop:
        return None
    known = {
        f"{child.name}.{p.name}": (child.name, p.name)
        for child in model.children.values()
        for p in child.ports.values()
        if isinstance(p, OutPort)
    }
    if stop not in known:
        from heavylift.recordings.format.text import meant  # nodes do without it

        raise ModelError(f"--stop {stop}: no child of {model.name} has this out port; {meant(stop, list(known))}")
    return known[stop]


def couplings(model: Coupled, finish: tuple[str, str] | None = None) -> list[Coupling]:
    """Return the couplings between the children of a model, including that of the port `finish`, which ends the run."""
    between = [
        Coupling(source.owner.name, source.name, target.owner.name, target.name)
        for source, target in model.couplings
        if source.owner is not model and target.owner is not model
    ]
    return [*between, Coupling(*finish, "", "")] if finish else between


_Declared = tuple[list[tuple[str, str, str]], dict[str, dict[str, bytes]]]  # ports; path, attribute, fingerprint
_DECODER: msgspec.msgpack.Decoder[dict[str, _Declared]] = msgspec.msgpack.Decoder(dict[str, _Declared])


def declarations(root: Coupled, nodes: Iterable[Sequence[str]]) -> Iterator[bytes]:
    """Yield, for each node of a newly built root, the encoded declarations of its models: ports and message types."""
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
    """Return the first child in which two declarations differ, and the difference; ("", "") if they are equal."""
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
    """Return ports, children and couplings of a model in a fixed order."""
    ports = [(p.name, type(p).__name__, p.type.__name__, getattr(p, "lookahead", 0)) for p in model.ports.values()]
    if not isinstance(model, Coupled):
        return sorted(ports)
    return [sorted(ports), sorted(model.children), sorted((repr(a), repr(b)) for a, b in model.couplings)]


def _fingerprint(freezer: Freezer, x: object) -> bytes:
    if isinstance(x, Port) and x.owner.ports.get(x.name) is x:
        message: object = repr(x)
    else:
        bits = getattr(x, "bit_generator", None)  # of a random generator of NumPy's
        try:
            message = freezer.fold(x if bits is None else bits.state)
        except Exception:  # whatever a class of a user's raises when it is looked at
            message = type(x).__qualname__
    return blake2b(msgspec.msgpack.encode(message), digest_size=8).digest()
