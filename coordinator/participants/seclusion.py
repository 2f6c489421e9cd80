"""In its node a child is alone: its siblings and their parent are copies that nothing moves, and say so when touched.

Each node builds the whole model and runs its own child.  What the others do happens elsewhere, so whoever reads their
state here, or changes the structure around it, is refused by name; what is fixed while a run lasts (names, paths, plain
values of the parent) may be read.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from types import FunctionType, MethodType
from typing import NoReturn

from heavylift.nodes.devs import Coupled, Message, Model
from heavylift.nodes.devs.models import out_of_reach

__all__ = ["secluded"]

_FIXED = {"__class__", "_path", "name", "parent", "path"}
_STRUCTURE = {*vars(Coupled), *vars(Model), "children", "ports"} - _FIXED
_PLAIN = (bool, int, float, str, bytes, type(None), Enum, Message)

Reach = Callable[[Model, str], object]
_ghosts: dict[tuple[type, Reach], type] = {}


def secluded(own: Model) -> None:
    """Let all models around this one, a child of the root, refuse to be used."""
    root = own.parent
    assert root is not None, "a node is a child"
    for sibling in root.children.values():
        if sibling is not own:
            _close(sibling)
    root.__class__ = _ghost(type(root), _of_parent)


def _close(model: Model) -> None:
    if isinstance(model, Coupled):
        for child in model.children.values():
            _close(child)
    model.__class__ = _ghost(type(model), _of_sibling)


def _ghost(cls: type, get: Reach) -> type:
    """A class of the same layout whose objects are reached by `get` only."""
    if (cls, get) not in _ghosts:
        refusing = {"__getattribute__": get, "__setattr__": _refuse, "__delattr__": _refuse}
        _ghosts[cls, get] = type(cls)(cls.__name__, (cls,), {"__slots__": (), "__module__": cls.__module__, **refusing})
    return _ghosts[cls, get]


def _of_sibling(model: Model, name: str) -> object:
    return object.__getattribute__(model, name) if name in _FIXED else _refuse(model, name)


def _of_parent(model: Model, name: str) -> object:
    if name in _STRUCTURE:
        return _refuse(model, name)
    found = object.__getattribute__(model, name)
    if name in _FIXED or isinstance(found, MethodType | FunctionType) or _plain(found):
        return found
    return _refuse(model, name)


def _plain(x: object) -> bool:
    return isinstance(x, _PLAIN) or (isinstance(x, tuple) and all(map(_plain, x)))


def _refuse(model: Model, name: str, *value: object) -> NoReturn:
    raise out_of_reach(model.path, name)
