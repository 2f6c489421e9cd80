"""The keys of `interlocks:` of a scene or a machine type: what stops a machine by itself.

interlocks:
  overload: {when: moment of crawler main >= 100 %, stops: [hoist, luff out]}     luffing in and lowering stay free
  apart: {when: gap west east <= 3 m, stops: [travel], towards: true}             moving apart stays free
  gust: {when: wind >= 20 m/s, stops: all, deceleration: 0.1 m/s2, until: wind <= 15 m/s}
"""

from __future__ import annotations

from typing import Literal

from heavylift.nodes.scene.text import units as u
from pydantic import Field, model_validator

from .actions import Condition
from .base import Base


class Interlock(Base):
    """A measured quantity at which a machine stops some of its motions, and lets them go again where it is back."""

    when: Condition  # `moment of main >= 100 %`; of `any hook`: each of the machine is watched
    stops: Literal["all"] | list[str] = Field(default_factory=list)  # verbs, or `luff out`, `slew left`
    until: Condition | None = None  # where it is reset; left out: 3 % behind, of heights 0.1 m
    on: str | list[str] = ""  # machines that have it; left out: all of them
    towards: bool = False  # of a gap: what moves apart stays free
    deceleration: u.Ramp | None = None  # of what slides or hoists; left out: its `emergency`
    tells: str = ""  # a sentence for the verdict, with or without stopping

    @model_validator(mode="after")
    def _does(self) -> Interlock:
        if not self.stops and not self.tells:
            raise ValueError("an interlock stops something, or tells something: add 'stops' or 'tells'")
        return self
