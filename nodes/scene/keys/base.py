"""Common elements of the keys of mechanisms and forces: names, places, directions, ends, and rotations as matrices.

A direction or quaternion need not have length 1; one of length 0 is kept unchanged and reported as an error by later
checks.

Keys can be generated from descriptions of the kernel or the plan, with their names, units, defaults and meanings:

    class Stop(keys_of(k.Stop, lower=one("range", Range, itemgetter(0)), upper=one("range", Range, itemgetter(1)))): ...

Each field becomes a key with the name of the field, or with the word in WORDS that stands for its symbol, in the unit
given by its annotation; `built` makes the description from the keys. Fields that are written differently are passed as
arguments.
"""

import inspect
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import MISSING, fields
from itertools import pairwise
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, TypeVar, cast, get_args, get_origin, get_type_hints

import msgspec
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.forces import InputSignal
from heavylift.kernel.description.units import Direction as UnitVector, Matrix, Point, Unit, Vector
from heavylift.nodes.scene.text import units as u
from heavylift.nodes.scene.text.units import Length, Number
from heavylift.recordings.format.spellings import BEAMS
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, create_model


def checked_name(word: str) -> str:
    """Return a name; raises ValueError unless it begins with a letter and has letters, digits, '-' and '_' only."""
    if not word or not word.isascii() or not (word[0].isalpha() or word[0] == "_"):
        raise ValueError(f"a name begins with a letter from a to z, unlike '{word}'")
    bad = next((c for c in word if not (c.isalnum() or c in "_-")), "")
    if bad:
        raise ValueError(f"a name has letters, digits, '-' and '_' only, but '{word}' has '{bad}'")
    return word


def part_name(name: str) -> str:
    """Return the name of a part, which may have the name of its machine as prefix; ValueError if invalid."""
    return ".".join(checked_name(word) for word in name.split("."))


def rising(chart: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return a chart unchanged; raises ValueError unless its arguments are in ascending order."""
    for (one, _), (next_, _) in pairwise(chart):
        if next_ <= one:
            raise ValueError(f"the places of a chart must increase, but {next_:g} m comes after {one:g} m")
    return chart


Name = Annotated[str, AfterValidator(checked_name)]
Place = tuple[Length, Length, Length]
# one length is a place along x, the axis of beams
Station = Annotated[Place, BeforeValidator(lambda x: (x, 0.0, 0.0) if isinstance(x, str) else x)]
Direction = tuple[Number, Number, Number]
Quaternion = tuple[Number, Number, Number, Number]


def written(name: str) -> str:
    """Return the name of a key as it is written in YAML."""
    return BEAMS if name == "beams" else name.replace("off_lead", "off-lead").replace("_", " ")


class Base(BaseModel):
    """Base class of all keys: immutable; unknown keys are errors; underscores in Python are spaces in YAML."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", populate_by_name=True, alias_generator=written, defer_build=True
    )  # deferred: one schema is built, that of the scene
    struct: ClassVar[type | None] = None  # the class whose fields are its keys, if there is one


class BodyPoint(Base):
    """A point on a body."""

    body: str
    at: Station = (0.0, 0.0, 0.0)


def comments(model: type[Base]) -> dict[str, str]:
    """Return the comments after the fields of a class of keys in its source code, by the name of the key."""
    text = inspect.getsource(model.struct) if model.struct else ""
    for kind in (kind for kind in reversed(model.__mro__) if issubclass(kind, Base)):
        with suppress(OSError):  # it is made of another
            text += inspect.getsource(kind)
    found = re.findall(r"^    (\w+): .*?  # (?!type:|\[)(.*)$", text, re.M)
    return {field.alias or name: comment for name, comment in found if (field := model.model_fields.get(name))}


Directed = TypeVar("Directed", Vector, Quaternion)
EXACT = 1e-15  # how far a sine may be from 0 or 1 by rounding
X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def unit(vector: Directed) -> Directed:
    """Return the vector scaled to length 1."""
    length = norm(vector) or 1.0
    return cast(Directed, tuple(x / length for x in vector))


def across(axis: Vector) -> Vector:
    """Return the x axis projected onto the plane perpendicular to an axis; if that axis is x, return the y axis."""
    a = unit(axis)
    e = Y if abs(a[0]) > 1.0 - 1e-9 else X
    along = sum(p * q for p, q in zip(a, e, strict=True))
    x, y, z = (p - along * q for p, q in zip(e, a, strict=True))
    return x, y, z


def turned(roll: float, pitch: float, yaw: float) -> Matrix:
    """Return the rotation matrix Rz(yaw) Ry(pitch) Rx(roll), exact for quarter turns."""
    (c, s), (d, t), (e, u) = ((_exact(cos(x)), _exact(sin(x))) for x in (roll, pitch, yaw))
    return (
        (e * d, e * t * s - u * c, e * t * c + u * s),
        (u * d, u * t * s + e * c, u * t * c - e * s),
        (0.0 - t, d * s, d * c),
    )


def quaternion_matrix(quaternion: Quaternion) -> Matrix:
    """Return the rotation matrix of a quaternion (x, y, z, w)."""
    x, y, z, w = unit(quaternion)
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )


def _exact(x: float) -> float:
    return float(round(x)) if abs(x - round(x)) < EXACT else x


class ProjectKeys(Base):
    """Identification of the project, shown in documents."""

    model_config = ConfigDict(coerce_numbers_to_str=True)
    name: str = ""
    number: str = ""
    author: str = ""  # who prepared it
    date: str = ""  # of this revision; left out: of the day
    revision: str = ""


WORDS = {  # for the symbols of laws
    "a": "start", "b": "end", "R_a": "start_attitude", "R_b": "end_attitude",
    "k": "stiffness", "d": "damping", "kt": "tangential_stiffness", "dt": "tangential_damping", "kp": "stiffness",
    "kv": "damping", "mu": "friction", "q_rest": "rest", "kind": "type",
}  # fmt: skip


class Spelling(NamedTuple):
    """How a field is written in a scene: the keys, and a function that computes the field's value from them."""

    keys: dict[str, tuple[Any, Any]]
    value: Callable[[Any], object]


def one(key: str, kind: Any, value: Callable[[Any], object] = lambda x: x, default: Any = ...) -> Spelling:
    """Return the spelling of a field that is written as one key; several fields may share the key."""
    return Spelling({key: (kind, default)}, lambda keys: value(getattr(keys, key)))


def history(value: str, pairs: str, kind: Any = u.Number, default: float = 1.0) -> Spelling:
    """Return the spelling of a signal that is written as a constant or as pairs of time and value."""

    def signal(keys: Any) -> InputSignal:
        times, values = zip(*getattr(keys, pairs), strict=True) if getattr(keys, pairs) else ((), ())
        return InputSignal(getattr(keys, value), times, values)

    return Spelling({value: (kind, default), pairs: (list[tuple[u.Instant, kind]], [])}, signal)


class Described(Base):
    """Base class of the key models that are generated from description classes of the kernel."""

    spelt: ClassVar[dict[str, Spelling]] = {}

    def built(self, *first: str, folder: Path | None = None, **other: Any) -> Any:
        """Return the kernel's description made from these keys.

        `first`, `other`: values of fields that are not keys; `folder`: folder of the files that keys name."""
        assert self.struct
        return self.struct(*first, **{field: spelling.value(self) for field, spelling in self.spelt.items()}, **other)

    @property
    def bodies(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """Yield each body that a key refers to, with the path of the key."""
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
    """Return a class of scene keys, one for each field of a description class except the fields in `without`.

    It has a key `type: word` if `word` is given. `module` distinguishes models of the same name; `otherwise`: fields
    with a spelling that is not the default."""
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
    """Return the default spelling of a field, which depends on its type."""
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
    """Return the annotation of a key: units become quantities, bounds become those of pydantic."""
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
