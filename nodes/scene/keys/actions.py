"""The keys of an action (its condition, and an order for each of its targets, both in the phrase language), and the
keys under `interlocks:` of a scene or a machine type.

interlocks:
  overload: {when: moment of crawler main >= 100 %, stops: [hoist, luff out]}     luffing in and lowering stay free
  apart: {when: gap west east <= 3 m, stops: [travel], towards: true}             moving apart stays free
  gust: {when: wind >= 20 m/s, stops: all, deceleration: 0.1 m/s2, until: wind <= 15 m/s}
"""

from collections.abc import Callable
from typing import Annotated, Literal

from heavylift.nodes.scene.language.grammar import read_condition, read_order
from heavylift.nodes.scene.language.phrases import ConditionPhrase, OrderPhrase, PhraseError
from heavylift.nodes.scene.text import units as u
from heavylift.nodes.scene.text.units import Duration
from pydantic import BaseModel, ConfigDict, Field, PlainValidator, WithJsonSchema, model_validator
from pydantic_core import PydanticCustomError

from .base import Base


def _phrase(read: Callable[[str], object], needed: str) -> PlainValidator:
    def reads(text: object) -> object:
        if not isinstance(text, str):
            raise ValueError(f"write {needed}")
        try:
            return read(text)
        except PhraseError as error:
            context = {"sentence": str(error), "hint": error.hint, "column": error.column}
            raise PydanticCustomError("phrase", "{sentence}", context) from None

    return PlainValidator(reads)


_TEXT = WithJsonSchema({"type": "string"})
Order = Annotated[OrderPhrase, _phrase(read_order, "what to do, such as 'hoist 3 m/min by 2 m'"), _TEXT]
Condition = Annotated[ConditionPhrase, _phrase(read_condition, "a condition, such as 'all slings taut'"), _TEXT]

Touching = list[tuple[str, str]]  # pairs of things that may touch each other


class ActionLine(BaseModel):
    """One action in the action list, written as `target: order` for any number of targets at once."""

    model_config = ConfigDict(frozen=True, extra="allow")
    __pydantic_extra__: dict[str, Order] = Field(init=False)

    stage: str = ""
    when: Condition | None = None
    timeout: Duration | None = None
    may_touch: Touching = Field(default_factory=list, alias="may touch")  # besides those of the whole scene

    @model_validator(mode="before")
    @classmethod
    def _wait(cls, data: object) -> object:
        if isinstance(data, str) and data.split()[:1] == ["wait"]:
            return {"wait": data}
        if isinstance(data, dict):
            wait = data.get("wait")
            if isinstance(wait, str | int | float) and not str(wait).startswith("wait"):
                return data | {"wait": f"wait {wait}"}
        return data

    @property
    def orders(self) -> dict[str, OrderPhrase]:
        """The orders of an action line, by target."""
        return dict(self.__pydantic_extra__)


class InterlockKeys(Base):
    """Keys of an interlock: a measured quantity, its value at which motions of a machine stop, and a reset value."""

    when: Condition  # `moment of main >= 100 %`; of `any hook`: each of the machine is watched
    stops: Literal["all"] | list[str] = Field(default_factory=list)  # verbs, or `luff out`, `slew left`
    until: Condition | None = None  # where it is reset; left out: 3 % behind, of heights 0.1 m
    on: str | list[str] = ""  # machines that have it; left out: all of them
    towards: bool = False  # of a gap: what moves apart stays free
    deceleration: u.Ramp | None = None  # of what slides or hoists; left out: its `emergency`
    tells: str = ""  # a sentence for the verdict, with or without stopping

    @model_validator(mode="after")
    def _does(self) -> "InterlockKeys":
        if not self.stops and not self.tells:
            raise ValueError("an interlock needs an effect: add 'stops' or 'tells'")
        return self
