"""What a scene can ask, how the error of each answer is measured, and how large it may be.

rope tension    |peak - true peak| / true peak, of every hook rope
swing           of the load after each move: error of its frequency and of its envelope, relative
position        of the block, relative to the longest way that it goes
lift-off time   |t - true t| / duration of the stage
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

__all__ = ["ASKABLE", "Asked", "Question"]

Asked = Literal["rope tension", "swing", "position", "lift-off time"]
ASKABLE: tuple[Asked, ...] = get_args(Asked)


@dataclass(frozen=True)
class Question:
    """Quantities, and the largest error of each that is accepted (0.01: 1 %)."""

    ask: tuple[Asked, ...]
    accuracy: float
