"""A figure of curves over time as plain data: panels of one unit each."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

__all__ = ["Curve", "Figure", "Panel"]


@dataclass
class Curve:
    """Times (n,) [s] and values (n,) in the unit of its panel; the line is dashed for a second recording."""

    name: str
    t: NDArray[np.float64]
    y: NDArray[np.float64]
    dashed: bool = False


@dataclass
class Panel:
    """Curves of one unit, and limits by name of what they belong to."""

    unit: str
    curves: list[Curve]
    limits: dict[str, float] = field(default_factory=dict)
    title: str = ""


@dataclass
class Figure:
    """Panels with a common time; stages are (start [s], name)."""

    title: str
    panels: list[Panel]
    stages: list[tuple[float, str]]
