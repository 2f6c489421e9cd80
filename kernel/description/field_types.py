"""Type checks of a description: every field is converted to its annotated type, as tuples and plain Python numbers.

The annotations of the description modules are the schema. Lists, arrays and NumPy numbers become tuples and floats;
whatever does not fit raises one KernelError that names the item, the field and the expected type.

Also checks that every name by which one item refers to another exists exactly once.
"""

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from functools import cache
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import msgspec
import numpy as np
from heavylift.kernel.errors import KernelError, closest

from .contacts import Contact
from .laws import Lock
from .mechanics import GROUPS, WORLD, Drive, Joint, Measured, System, Threshold

LARGEST = 10**308  # a whole number that is still a float
SHOWN = 60  # characters of a wrong value in a sentence


def plain(system: System, known: Callable[[object], object | None]) -> System:
    """Return a description with tuples for arrays and Python numbers; raises KernelError for an invalid field.

    `known`: returns the plain form of an item that was converted before, else None.
    """
    if not isinstance(system, System):
        raise KernelError(f"the description is {_shown(system)}; it must be a System")
    groups: dict[str, Any] = {}
    for name, hint in _hints(System).items():
        value: object = getattr(system, name)
        if name == "gravity":
            groups[name] = _read(value, hint, name)
            continue
        item = get_args(hint)[0]
        if not isinstance(value, tuple | list):
            raise KernelError(f"{name} is {_shown(value)}; it must be {_wanted(hint)}")
        for x in value:
            if type(x) not in _classes(item):
                raise KernelError(f"{name}: {_shown(x)} is not allowed; it must be {_wanted(item)}")
            if not isinstance(x.name, str):
                raise KernelError(f"{item_word(x)} {_shown(x.name)}: name is {_shown(x.name)}; it must be a text")
        groups[name] = tuple(known(x) or _built(x, f"{item_word(x)} '{x.name}': ") for x in value)
    return replace(system, **groups)


def item_word(x: object) -> str:
    """Return the word for the type of a described item in messages, such as "joint" or "rope"."""
    kind = type(x).__name__
    return "spring" if kind == "JointSpring" else kind.lower()


def choice(choices: tuple[str | int, ...]) -> str:
    """Join alternatives to a phrase for messages: "a, b or c"."""
    return f"{', '.join(map(str, choices[:-1]))} or {choices[-1]}"


@cache
def field_names(kind: type[Any]) -> tuple[str, ...]:
    """Return the field names of a description class in their order; an empty tuple for other types."""
    if issubclass(kind, msgspec.Struct):
        return kind.__struct_fields__
    return tuple(f.name for f in fields(kind)) if is_dataclass(kind) else ()


def _built(x: Any, where: str) -> Any:
    """Return x with all fields converted; the same object if nothing changed."""
    hints = _hints(x.__class__)
    new = {}
    for name in field_names(x.__class__):
        value = getattr(x, name)
        read = _read(value, hints[name], f"{where}{name}")
        if read is not value:
            new[name] = read
    if not new:
        return x
    return msgspec.structs.replace(x, **new) if isinstance(x, msgspec.Struct) else replace(x, **new)


def _read(value: Any, hint: Any, where: str) -> Any:
    """Return a value converted to its annotated type."""
    if type(value) is hint and hint in (float, str, bool):  # as nearly all are
        return value
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    origin, inner = _taken_apart(hint)
    if origin in (Union, UnionType):
        found = next((h for h in inner if _is_class(h) and isinstance(value, h)), None)
        if found is None and value is not None:
            found = next((h for h in inner if get_origin(h) is tuple), None)
        good = found is not None or (value is None and type(None) in inner)
        if good and found is not None:
            return _read(value, found, where)
    elif origin is Literal:
        good = value in inner if isinstance(value, str | int) else False
    elif origin is tuple:
        good = isinstance(value, tuple | list) and (inner[-1] is Ellipsis or len(value) == len(inner))
        if good:
            each = [_read(x, inner[0], where) for x in value] if _fits(value, inner[0]) else None
            good = each is not None
            if each is not None:
                same = isinstance(value, tuple) and all(a is b for a, b in zip(each, value, strict=True))
                return value if same else tuple(each)
    elif hint is float:
        good = isinstance(value, float) or (isinstance(value, int) and abs(value) < LARGEST)
    elif hint is int:
        good = isinstance(value, int) and abs(value) < LARGEST
    elif hint is bool:
        good = isinstance(value, bool | int | float) and value in (False, True)
    elif is_dataclass(hint) or issubclass(hint, msgspec.Struct):
        good = isinstance(value, hint)
        if good:
            return _built(value, f"{where}.")
    else:
        good = isinstance(value, hint)
    if not good:
        raise KernelError(f"{where} is {_shown(value)}; it must be {_wanted(hint)}")
    return value


@cache
def _taken_apart(hint: Any) -> tuple[Any, tuple[Any, ...]]:
    """Return origin and arguments of an annotation."""
    return get_origin(hint), get_args(hint)


def _fits(values: Any, hint: Any) -> bool:
    """Return whether the elements of a matrix have the right kind; if not, messages refer to the whole matrix."""
    inner = get_args(hint)
    if get_origin(hint) is tuple:
        rows = all(isinstance(x, tuple | list | np.ndarray) for x in values)
        return rows and (inner[-1] is Ellipsis or all(len(x) == len(inner) for x in values))
    return hint is not float or all(isinstance(x, float | int | np.generic) for x in values)


def _wanted(hint: Any, many: bool = False) -> str:
    """Describe in words the values that an annotation allows; `many`: in the plural."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return choice(tuple("None" if h is type(None) else _wanted(h) for h in inner))
    if origin is Literal:
        return choice(inner)
    if origin is tuple:
        n = "" if inner[-1] is Ellipsis else f"{len(inner)} "
        if get_origin(inner[0]) is tuple:
            return f"{n}rows of {_wanted(inner[0])}"
        return f"{n}{_wanted(inner[0], many=True)}" if _is_class(inner[0]) else f"several, each {_wanted(inner[0])}"
    words = {float: "number", int: "whole number", str: "text", bool: "True or False"}
    if hint is bool:
        return words[bool]
    word = words.get(hint, getattr(hint, "__name__", str(hint)))
    return f"{word}s" if many else f"{'an' if word[0] in 'AEIOU' else 'a'} {word}"


def _shown(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= SHOWN else f"{text[: SHOWN - 3]}..."


def _is_class(hint: object) -> bool:
    return isinstance(hint, type) and get_origin(hint) is None


def _classes(hint: Any) -> tuple[type, ...]:
    return tuple(get_args(hint)) if get_origin(hint) in (Union, UnionType) else (hint,)


@cache
def _hints(kind: Any) -> dict[str, Any]:
    return get_type_hints(kind)


OF = {  # what a quantity is of, if not of a body
    **dict.fromkeys(("joint", "speed", "joint moment", "starting moment"), "joint"),
    "wind": "wind or other force",
}


def check_names(system: System) -> None:
    """Raise KernelError for the first reference of a system to a missing name, with the nearest known name."""
    known = {
        "body": [*(b.name for b in system.bodies), WORLD],
        "joint": [j.name for j in system.joints],
        "rope": [r.name for r in system.all_ropes],
        "wind or other force": [f.name for f in system.forces],
    }
    sets = {kind: set(names) for kind, names in known.items()}
    for x in (x for group in GROUPS for x in getattr(system, group)):
        for kind, name in _named(x):
            if name not in sets[kind]:
                near = closest(name, known[kind]) or f"the system has no {kind} at all"
                raise KernelError(f"{item_word(x)} '{x.name}': there is no {kind} '{name}'; {near}")


def _named(x: Any) -> Iterator[tuple[str, str]]:
    """Yield kind and name of each reference of an item."""
    match x:
        case Joint():
            yield from (("body", x.parent), ("body", x.child))
        case Lock() | Drive():
            yield "joint", x.joint
        case Contact():
            yield from (("body", x.a.body), ("body", x.b.body))
        case Measured():
            yield "joint" if x.kind == "joint" else "body", x.of
        case Threshold():
            yield from (("body", p.body) for p in (x.point, x.origin) if p)
            yield from (("rope", rope) for rope in x.ropes)
            if x.of:
                yield OF.get(x.quantity, "body"), x.of
        case _:
            yield from (("body", p.body) for p in getattr(x, "points", ()))
            if along := getattr(x, "along", None):
                yield "joint", along[0]
