"""The verdict of a run: everything that was found, and one line that is green or red.

history     what was shown: poses, tensions, rope lines over time
conduct     what was said: stages, limits, an operator's words, the end
clearances  how near things came to one another, by
            distance: of two shapes at one pose; nearest: over time; moving, speeds, rotating: how far they stray
            between samples; coarse, stretches, steps, together: which pairs and times need a closer look
ground      and how near to the ground
limits      worst values of all limits, for the report
judging     all judges in one table, and the line

    judge(plan, history, conduct)  at the end of a run; `prepare` before it saves time there
    verdict_of(recording)          as it stands there, or made again where it is missing
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from heavylift.recordings import Recording
from heavylift.recordings.read.verdict import Judged

if TYPE_CHECKING:
    from heavylift.nodes.plan.plan import Plan

    from .conduct import Conduct
    from .history import Past

__all__ = ["judge", "prepare", "verdict_of"]


def prepare() -> None:
    """Import what a verdict needs, while there is nothing else to do."""
    import coal  # noqa: F401

    from . import judging  # noqa: F401


def judge(plan: Plan, history: Past, conduct: Conduct) -> Judged:
    """The verdict of a run."""
    from .judging import judge as made  # with the library of collisions: not before it is needed

    return made(plan, history, conduct)


def verdict_of(rec: Recording) -> Judged | None:
    """The verdict that a recording has, or made of what it holds; None if it is not of a scene of this version."""
    from .judging import verdict_of as found

    return found(rec)
