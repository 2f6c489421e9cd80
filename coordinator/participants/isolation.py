"""In its node a child is alone: the models around it are copies that nothing moves, and say so when touched.

Each process builds the whole model and runs its own children.  What the others do happens elsewhere, so whoever reads
their state here, or changes the structure around them, is refused by name; what is fixed while a run lasts (names,
paths, plain values of the parent) may be read.  Children that share a process must not notice that: those that hold
nothing of each other come from one build, each of the others from one of its own; lists and dicts of plain data that
several have as attributes, such as settings, are copied instead.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Collection, Mapping, Sequence
from copy import deepcopy
from enum import Enum
from types import CodeType, FunctionType, MethodType, ModuleType
from typing import NoReturn
from weakref import ref

from heavylift.nodes.devs import Coupled, Message, Model, Port
from heavylift.nodes.devs.execution.flatten import tree
from heavylift.nodes.devs.models import Present, out_of_reach

_FIXED = {"__class__", "_path", "name", "parent", "path"}
_STRUCTURE = {*vars(Coupled), *vars(Model), "children", "ports"} - _FIXED
_PLAIN = (bool, int, float, str, bytes, type(None), Enum, Message)
_STILL = (*_PLAIN, complex, frozenset, tuple, type, ModuleType, CodeType, FunctionType, MethodType, Port, Model)

Reach = Callable[[Model, str], object]
_ghosts: dict[tuple[type, Reach], type] = {}


def secluded(root: Coupled, names: Sequence[str], build: Callable[[], Coupled]) -> list[Model]:
    """The children of these names, around which all models refuse to be used; `build` makes the root once more."""
    bound = _bound([root.children[name] for name in names])
    own = {name: root.children[name] for name in names if name not in bound}
    _seclude(root, own)
    for name in bound:
        another = build()
        own[name] = another.children[name]
        _seclude(another, [name])
    return [own[name] for name in names]


def _seclude(root: Coupled, own: Collection[str]) -> None:
    for name, child in root.children.items():
        if name not in own:
            _close(child)
    root.__class__ = _ghost(type(root), _of_parent)


def _bound(children: Sequence[Model]) -> list[str]:
    """Who of these holds another one, or something that can change and one before it holds, too."""
    first = {id(x): child.name for child in children for x in tree(child)}  # who has a thing
    found: dict[str, None] = {}
    for child in children if len(children) > 1 else ():
        if _common(child, first):
            copied = _copied(child)
            if _common(child, first):
                found[child.name] = None
                for attributes, key, x in copied:
                    attributes[key] = x
        first |= {id(x): first.get(id(x), child.name) for x in _held(child)}
    return list(found)


def _common(child: Model, first: Mapping[int, str]) -> bool:
    """Whether a child holds what one before it holds, too."""
    return any(first.get(id(x), child.name) != child.name for x in _held(child))


def _copied(child: Model) -> list[tuple[dict[str, object], str, object]]:
    """Give a child copies of the plain data among its attributes, and return what was there."""
    memo: dict[int, object] = {}
    found = [
        (vars(x), key, data)
        for x in tree(child)
        for key, data in vars(x).items()
        if key not in _STRUCTURE and not isinstance(data, _PLAIN) and _data(data)
    ]
    for attributes, key, data in found:
        attributes[key] = deepcopy(data, memo)
    return found


def _data(x: object) -> bool:
    """Whether a copy of it is as good: no sets, for a copy may have another order."""
    kind = type(x)
    if kind is dict:
        return all(_data(key) and _data(each) for key, each in x.items())  # type: ignore[attr-defined]
    if kind in (list, tuple):
        return all(map(_data, x))  # type: ignore[call-overload]
    return isinstance(x, _PLAIN) or kind is bytearray


def _held(child: Model) -> list[object]:
    """What a child refers to and can change, and models beside it; not what code and classes do."""
    own = {id(x) for x in tree(child)}
    found, met, ahead = list[object](), set[int](), list[object]([child])
    while ahead:
        x = ahead.pop()
        if id(x) in met or x is child.parent or isinstance(x, type | ModuleType | CodeType | Present):
            continue
        met.add(id(x))
        if isinstance(x, Model) and id(x) not in own:
            found.append(x)
            continue
        if not isinstance(x, _STILL):
            found.append(x)
        if isinstance(x, FunctionType):
            ahead += (x.__closure__, x.__defaults__, x.__kwdefaults__)
        elif isinstance(x, ref):
            ahead.append(x())
        else:
            ahead += gc.get_referents(x)
    return found


def _close(model: Model) -> None:
    for x in tree(model):
        x.__class__ = _ghost(type(x), _of_sibling)


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
