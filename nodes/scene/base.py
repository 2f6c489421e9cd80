"""What the keys of mechanisms and forces have in common: names, places, directions, ends."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict

from .units import Length, Number

__all__ = ["Base", "Direction", "End", "Name", "Place", "Quaternion"]


def _named(word: str) -> str:
    if not word or not word.isascii() or not (word[0].isalpha() or word[0] == "_"):
        raise ValueError(f"a name begins with a letter, unlike '{word}'")
    bad = next((c for c in word if not (c.isalnum() or c in "_-")), "")
    if bad:
        raise ValueError(f"a name has letters, digits, '-' and '_' only, but '{word}' has '{bad}'")
    return word


Name = Annotated[str, AfterValidator(_named)]
Place = tuple[Length, Length, Length]
Direction = tuple[Number, Number, Number]
Quaternion = tuple[Number, Number, Number, Number]


class Base(BaseModel):
    """Frozen; unknown keys are errors; underscores of Python are blanks in YAML."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        populate_by_name=True,
        alias_generator=lambda name: name.replace("_", " "),
    )


class End(Base):
    """A point of a body."""

    body: str
    at: Place = (0.0, 0.0, 0.0)
