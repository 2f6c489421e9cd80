"""Where the steps of a run were long and where short, from its recording.

A run of which rope tensions alone were asked takes long steps along the equilibrium path where it may, and short ones
that follow every motion where it must; its recording counts them.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from heavylift.recordings.format.text import duration

from .reader import Recording

STEPS = "steps"  # the signal: taken so far
LONG = 0.1  # [s] a step: no method that follows every motion takes longer ones
PATH, MOTION = "along the equilibrium path", "every motion followed"


class Pace(NamedTuple):
    """From when to when [s] steps were long, or short."""

    start: float
    end: float
    long: bool

    @property
    def name(self) -> str:
        """What such steps follow."""
        return PATH if self.long else MOTION


def paces(rec: Recording) -> list[Pace]:
    """Where steps were long and where short, one after the other; empty for a recording that does not count them."""
    if STEPS not in rec.signals():
        return []
    t, taken = rec.signal(STEPS).t, rec.signal(STEPS).values[:, 0]
    later = np.flatnonzero(np.diff(t) > 0.0)  # an event has a row beside the sample at its instant
    long = (taken[later + 1] - taken[later]) * LONG < t[later + 1] - t[later]
    first = np.flatnonzero(np.diff(long, prepend=~long[:1]))
    starts = [*t[later[first]].tolist(), float(t[-1])]
    return [Pace(a, b, bool(long[i])) for (a, b), i in zip(pairwise(starts), first, strict=True)]


def followed(found: Sequence[Pace]) -> str:
    """For how long of all of that every motion was followed, in words; empty where nothing is known."""
    short = sum(p.end - p.start for p in found if not p.long)
    return f"every motion for {duration(short)} of {duration(found[-1].end)}" if found else ""
