"""What the keys of mechanisms and forces have in common: names, places, directions, ends; attitudes as matrices.

A direction or quaternion need not have length 1; what has no length stays as it is and is a fault elsewhere.
"""

from __future__ import annotations

import inspect
import re
from contextlib import suppress
from itertools import pairwise
from typing import Annotated, ClassVar, TypeVar, cast

from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.units import Matrix, Vector
from heavylift.nodes.plan.spellings import BEAMS
from heavylift.nodes.scene.text.units import Length, Number
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict


def _named(word: str) -> str:
    if not word or not word.isascii() or not (word[0].isalpha() or word[0] == "_"):
        raise ValueError(f"a name begins with a letter from a to z, unlike '{word}'")
    bad = next((c for c in word if not (c.isalnum() or c in "_-")), "")
    if bad:
        raise ValueError(f"a name has letters, digits, '-' and '_' only, but '{word}' has '{bad}'")
    return word


def part_name(name: str) -> str:
    """Check a part name with the prefix of its machine; raises ValueError otherwise."""
    return ".".join(_named(word) for word in name.split("."))


def rising(chart: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Check that a chart has increasing arguments; raises ValueError otherwise."""
    for (one, _), (next_, _) in pairwise(chart):
        if next_ <= one:
            raise ValueError(f"the places of a chart must increase, but {next_:g} m comes after {one:g} m")
    return chart


Name = Annotated[str, AfterValidator(_named)]
Place = tuple[Length, Length, Length]
# one length is a place along x, the axis of beams
Station = Annotated[Place, BeforeValidator(lambda x: (x, 0.0, 0.0) if isinstance(x, str) else x)]
Direction = tuple[Number, Number, Number]
Quaternion = tuple[Number, Number, Number, Number]


def written(name: str) -> str:
    """A key as written in YAML."""
    return BEAMS if name == "beams" else name.replace("off_lead", "off-lead").replace("_", " ")


class Base(BaseModel):
    """Frozen; unknown keys are errors; underscores of Python are blanks in YAML."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", populate_by_name=True, alias_generator=written, defer_build=True
    )  # deferred: one schema is built, that of the scene
    struct: ClassVar[type | None] = None  # the class whose fields are its keys, if there is one


class BodyPoint(Base):
    """A point of a body."""

    body: str
    at: Station = (0.0, 0.0, 0.0)


def comments(model: type[Base]) -> dict[str, str]:
    """Comments after the fields of a model, by key."""
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
    """The vector with length 1."""
    length = norm(vector) or 1.0
    return cast(Directed, tuple(x / length for x in vector))


def across(axis: Vector) -> Vector:
    """The x axis projected across an axis, or y if the axis is x."""
    a = unit(axis)
    e = Y if abs(a[0]) > 1.0 - 1e-9 else X
    along = sum(p * q for p, q in zip(a, e, strict=True))
    x, y, z = (p - along * q for p, q in zip(e, a, strict=True))
    return x, y, z


def turned(roll: float, pitch: float, yaw: float) -> Matrix:
    """R = Rz(yaw) Ry(pitch) Rx(roll); exact for quarter turns, which then cost nothing in compiled code."""
    (c, s), (d, t), (e, u) = ((_exact(cos(x)), _exact(sin(x))) for x in (roll, pitch, yaw))
    return (
        (e * d, e * t * s - u * c, e * t * c + u * s),
        (u * d, u * t * s + e * c, u * t * c - e * s),
        (0.0 - t, d * s, d * c),
    )


def quaternion_matrix(quaternion: Quaternion) -> Matrix:
    """Rotation matrix of a quaternion x y z w."""
    x, y, z, w = unit(quaternion)
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )


def _exact(x: float) -> float:
    return float(round(x)) if abs(x - round(x)) < EXACT else x


class ProjectKeys(Base):
    """Identification of the project for documents."""

    model_config = ConfigDict(coerce_numbers_to_str=True)
    name: str = ""
    number: str = ""
    author: str = ""  # who prepared it
    date: str = ""  # of this revision; left out: of the day
    revision: str = ""
