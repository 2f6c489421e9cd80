"""Relative heave: how far a hook rises and sinks over a vessel while its winch stands."""

from itertools import pairwise

import numpy as np
from heavylift.nodes.plan.limit import RatedLimit
from heavylift.nodes.plan.plan import Plan

from .named import hooks_of
from .signals import Column, SignalColumns, place

STANDS = 1e-9  # [m] between two samples of a rope whose winch stands


def relative_heave(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Column | None:
    """Return the distance (n,) [m] between the highest and the lowest place of a hook, along the z axis of a vessel,
    since its winch stopped; None if data are missing. The winch may have stopped in an earlier part of the run."""
    rope, vessel = limit.elements
    eye, length = place(signals, hooks_of(plan.machines)[rope].eye), signals.lengths.get(rope)
    if eye is None or length is None or vessel not in signals.poses or not signals.dynamic:
        return None
    p, R = signals.poses[vessel]
    z = np.einsum("ni,ni->n", R[:, :, 2], eye - p)
    values = np.zeros(len(z))
    low, high = signals.carried.get((rope, vessel), (np.inf, -np.inf))
    ends = [0, *(np.flatnonzero(np.abs(np.diff(length)) > STANDS) + 1).tolist(), len(z)]
    for a, b in pairwise(ends):
        lowest = np.minimum(np.minimum.accumulate(z[a:b]), low)
        highest = np.maximum(np.maximum.accumulate(z[a:b]), high)
        values[a:b] = highest - lowest
        low, high = np.inf, -np.inf
        if b == len(z) > a:
            signals.carried[rope, vessel] = float(lowest[-1]), float(highest[-1])
    return values
