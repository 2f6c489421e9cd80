"""The verdict of a run: everything that was found, and one line that is green or red.

history     what was shown: poses, tensions, rope lines over time
conduct     what was said: stages, limits, an operator's words, the end
clearances  how near things came to one another, by
            distance: of two shapes at one pose; nearest: over time; moving, rotating: how far they stray
            between samples; intervals, shape_batch: which pairs and times need a closer look
ground      and how near to the ground
limits      worst values of all limits, for the report
worst_corners  clearances at the worst corner of uncertain inputs
judging     all judges in one table, and the line

    judge(plan, history, conduct)  at the end of a run; `prepare` before it saves time there
    verdict_of(recording)          as it stands there, or made again where it is missing
"""

from typing import TYPE_CHECKING

from heavylift.kernel.on_demand import face, on_demand

if TYPE_CHECKING:
    from .judging import verdict_of, verdict_of_run

__all__ = ["prepare", "verdict_of", "verdict_of_run"]
__getattr__ = on_demand(__name__)


def prepare() -> None:
    """Import in advance the modules that the verdict needs, to save time at the end of a run."""
    from . import judging  # noqa: F401


face(__name__)
