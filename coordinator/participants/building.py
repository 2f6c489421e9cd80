"""Finds the model that a researcher names: `package.module:function` or `path/to/file.py:function`.

The function may be given arguments that Python can read as they stand, such as in
`heavylift.nodes.zoo.token_ring:ring(4, 2, 500)`.  It returns a Coupled, new at each call and always the same; each
child becomes a node.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from pathlib import Path
from weakref import WeakSet

from heavylift.coordinator.protocol.distance import Coupling
from heavylift.kernel.description.user_code import raised
from heavylift.kernel.errors import HeavyliftError, ModelError
from heavylift.kernel.trust import foreign, refusal
from heavylift.nodes.devs import Coupled, Model, OutPort
from heavylift.nodes.devs.references import imported, read

_returned: WeakSet[Model] = WeakSet()


def built(reference: str, by: str = "") -> Coupled:
    """The model of a reference; ModelError says what is wrong with it, or that code which data of `by` names is not
    trusted."""
    where, name, arguments, named = read(reference)
    if by and (why := refusal(where, reference)):
        raise ModelError(f"{by}: {why}")
    found = imported(where)
    function, own, file = getattr(found, name, None), Path(f"{where}.py"), getattr(found, "__file__", None) or where
    if not callable(function):
        if own.exists() and own.resolve() != Path(file).resolve():
            raise ModelError(f"{reference}: {where} is {file}, which has no {name}; give {own} another name")
        raise ModelError(f"{reference}: {where} has no function {name}; define it and let it return a Coupled")
    if by and (why := foreign(function, reference)):
        raise ModelError(f"{by}: {name} of '{where}' must not be called: {why}")
    try:
        model = function(*arguments, **named)
    except HeavyliftError:
        raise
    except Exception as error:
        raise ModelError(f"{reference}: {name}() raised {raised(error)}") from error
    if not isinstance(model, Coupled):
        raise ModelError(f"{reference}: {name}() returned {type(model).__name__}, it must return a Coupled")
    if model in _returned:
        raise ModelError(
            f"{reference}: {name}() returned the model of an earlier call; let it make a new one each time"
        )
    _returned.add(model)
    if not model.children:
        raise ModelError(f"{reference}: {model.name} has no children, and each child becomes a node; add some")
    return model


def seeded(reference: str, seed: int) -> str:
    """The reference with this `seed`; ModelError if its function takes none, or has one already."""
    where, name, arguments, named = read(reference)
    function = getattr(imported(where), name, None)
    parameters = inspect.signature(function).parameters if callable(function) else {}
    if callable(function) and "seed" not in parameters:
        raise ModelError(f"{reference}: {name}() takes no seed, so that all runs are equal; give it a parameter `seed`")
    if "seed" in named or "seed" in [*parameters][: len(arguments)]:
        raise ModelError(f"{reference}: the seed is given twice; leave it out of the brackets")
    given = [*map(repr, arguments), *(f"{key}={x!r}" for key, x in named.items()), f"seed={seed}"]
    return f"{where}:{name}({', '.join(given)})"


def module(reference: str) -> str:
    """The module or file of a reference."""
    return read(reference)[0]


def with_children(reference: str, names: Iterable[str], by: str) -> Coupled:
    """The model, which has children of these names for a node, where data of `by` names it."""
    model = built(reference, by)
    for name in names:
        if name not in model.children:
            raise ModelError(
                f"{reference}: {model.name} has no child {name} here, it has {', '.join(model.children)}; let the "
                "function build the same model each time"
            )
    return model


def stopping(model: Coupled, stop: str) -> tuple[str, str] | None:
    """The (child, port) named by "child.port" whose first message ends a run; ModelError if there is none."""
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
    """The couplings between children; what leads to a port of the model itself leaves the run.  Every node hears of the
    port `finish`, which ends it."""
    between = [
        Coupling(source.owner.name, source.name, target.owner.name, target.name)
        for source, target in model.couplings
        if source.owner is not model and target.owner is not model
    ]
    return [*between, Coupling(*finish, "", "")] if finish else between
