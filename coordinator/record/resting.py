"""What each rope of a recorded lift would carry at rest: tensions of the equilibrium path at the times of the run."""

import numpy as np
from heavylift.coordinator.verdict.conduct import conduct_of
from heavylift.kernel.errors import UNREADABLE, HeavyliftError
from heavylift.nodes.plan.plan import decode
from heavylift.nodes.statics import follow
from heavylift.recordings import Recording
from numpy.typing import NDArray

from .scene import RESOLVED

StaticTensions = tuple[NDArray[np.float64], NDArray[np.float64]]  # (n,) times [s], (n,) tensions at rest [N]


def at_rest(rec: Recording) -> dict[str, StaticTensions]:
    """Static tension of each rope along the action list; empty for a recording without a plan.

    The path knows when each action begins without inertia, the run when it did: between them time is stretched.
    """
    try:
        plan = decode(rec.attachments[RESOLVED])
        path = follow(plan)
    except (KeyError, HeavyliftError, *UNREADABLE):
        return {}
    began = {number: t for t, number, _ in reversed(conduct_of(rec).stages)}
    known = [(acted.t, began[i]) for i, acted in enumerate(path.acted) if i in began]
    if plan.lists or not known or not path.states:
        return {}
    ends = (path.states[-1].t, known[-1][1] + path.states[-1].t - known[-1][0])
    nominal, actual = np.array([*known, ends]).T
    t = np.interp([state.t for state in path.states], nominal, actual)
    ropes = path.states[0].tensions
    return {rope: (t, np.array([state.tensions[rope] for state in path.states])) for rope in ropes}
