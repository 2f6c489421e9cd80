"""A figure of curves over time as plain data: panels of one unit each."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

__all__ = ["Curve", "Figure", "Panel"]


@dataclass
class Curve:
    """Times (n,) [s] and values (n,) in the unit of its panel; the line is dashed for a second recording, and for what
    was measured, in the colour of the curve whose name `like` is."""

    name: str
    t: NDArray[np.float64]
    y: NDArray[np.float64]
    dashed: bool = False
    like: str = ""


@dataclass
class Panel:
    """Curves of one unit, and limits by name of what they belong to."""

    unit: str
    curves: list[Curve]
    limits: dict[str, float] = field(default_factory=dict)
    title: str = ""

    def colours(self) -> list[int]:
        """Number of the colour of each curve."""
        numbers = accumulate((not curve.like for curve in self.curves), initial=0)
        of = [number for number, _ in zip(numbers, self.curves, strict=False)]
        first = {
            curve.name: number for number, curve in reversed([*zip(of, self.curves, strict=True)]) if not curve.like
        }
        return [first.get(curve.like, number) for number, curve in zip(of, self.curves, strict=True)]


@dataclass
class Figure:
    """Panels with a common time; stages are (start [s], name)."""

    title: str
    panels: list[Panel]
    stages: list[tuple[float, str]]
