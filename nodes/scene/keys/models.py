"""The key `models` of a scene: models of a user's own that run beside the kernel, each as a node.

models:
  damper:
    model: anti_sway.py:Damper                      in the folder of the scene; or module:name, or unit.fmu
    period: 100 ms                                  of samples
    signals: {swing: swing along of fall-1}         in port: what it hears
    orders: {speed: trolley}                        out port: the drive or winch that its set-points lead
    parameters: {gain: 12 m/s}                      quantities arrive in SI units
"""

from __future__ import annotations

import re
from typing import Annotated

from heavylift.nodes.scene.text import units as u
from pydantic import BeforeValidator, Field

from .base import Base, Name

__all__ = ["OwnModel"]

TEXT = re.compile(rf"{u.NUMBER}\s*\D.*")


def _parameter(given: object) -> object:
    """A quantity as its number in SI units; other text, numbers and truth values as they are."""
    if isinstance(given, str) and TEXT.fullmatch(given):
        for dimension in u.DIMENSIONS:
            if u.tidy(re.sub(rf"^{u.NUMBER}\s*", "", given)) in dimension.units:
                return dimension.read(given)
    if isinstance(given, int) and not isinstance(given, bool):
        return float(given)
    return given


Parameter = Annotated[float | bool | str, BeforeValidator(_parameter)]


class OwnModel(Base):
    """A model: the samples that it hears, the orders that it gives; `delay`: so much later its set-points arrive."""

    model: str  # module:name, or file.py:name or unit.fmu in the folder of the scene
    period: u.Duration  # of samples; of a unit of FMI its step
    delay: u.Delay = 0.0  # 0: each sample costs a round of messages more
    signals: dict[Name, str] = Field(default_factory=dict)  # in port: what it hears, such as `height of block`
    orders: dict[Name, str] = Field(default_factory=dict)  # out port: the drive or winch that its set-points lead
    parameters: dict[str, Parameter] = Field(default_factory=dict)  # quantities arrive in SI units
