"""What the keys of mechanisms and forces have in common: names, places, directions, ends."""

from __future__ import annotations

from typing import Annotated

from heavylift.nodes.scene.text.units import Length, Number
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict

__all__ = ["Base", "Direction", "End", "Name", "Place", "Quaternion", "Station", "written"]


def _named(word: str) -> str:
    if not word or not word.isascii() or not (word[0].isalpha() or word[0] == "_"):
        raise ValueError(f"a name begins with a letter, unlike '{word}'")
    bad = next((c for c in word if not (c.isalnum() or c in "_-")), "")
    if bad:
        raise ValueError(f"a name has letters, digits, '-' and '_' only, but '{word}' has '{bad}'")
    return word


Name = Annotated[str, AfterValidator(_named)]
Place = tuple[Length, Length, Length]
# one length is a place along x, the axis of beams
Station = Annotated[Place, BeforeValidator(lambda x: (x, 0.0, 0.0) if isinstance(x, str) else x)]
Direction = tuple[Number, Number, Number]
Quaternion = tuple[Number, Number, Number, Number]


def written(name: str) -> str:
    """A key as it stands in YAML."""
    return name.replace("off_lead", "off-lead").replace("_", " ")


class Base(BaseModel):
    """Frozen; unknown keys are errors; underscores of Python are blanks in YAML."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        populate_by_name=True,
        alias_generator=written,
    )


class End(Base):
    """A point of a body."""

    body: str
    at: Station = (0.0, 0.0, 0.0)
