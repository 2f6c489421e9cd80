"""Isolation of the models of a node: all other models are copies that never run, and that raise an error when a model
accesses them.

Each process builds the whole model and runs its own children. A model that reads the state of others, or changes the
structure around them, is refused with an error that names the access; everything that stays fixed during a run (names,
paths, plain values of the parent) may be read. Children that share a process must not notice it: children that hold no
common objects come from one build, each of the others from a build of its own; plain data that several of them have as
attributes are copied instead.

Global variables that methods of several children use, also in functions that they call, must not change, since each
process has a copy. They are compared by their canonical bytes; variables without canonical bytes are not checked.
"""

import gc
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from copy import deepcopy
from enum import Enum
from functools import cache
from types import CodeType, FunctionType, MethodType, ModuleType
from typing import NoReturn
from weakref import ref

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Coupled, In, Message, Model, Out, Port
from heavylift.nodes.devs.execution.flatten import tree
from heavylift.nodes.devs.execution.rules import image
from heavylift.nodes.devs.models import Present, out_of_reach

_FIXED = {"__class__", "_path", "name", "parent", "path"}
_STRUCTURE = {*vars(Coupled), *vars(Model), "children", "ports"} - _FIXED
_PLAIN = (bool, int, float, str, bytes, type(None), Enum, Message)
_STILL = (*_PLAIN, complex, frozenset, tuple, type, ModuleType, CodeType, FunctionType, MethodType, Port, Model)

Reach = Callable[[Model, str], object]
_ghosts: dict[tuple[type, Reach], type] = {}


def secluded(root: Coupled, names: Sequence[str], build: Callable[[], Coupled]) -> list[Model]:
    """Return children of the root, isolated from all other models; each child that shares objects with others is built
    anew."""
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
    """Return the children that share mutable objects with, or refer to, another child."""
    first = {id(x): child.name for child in children for x in tree(child)}  # who has a thing
    found: dict[str, None] = {}
    for child in children if len(children) > 1 else ():
        held = _held(child)
        if _common(child, held, first):
            copied = _copied(child)
            held = _held(child)
            if _common(child, held, first):
                found[child.name] = None
                for attributes, key, x in copied:
                    attributes[key] = x
                held = _held(child)
        for x in held:
            first.setdefault(id(x), child.name)
    return list(found)


def _common(child: Model, held: Sequence[object], first: Mapping[int, str]) -> bool:
    """Return whether an earlier child also holds any of these objects; `first`: the first owner of each object."""
    return any(first.get(id(x), child.name) != child.name for x in held)


def _copied(child: Model) -> list[tuple[dict[str, object], str, object]]:
    """Replace plain data in the attributes of a child by copies; return what was replaced."""
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
    """Return whether a copy of `x` is equivalent: plain data without sets, whose order may change."""
    kind = type(x)
    if kind is dict:
        return all(_data(key) and _data(each) for key, each in x.items())  # type: ignore[attr-defined]
    if kind in (list, tuple):
        return all(map(_data, x))  # type: ignore[call-overload]
    return isinstance(x, _PLAIN) or kind is bytearray


def _held(child: Model) -> list[object]:
    """Return the mutable objects and models that a child refers to, except code and classes."""
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
        if _frozen(x):
            ahead += vars(x).values() if hasattr(x, "__dict__") else gc.get_referents(x)
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


def _frozen(x: object) -> bool:
    """Return whether an object is of a frozen dataclass, so that it can change only if an object that it refers to
    changes."""
    return bool(getattr(getattr(type(x), "__dataclass_params__", None), "frozen", False))


def _close(model: Model) -> None:
    for x in tree(model):
        x.__class__ = _ghost(type(x), _of_sibling)


def _ghost(cls: type, get: Reach) -> type:
    """Return a class of the same layout whose attributes are read through `get` and cannot be written."""
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


_CODE = (ModuleType, FunctionType, type, staticmethod, classmethod, property, In, Out)
_Place = tuple[str, dict[str, object], str]  # full name; the variables of its module or class; its own


class Commons:
    """Guard for the global variables that several children of a model use: no transition may change their values."""

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
        """Raise ModelError if a guarded global variable has changed.

        Unless `now`, only calls whose number is a power of two check.
        """
        self._asked += 1
        if not now and self._asked & (self._asked - 1):
            return
        if self._asked == 1:
            for full, (around, name) in sorted(self._all.items()):
                if _holds_model(around.get(name)):
                    raise ModelError(
                        f"{self._by(full)} may use the global variable {full}, which refers to a model of "
                        "this process while the other models run elsewhere; communicate by messages instead"
                    )
        for full, (around, name) in self._places.items():
            message = image(around.get(name))
            if self._known.setdefault(full, message) != message:
                raise ModelError(
                    f"{self._by(full)} use the global variable {full}, which has changed, although each process "
                    "has its own copy; store it in attributes of a model and send it to others in messages"
                )

    def _by(self, full: str) -> str:
        return ", ".join(f"{self._root}.{name}" for name in sorted(self._users[full])[:3])


@cache
def _named(cls: type) -> list[_Place]:
    """Return the global variables named by the code of a class, its bases and the functions they call."""
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
