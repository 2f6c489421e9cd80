"""What a scene can ask, how the error of each answer is measured, and how large it may be.

rope tension    |peak - true peak| / true peak at the hook, of every hook rope
swing           of the block about what it hangs from: largest excursion, and frequency after the last move, relative;
                the frequency only if a tenth of the excursion is left
position        of the block as stages begin and at the end, relative to the longest way between two of them
lift-off time   |t - true t| / duration of the stage, or half a second if that is shorter
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

Asked = Literal["rope tension", "swing", "position", "lift-off time"]
ASKABLE: tuple[Asked, ...] = get_args(Asked)
USUAL = 1e-2  # accuracy of what is asked without one
SHORTEST = 0.5  # [s] so long counts a stage in which the block comes off sooner, or at once


@dataclass(frozen=True)
class Question:
    """Quantities, and the largest error of each that is accepted (0.01: 1 %)."""

    ask: tuple[Asked, ...]
    accuracy: float
