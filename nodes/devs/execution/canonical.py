"""Conversion of plain data, messages and objects of any class to bytes that contain no code, and back.

    scalar          None, bool, int of 64 bits, float, str, bytes: unchanged
    [kind, ...]     everything else, numbered from 0 in the order of first occurrence
    ["@", number]   a further reference to the same object, which preserves identity and cycles
    ["="]           in a message: the class's default, which the encoder omits

Objects are created without their `__init__`; their classes, functions and methods are looked up in the loaded modules:
foreign bytes can build nonsense but call no function. Functions and methods, which a model may call later, must be
those of models, or one of a few Python functions that only compute. Equal states with equal sharing have equal bytes:
attributes are sorted by name, sets by the bytes of their items. Generators, closures, open files and objects of foreign
machine code raise a TypeError.
"""

import functools
import sys
from collections import Counter, OrderedDict, defaultdict, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from enum import Enum
from random import Random
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Any

import msgspec
from heavylift.kernel.trust import written_by_user

_COMPUTING = {"math", "cmath", "operator", "collections", "fractions", "decimal", "datetime", "statistics"}
_BUILTIN = {  # beside the types
    "builtins": ("abs", "all", "any", "divmod", "len", "max", "min", "pow", "round", "sorted", "sum"),
    "io": ("open",),  # of a model that keeps a log
}
_SCALARS = (type(None), bool, float, str, bytes)
_DICTS: dict[type, str] = {dict: "dict", OrderedDict: "OrderedDict", Counter: "Counter", defaultdict: "defaultdict"}
_MADE_IN_PYTHON = 1 << 9  # a flag of such classes
_DEFAULT = "="
_OPEN = object()  # in place of what is being made of its parts


def frozen(value: object, around: Sequence[object] = ()) -> bytes:
    """Serialise a value to bytes, in which the objects in `around` are references; raises TypeError if impossible."""
    return msgspec.msgpack.encode(Freezer(around).fold(value))


def thawed(data: bytes, around: Sequence[object] = ()) -> Any:
    """Deserialise bytes from `frozen` with the same objects `around`; raises TypeError or LookupError if invalid."""
    return _Thawer(around).unfold(msgspec.msgpack.decode(data))


class Freezer:
    """Serialiser that writes each object once, and a numbered reference wherever the object occurs again."""

    def __init__(self, around: Sequence[object] = ()) -> None:
        self._met: list[object] = [*around]  # kept, so that no id is given twice
        self._numbers = {id(x): number for number, x in enumerate(around)}
        self._around = len(self._met)

    def forget(self) -> None:
        """Forget all objects met so far, so that the next value is serialised without references to earlier values."""
        while len(self._met) > self._around:
            del self._numbers[id(self._met.pop())]

    def fold(self, x: Any) -> object:
        """Convert a Python value into plain data for MessagePack; raises TypeError if some part cannot be saved."""
        kind = type(x)
        if kind in _SCALARS:
            return x
        if kind is int:
            return x if -(2**63) <= x < 2**63 else ["int", str(x)]
        number = self._numbers.get(id(x))
        if number is not None:
            return ["@", number]
        self._numbers[id(x)] = len(self._met)
        self._met.append(x)
        return list(self._parts(x, kind))

    def _all(self, items: Iterable[object]) -> Iterator[object]:
        return map(self.fold, items)

    def _parts(self, x: Any, kind: type) -> Iterator[object]:
        if kind in _DICTS:
            yield from (_DICTS[kind], self.fold(getattr(x, "default_factory", None)))
            for item in x.items():
                yield from self._all(item)
        elif kind in (set, frozenset):
            yield from (kind.__name__, *map(msgspec.Raw, sorted(map(frozen, x))))
        elif kind is deque:
            yield from ("deque", x.maxlen, *self._all(x))
        elif kind in (list, tuple):
            yield from (kind.__name__, *self._all(x))
        elif kind is bytearray:
            yield from ("bytearray", bytes(x))
        elif kind is Random:
            yield from ("Random", *self._all(x.getstate()))
        elif kind is MethodType:
            _method(x.__self__, x.__name__)
            yield from ("method", self.fold(x.__self__), x.__name__)
        elif isinstance(x, type | FunctionType | BuiltinFunctionType):
            yield from ("name", *_value(*_name(x)))
        elif isinstance(x, Enum):
            yield from ("enum", *_name(kind), x.name)
        elif isinstance(x, msgspec.Struct):
            fields = zip(x.__struct_fields__, _defaults(kind), strict=True)
            parts = ((getattr(x, name), default) for name, default in fields)
            yield from ("struct", *_name(kind), *([_DEFAULT] if v is default else self.fold(v) for v, default in parts))
        elif isinstance(x, tuple) and hasattr(kind, "_make"):
            yield from ("namedtuple", *_name(kind), *self._all(x))
        elif (kind.__module__, kind.__name__) == ("numpy", "ndarray") and not x.dtype.hasobject:
            yield from ("array", x.dtype.str, list(x.shape), x.tobytes())
        else:
            yield from self._object(x, kind)

    def _object(self, x: Any, kind: type) -> Iterator[object]:
        if not _plain(kind):
            raise TypeError(f"a {kind.__name__} cannot be saved in a snapshot")
        if hasattr(kind, "__setstate__"):
            _restoring(kind)
            yield from ("state", *_name(kind), self.fold(x.__getstate__()))
            return
        slots = (slot for base in kind.__mro__ for slot in getattr(base, "__slots__", ()))
        names = sorted({*getattr(x, "__dict__", ()), *(slot for slot in slots if hasattr(x, slot))} - {"__dict__"})
        yield from ("object", *_name(kind), names, *self._all(getattr(x, name) for name in names))


class _Thawer:
    def __init__(self, around: Sequence[object] = ()) -> None:
        self._made: list[object] = [*around]

    def unfold(self, x: Any) -> object:
        if type(x) is not list:
            return x
        kind, *rest = x
        if kind == "int":
            return int(rest[0])
        if kind == "@":
            made = self._made[rest[0]]
            if made is _OPEN:
                raise TypeError("a tuple or message that contains itself cannot be saved")
            return made
        number = len(self._made)
        self._made.append(_OPEN)
        self._made[number] = value = self._value(number, kind, rest)
        return value

    def _all(self, items: Iterable[object]) -> list[Any]:
        return [self.unfold(item) for item in items]

    def _value(self, number: int, kind: str, rest: list[Any]) -> Any:
        match kind:
            case "list" | "set" | "deque":
                return self._filled(number, kind, rest)
            case "dict" | "OrderedDict" | "Counter" | "defaultdict":
                return self._dict(number, kind, rest)
            case "tuple":
                return tuple(self._all(rest))
            case "frozenset":
                return frozenset(_Thawer().unfold(item) for item in rest)
            case "bytearray":
                return bytearray(bytes.join(b"", rest))
            case "Random":
                generator = Random(0)
                generator.setstate(tuple(self._all(rest)))
                return generator
            case "method":
                return _method(self.unfold(rest[0]), rest[1])
            case "name":
                return _named(*_value(*rest))
            case "enum":
                return _class(rest, lambda cls: issubclass(cls, Enum))[rest[2]]
            case "struct":
                struct = _class(rest, lambda cls: issubclass(cls, msgspec.Struct))
                fields = zip(struct.__struct_fields__, rest[2:], strict=True)
                return struct(**{name: self.unfold(part) for name, part in fields if part != [_DEFAULT]})
            case "namedtuple":
                return _class(rest, lambda cls: issubclass(cls, tuple) and hasattr(cls, "_make"))(*self._all(rest[2:]))
            case "array":
                import numpy as np  # whoever had one has it

                return np.frombuffer(rest[2], rest[0]).reshape(rest[1]).copy()
            case "state" | "object":
                return self._object(number, kind, rest)
        raise TypeError(f"{kind!r} is not a known type of saved values; take a new snapshot")

    def _filled(self, number: int, kind: str, rest: list[Any]) -> object:
        if kind == "set":
            return {_Thawer().unfold(item) for item in rest}
        made: list[object] | deque[object] = [] if kind == "list" else deque(maxlen=rest.pop(0))
        self._made[number] = made
        made.extend(self._all(rest))
        return made

    def _dict(self, number: int, kind: str, rest: list[Any]) -> Any:
        factory, *items = rest
        made: Any = next(t for t, name in _DICTS.items() if name == kind)()
        self._made[number] = made
        default = self.unfold(factory)
        if kind == "defaultdict":
            made.default_factory = default
        values = self._all(items)
        for key, value in zip(values[::2], values[1::2], strict=True):
            made[key] = value
        return made

    def _object(self, number: int, kind: str, rest: list[Any]) -> Any:
        self._made[number] = made = object.__new__(_class(rest, _plain))
        if kind == "state":
            _restoring(type(made))
            made.__setstate__(self.unfold(rest[2]))
            return made
        for name, value in zip(rest[2], self._all(rest[3:]), strict=True):
            object.__setattr__(made, name, value)
        return made


@functools.cache
def _defaults(cls: type[msgspec.Struct]) -> tuple[object, ...]:
    """Return the default value of each field; encoders omit a field only if its value is this very object, not merely
    equal to it."""
    defaults = cls.__struct_defaults__
    return (msgspec.NODEFAULT,) * (len(cls.__struct_fields__) - len(defaults)) + defaults


def _plain(cls: type) -> bool:
    """Return whether objects of a class consist of their attributes only and have no finaliser."""
    own: object = cls.__new__
    return bool(cls.__flags__ & _MADE_IN_PYTHON) and own is object.__new__ and not hasattr(cls, "__del__")


@functools.cache
def _of_models(module: str) -> bool:
    """Return whether a module may define models: it is part of heavylift's nodes or kernel, or written by the user."""
    if module.startswith("heavylift."):
        return module.startswith(("heavylift.nodes.", "heavylift.kernel."))
    return module == "__main__" or written_by_user(module)


def _value(module: str, name: str) -> tuple[str, str]:
    """Return module and name of a function or other named object; raises TypeError unless a model may hold it in its
    state and call it."""
    found = _named(module, name)
    own = _of_models(module) and getattr(found, "__module__", "") == module
    types = module in ("builtins", "numpy") and isinstance(found, type)
    computes = (module in _COMPUTING and "." not in name) or name in _BUILTIN.get(module, ())
    if isinstance(found, type | FunctionType | BuiltinFunctionType) and (own or types or computes):
        return module, name
    raise TypeError(f"{name} of {module} cannot be saved: it is not part of a model")


def _method(owner: object, name: str) -> object:
    """Return a bound method; raises TypeError unless it belongs to a model."""
    cls = owner if isinstance(owner, type) else type(owner)
    found = next((vars(base)[name] for base in cls.__mro__ if name in vars(base)), None)
    function = getattr(found, "__func__", found)
    if found is None or not isinstance(function, FunctionType) or not _of_models(function.__module__):
        raise TypeError(f"{name} of {cls.__name__} cannot be saved in a snapshot; use a method of the model instead")
    return found.__get__(None if owner is cls else owner, cls)


def _restoring(cls: Any) -> None:
    """Raise TypeError if a class has its own method for restoring its state, unless it is a class of a model."""
    if not _of_models(getattr(cls.__setstate__, "__module__", None) or ""):
        raise TypeError(f"a {cls.__name__} cannot be saved in a snapshot")


def _class(name: list[Any], fits: Callable[[type], bool]) -> Any:
    """Return the class with this module and name; raises TypeError if there is none or `fits` rejects it."""
    found = _named(*name[:2])
    if not isinstance(found, type) or not fits(found):
        raise TypeError(f"{name[1]} of {name[0]} is not a class whose values can be saved; take a new snapshot")
    return found


def _name(x: type | FunctionType | BuiltinFunctionType) -> tuple[str, str]:
    """Return module and qualified name of a class or function; raises TypeError if they do not lead back to it."""
    module, name = getattr(x, "__module__", None) or "", x.__qualname__
    if "<" in name or _found(module, name) is not x:
        raise TypeError(f"{name} cannot be saved: no module defines this name")
    return module, name


def _named(module: str, name: str) -> object:
    found = _found(module, name)
    if found is None:
        raise LookupError(f"{name} is not defined in {module}, or the module is not imported")
    return found


def _found(module: str, name: str) -> object:
    found = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    return found
