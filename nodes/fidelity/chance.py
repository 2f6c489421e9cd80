"""What two models of a lift may differ by, however little is between them; measured where nothing else explains it.

So much of an accuracy is set aside before anything is left out (`choose`); finer ones are not promised (`verdict`).
"""

from __future__ import annotations

from .case import Case
from .hooks import tipping
from .rules import AWAITED, SHAKEN, Errors, overshoot, shaken, slower

__all__ = ["FARTHEST", "chance", "unsure"]

CHANCE: Errors = {"rope tension": 2.5e-3, "swing": 0.0, "position": 5e-4, "lift-off time": 2e-3}  # measured
ASIDE: Errors = {"rope tension": 6e-3, "swing": 0.04, "position": 0.01, "lift-off time": 0.02}  # light or undamped
CORNERS = (
    4e-4,
    1.3e-3,
)  # [m] of excursion and place: corners on more than three hooks part one after the other; measured
PARTS = 0.015  # of the excursion, where such a block comes aside as they do; measured
UNEVEN = 0.003, 0.007  # [m] of place and excursion where corners part at different speeds; measured
LANDED: Errors = {
    "position": 3.5e-3,
    "lift-off time": 4e-3,
}  # slings that were slack come taut in another order; measured
RINGING = 0.015  # of the position, besides, where nothing damps the ropes of a block that lands; measured
SWINGING: Errors = {
    "rope tension": 0.013,
    "swing": 0.007,
    "position": 0.01,
    "lift-off time": 0.012,
}  # [1/m] of the swing in which a block lands: how hard, where and when, and how it parts again; measured
FARTHEST = 1.0  # [m] of such a swing: beyond, lifts were off by 9 %; measured
UNDAMPED = 0.13  # part of a bounce by which the sum of several may differ
LET_GO = 5e-3  # of the swing, whatever the steps: slings come off and on as a hook is taken from the load; measured


def unsure(case: Case) -> Errors:
    """What no number of lumps is sure of: how ropes bend, and in which phase they swing like strings."""
    errors = slower(case, 1)
    errors["rope tension"] += tipping(case.hooks) * shaken(case, errors, SHAKEN[1])
    return errors


def chance(case: Case) -> Errors:
    """What two models may differ by, however little is between them: by what is unsure; seldom, on more than three
    hooks, or where undamped ropes ring on as the block lands, by which of the pads is the last to open, in which bounce
    of the block; by slings that are let go; by when the block lands that swings; by the phases of bounces that nothing
    damps."""
    errors = unsure(case)
    errors["swing"] += LET_GO if case.changes else 0.0
    if case.awaits > AWAITED:
        errors = {q: errors.get(q, 0.0) + e * case.awaits for q, e in SWINGING.items()}
    if not case.determinate:
        errors["swing"] += CORNERS[0] / case.swings.least + PARTS * min(1.0, case.swings.jumps / case.swings.least)
        errors["position"] += CORNERS[1] / case.way
    if not case.even and len(case.hooks) > 2:
        errors["position"] += UNEVEN[0] / case.way
        errors["swing"] += UNEVEN[1] / case.swings.least
    if case.swings.lands:
        errors |= {q: errors.get(q, 0.0) + e for q, e in LANDED.items()}
        errors["position"] += 0.0 if case.damped else RINGING
    jumps = case.swings.jumps > 0.0
    if not case.damped:
        rings = UNDAMPED * (1.0 + jumps)
        errors["rope tension"] += rings * max(overshoot(case, h, girder=True) for h in case.hooks)
    aside = jumps and (not case.damped or (not case.determinate and any(h.light for h in case.hooks)))
    if aside or not case.determinate or (case.swings.lands and not case.damped):
        errors = {q: errors.get(q, 0.0) + (ASIDE if aside else CHANCE)[q] for q in ASIDE}
    return errors
