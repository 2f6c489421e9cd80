"""The keys of what the kernel or the plan describes, made of that description: names, units, defaults, meanings.

    class Stop(keys_of(k.Stop, lower=one("range", Range, itemgetter(0)), upper=one("range", Range, itemgetter(1)))):
        \"\"\"End stops of a joint.\"\"\"

Each field is a key of its name, or of the word for its symbol in WORDS, in the unit that its annotation names; `built`
makes the description from the keys.  What is written otherwise is an argument.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import MISSING, fields
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, get_args, get_origin, get_type_hints

import msgspec
from heavylift.kernel.description.forces import InputSignal
from heavylift.kernel.description.units import Direction as UnitVector, Matrix, Point, Unit
from heavylift.nodes.scene.text import units as u
from pydantic import Field, create_model

from .base import Base, BodyPoint, Direction, Quaternion, Station, quaternion_matrix, unit

WORDS = {  # for the symbols of laws
    "a": "start", "b": "end", "R_a": "start_attitude", "R_b": "end_attitude",
    "k": "stiffness", "d": "damping", "kt": "tangential_stiffness", "dt": "tangential_damping", "kp": "stiffness",
    "kv": "damping", "mu": "friction", "q_rest": "rest", "kind": "type",
}  # fmt: skip


class Spelling(NamedTuple):
    """Representation of a field: its keys with annotation and default, and its value from them."""

    keys: dict[str, tuple[Any, Any]]
    value: Callable[[Any], object]


def one(key: str, kind: Any, value: Callable[[Any], object] = lambda x: x, default: Any = ...) -> Spelling:
    """A field written as one key, possibly shared by several fields."""
    return Spelling({key: (kind, default)}, lambda keys: value(getattr(keys, key)))


def history(value: str, pairs: str, kind: Any = u.Number, default: float = 1.0) -> Spelling:
    """A signal, written as a constant and as pairs of time and value."""

    def signal(keys: Any) -> InputSignal:
        times, values = zip(*getattr(keys, pairs), strict=True) if getattr(keys, pairs) else ((), ())
        return InputSignal(getattr(keys, value), times, values)

    return Spelling({value: (kind, default), pairs: (list[tuple[u.Instant, kind]], [])}, signal)


class Described(Base):
    """Keys of an element that is described elsewhere."""

    spelt: ClassVar[dict[str, Spelling]] = {}

    def built(self, *first: str, folder: Path | None = None, **other: Any) -> Any:
        """The description with its `first` fields and `other` ones that are not keys; `folder`: of files that it
        names."""
        assert self.struct
        return self.struct(*first, **{field: spelling.value(self) for field, spelling in self.spelt.items()}, **other)

    @property
    def bodies(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """Bodies that it refers to, with the keys."""
        for key in type(self).model_fields:
            match getattr(self, key):
                case str(body) if key in ("body", "start", "end"):
                    yield (key,), body
                case BodyPoint(body=body):
                    yield (key, "body"), body
                case [*ends]:
                    yield from (
                        ((key, i, "body"), end.body) for i, end in enumerate(ends) if isinstance(end, BodyPoint)
                    )


def keys_of(kind: Any, *without: str, word: str = "", module: str = __name__, **otherwise: Spelling) -> Any:
    """A model whose keys are the fields of a class, except `without`, plus `type: word` if given; `module`
    distinguishes equal names."""
    hints, spelt = get_type_hints(kind, include_extras=True), dict[str, Spelling]()
    for field in msgspec.structs.fields(kind) if issubclass(kind, msgspec.Struct) else fields(kind):
        if field.name not in {"name", *without}:
            default = ... if field.default in (MISSING, msgspec.NODEFAULT) else field.default
            spelt[field.name] = otherwise.get(field.name) or _spelling(field.name, hints[field.name], default)
    keys = {"type": (Literal[word], ...)} if word else {}
    for spelling in spelt.values():
        keys |= spelling.keys
    about = (kind.__doc__ or "").partition("\n\n")[0].partition(": ")[0].rstrip(".") + "."
    model: Any = create_model(kind.__name__, __base__=Described, __doc__=about, __module__=module, **keys)  # type: ignore[call-overload]
    model.struct, model.spelt = kind, spelt
    return model


def _spelling(name: str, kind: Any, default: Any) -> Spelling:
    """Default representation of a field by its type."""
    key, inner = WORDS.get(name, name), get_args(kind)
    if kind is Point and name in ("at", "point"):
        keys = {"body": (str, ...), "at": (Station, (0.0, 0.0, 0.0))}
        return Spelling(keys, lambda x: Point(x.body, x.at))
    if kind is InputSignal:
        return history("factor", "history")
    if kind == Matrix:
        return one(key, Quaternion, quaternion_matrix, (0.0, 0.0, 0.0, 1.0))
    if kind == UnitVector:
        return one(key, Direction, unit, default)
    if get_origin(kind) is tuple and inner[-1] is Ellipsis:
        default = default if default is ... else [*default]
        return one(key, list[_read(inner[0])], lambda x: tuple(map(_plain, x)), default)  # type: ignore[misc]
    return one(key, _read(kind), _plain, default)


def _plain(value: object) -> object:
    return Point(value.body, value.at) if isinstance(value, BodyPoint) else value


def _read(kind: Any) -> Any:
    """The annotation of a key: units as quantities, bounds as in pydantic."""
    inner = get_args(kind)
    if kind is Point:
        return BodyPoint
    if get_origin(kind) is tuple:
        return tuple[tuple(map(_read, inner))]  # type: ignore[misc]
    if NoneType in inner:
        return _read(inner[0]) | None
    match inner:
        case (number, Unit(dimension, least)):
            return Annotated[number, u.Quantity(u.NAMED[dimension], least)]
        case (number, msgspec.Meta(ge=ge, le=le)):
            return Annotated[number, Field(ge=ge, le=le)]
    return kind
