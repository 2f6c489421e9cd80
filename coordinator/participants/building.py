"""Finds the model that a researcher names: `package.module:function` or `path/to/file.py:function`.

The function may be given arguments that Python can read as they stand, such as in
`heavylift.nodes.zoo.token_ring:ring(4, 2, 500)`.  It returns a Coupled, new at each call and always the same; each
child becomes a node.
"""

from __future__ import annotations

import ast
import importlib
import importlib.util
import inspect
import sys
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType
from weakref import WeakSet

from heavylift.coordinator.protocol.distance import Coupling
from heavylift.kernel.errors import HeavyliftError, ModelError
from heavylift.kernel.trust import foreign, refusal
from heavylift.nodes.devs import Coupled, Model, OutPort

__all__ = ["built", "couplings", "importing", "module", "seeded", "stopping", "with_children"]

_importing: list[str] = []
_returned: WeakSet[Model] = WeakSet()


def built(reference: str, by: str = "") -> Coupled:
    """The model of a reference; ModelError says what is wrong with it, or that code which data of `by` names is not
    trusted."""
    where, name, arguments, named = _read(reference)
    if by and (why := refusal(where, reference)):
        raise ModelError(f"{by}: {why}")
    found = _module(where)
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
        raise ModelError(f"{reference}: {name}() raised {type(error).__name__}: {error}") from error
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
    where, name, arguments, named = _read(reference)
    function = getattr(_module(where), name, None)
    parameters = inspect.signature(function).parameters if callable(function) else {}
    if callable(function) and "seed" not in parameters:
        raise ModelError(f"{reference}: {name}() takes no seed, so that all runs are equal; give it a parameter `seed`")
    if "seed" in named or "seed" in [*parameters][: len(arguments)]:
        raise ModelError(f"{reference}: the seed is given twice; leave it out of the brackets")
    given = [*map(repr, arguments), *(f"{key}={x!r}" for key, x in named.items()), f"seed={seed}"]
    return f"{where}:{name}({', '.join(given)})"


def module(reference: str) -> str:
    """The module or file of a reference."""
    return _read(reference)[0]


def _read(reference: str) -> tuple[str, str, list[object], dict[str, object]]:
    """Module or file, function, positional and named arguments."""
    where = reference.partition("(")[0].rpartition(":")[0]
    try:
        tree = ast.parse(reference[len(where) + 1 :], mode="eval").body
        if isinstance(tree, ast.Name) and where:
            return where, tree.id, [], {}
        if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and where:
            named = {k.arg: ast.literal_eval(k.value) for k in tree.keywords if k.arg is not None}
            return where, tree.func.id, [ast.literal_eval(x) for x in tree.args], named
    except (SyntaxError, ValueError):
        pass
    raise ModelError(
        f"{reference!r} names no model: write module:function, such as my_models:build or my_models:ring(4, hold=5)"
    )


def _module(where: str) -> ModuleType:
    _importing.append(where)
    try:
        if not where.endswith(".py"):
            return importlib.import_module(where)
        path = Path(where).resolve()
        spec = importlib.util.spec_from_file_location(path.stem, path)
        if spec is None or spec.loader is None:
            raise FileNotFoundError(where)
        if path.stem in sys.modules:
            known = sys.modules[path.stem]
            if Path(known.__file__ or "") == path:
                return known
            raise ModelError(f"{where}: a module {path.stem} exists already; give the file another name")
        module = sys.modules[path.stem] = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[path.stem]
            raise
        return module
    except HeavyliftError:
        raise
    except FileNotFoundError as error:
        raise ModelError(f"{where}: there is no such file") from error
    except ModuleNotFoundError as error:
        if error.name is not None and f"{where}.".startswith(f"{error.name}."):
            raise ModelError(f"there is no module {where} in . or installed") from error
        raise ModelError(f"{where} cannot be imported: {error}") from error
    except Exception as error:
        raise ModelError(f"{where} cannot be imported: {type(error).__name__}: {error}") from error
    finally:
        _importing.pop()


def importing() -> str:
    """The module that is being imported for its model just now, or ""."""
    return _importing[-1] if _importing else ""


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
