"""Globals that several children of a model use: each process has its own copy of them, so they must not change.

What counts is what the methods of two or more children name, also by way of the functions that they call: variables of
their modules and attributes of their classes.  They are compared by their bytes; what has none is not seen.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from types import CodeType, FunctionType, ModuleType

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Coupled, In, Model, Out
from heavylift.nodes.devs.execution.flatten import tree
from heavylift.nodes.devs.execution.purity import image

_CODE = (ModuleType, FunctionType, type, staticmethod, classmethod, property, In, Out)
_Place = tuple[str, dict[str, object], str]  # full name; the variables of its module or class; its own


class Commons:
    """Holds them to what they were when `unchanged` was asked first, before any work."""

    def __init__(self, root: Coupled) -> None:
        alike: dict[frozenset[type], list[str]] = {}
        for child in root.children.values():
            alike.setdefault(frozenset(map(type, tree(child))), []).append(child.name)
        users: dict[str, list[str]] = {}
        places: dict[str, tuple[dict[str, object], str]] = {}
        for classes, names in alike.items():
            for full, around, name in {x[0]: x for cls in classes for x in _named(cls)}.values():
                users.setdefault(full, []).extend(names)
                places[full] = around, name
        self._users, self._all = users, places
        self._places = {full: places[full] for full in sorted(users) if len(users[full]) > 1}
        self._root = root.path
        self._known: dict[str, bytes] = {}
        self._asked = 0

    def unchanged(self, now: bool) -> None:
        """ModelError names what has changed; looks `now`, or at every call whose number is a power of two."""
        self._asked += 1
        if not now and self._asked & (self._asked - 1):
            return
        if self._asked == 1:
            for full, (around, name) in sorted(self._all.items()):
                if _holds_model(around.get(name)):
                    raise ModelError(
                        f"{self._by(full)} may use {full}, which holds a model of this process, though the others run "
                        "elsewhere; send them messages"
                    )
        for full, (around, name) in self._places.items():
            told = image(around.get(name))
            if self._known.setdefault(full, told) != told:
                raise ModelError(
                    f"{self._by(full)} use {full}, which has changed, though each process has a copy of its own; keep "
                    "it in attributes and tell others by messages"
                )

    def _by(self, full: str) -> str:
        return ", ".join(f"{self._root}.{name}" for name in sorted(self._users[full])[:3])


@cache
def _named(cls: type) -> list[_Place]:
    """The variables that the code of a class, its bases and what they call names."""
    found: list[_Place] = []
    met: set[CodeType] = set()
    for base in cls.__mro__:
        if base.__module__.startswith("heavylift.") or base is object:
            continue
        for key, x in vars(base).items():
            function = getattr(x, "__func__", getattr(x, "fget", x))
            if isinstance(function, FunctionType):
                found += _globals(function.__code__, function.__globals__, met)
            elif not key.startswith("__") and not isinstance(x, _CODE):
                found.append((f"{base.__module__}.{base.__qualname__}.{key}", vars(base), key))  # type: ignore[arg-type]
    return found


def _globals(code: CodeType, around: dict[str, object], met: set[CodeType]) -> Iterator[_Place]:
    if code in met:
        return
    met.add(code)
    for name in code.co_names:
        x = around.get(name)
        if isinstance(x, FunctionType) and x.__module__ == around.get("__name__"):
            yield from _globals(x.__code__, x.__globals__, met)
        elif name in around and not isinstance(x, _CODE) and not name.startswith("__"):
            yield f"{around.get('__name__')}.{name}", around, name
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _globals(inner, around, met)


def _holds_model(x: object) -> bool:
    if isinstance(x, dict):
        x = [*x, *x.values()]
    return isinstance(x, Model) or (isinstance(x, list | tuple | set | frozenset) and any(map(_holds_model, x)))
