"""The verdict of a run: all findings, and a summary line that is green, amber, undecided or red.

history     poses, tensions and rope lines over time
conduct     events: stages, end positions, an operator's commands, the end
clearances  smallest distances between things, by
            distance: of two shapes at one pose; nearest: over time; moving, rotating: deviation between
            samples; intervals, shape_batch: pairs and times that need exact evaluation
ground      smallest distances from the ground
limits      columns of a run from which limits are checked
rigid_contacts  speeds at which blocks touch obstacles, the floor and each other
worst_corners  clearances at the worst corner of uncertain inputs
judging     all checks in one table, and the summary line

    judge(plan, history, conduct)  at the end of a run; `prepare` before it saves time there
    verdict_of(recording)          the recorded verdict, or one computed if it is missing
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
