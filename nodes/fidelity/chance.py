"""What ropes of lumps, or without their mass, are unsure of: how they bend and swing, and what is decided by little.

`between(case, model)` is what two lumps, four, or ropes without any may differ by from the truth; of four it is set
aside before anything is left out (`choose`), and finer accuracies are not promised (`verdict`).  The constants of
`CAUSES` were measured on lifts at random, against four lumps and eight (FIDELITY.md).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import pi, sqrt

from heavylift.kernel.algebra.dense import norm
from heavylift.nodes.plan.fidelity import Asked

from .case import Case
from .hooks import Hook, nodding, tipping

Errors = dict[Asked, float]
TWO, FOUR, WITHOUT = range(3)  # lumps of a rope
SLOWER = 0.015, 0.003, 0.05  # times the square of a rope's part of its load: error of the frequency
FASTER = 0.03, 0.006, 0.1  # the same of the block on its slings below hooks that swing the other way
SHAKEN = (0.3, 0.5, 0.5), (0.1, 0.2, 0.15), (2.0, 1.0, 1.4)  # of what strings shake: swing, place, inclination
SHAKEN_LIGHT = (0.5, 0.8, 0.5), (0.4, 1.2, 0.15), (2.0, 1.0, 1.4)  # the same on hooks that swing with their ropes
LET_FREE = 0.3  # of the first, with the hook for the load: as a block is let go aside of its hooks
PULLED = 0.5  # of the mass between rope and slings: a rope so heavy swings with its hook
ROCKS = 0.045  # [m]
AWAITED = 0.005  # swing in which an event is awaited that decides nothing [m]
FARTHEST = 1.0  # [m] of such a swing: beyond, lifts were off by 9 %


@dataclass(frozen=True)
class Cause:
    """What is decided by little: how much of it a lift has; per unit of that the relative errors of what is asked, and
    those in metres of the largest excursion and of the place: of four lumps, and what two and none add to them."""

    amount: Callable[[Case], float]
    relative: dict[Asked, tuple[float, float, float]] = field(default_factory=dict)
    metres: dict[Asked, tuple[float, float, float]] = field(default_factory=dict)


def _corners(case: Case) -> float:
    """On more than three hooks the corners of a block part one after the other."""
    return 0.0 if case.determinate else 1.0


def _uneven(case: Case) -> float:
    """Likewise where three hooks or more go at different speeds."""
    return 0.0 if case.even or len(case.hooks) < 3 else 1.0


def _aside(case: Case) -> float:
    """A load that is let go aside of its hooks [m]."""
    return case.swings.jumps


def _lands(case: Case) -> float:
    """Slings that were slack come taut in another order."""
    return 1.0 if case.swings.lands else 0.0


def _awaits(case: Case) -> float:
    """A block that swings lands harder or softer, sooner or later, and elsewhere [m]."""
    return case.awaits if case.awaits > AWAITED else 0.0


def _bounces(case: Case) -> float:
    """Bounces that nothing damps ring on together, in phases that nobody knows: their size relative to the load."""
    return 0.0 if case.damped else max(overshoot(case, h, girder=True) for h in case.hooks)


def _slides(case: Case) -> float:
    """A load let go aside of two hooks slides: which of two stools alike it leaves first turns it or does not."""
    return 1.0 if case.mirrored and case.swings.jumps and len(case.hooks) == 2 else 0.0


def _aside_bouncing(case: Case) -> float:
    return 0.0 if case.damped else _aside(case)


def _awaits_bouncing(case: Case) -> float:
    return 0.0 if case.damped else _awaits(case)


def _lands_bouncing(case: Case) -> float:
    return 0.0 if case.damped else _lands(case)


def _pulled_along(case: Case) -> float:
    """A load that is let go aside pulls along hooks that are hardly heavier than their ropes."""
    beside = max(_beside(h) for h in case.hooks)
    return min(1.0, beside) if case.swings.jumps and beside > PULLED else 0.0


def lightly_hooked(case: Case) -> bool:
    """Whether hooks are hardly heavier than their ropes."""
    return any(_beside(h) > PULLED for h in case.hooks)


def _lands_light(case: Case) -> float:
    return _lands(case) if lightly_hooked(case) else 0.0


def _changes(case: Case) -> float:
    """Slings come off, and ropes recoil, as a hook is taken from the load."""
    return 1.0 if case.recoils else 0.0


CAUSES = (
    Cause(
        _corners,
        {"rope tension": (0.0, 4e-4, 0.0), "lift-off time": (0.0, 2e-4, 0.0)},
        {"swing": (0.0, 2e-5, 0.0), "position": (0.0, 1e-4, 0.0)},
    ),
    Cause(_uneven, metres={"swing": (0.0, 5e-5, 0.0), "position": (0.0, 2e-4, 0.0)}),
    Cause(
        _aside,
        {"lift-off time": (2e-3, 1e-3, 5e-3)},
        {"swing": (2e-3, 1e-4, 4e-3), "position": (2e-3, 1e-4, 0.015)},
    ),
    Cause(
        _pulled_along,
        {
            "rope tension": (5e-3, 0.013, 0.02),
            "swing": (0.03, 8e-3, 0.045),
            "position": (0.02, 0.018, 0.09),
            "lift-off time": (0.0, 0.026, 0.0),
        },
    ),
    Cause(_changes, {"rope tension": (5e-4, 5e-4, 0.05), "swing": (5e-3, 0.025, 0.09)}),
    Cause(
        _lands,
        {"rope tension": (0.0, 0.0, 2e-3), "lift-off time": (0.0, 5e-4, 0.0)},
        {"swing": (5e-5, 5e-5, 2e-4), "position": (3e-4, 5e-4, 3e-3)},
    ),
    Cause(
        _lands_light,
        {"rope tension": (5e-3, 0.0, 0.01), "lift-off time": (0.025, 0.05, 0.04)},
        {"swing": (2e-4, 2e-4, 2e-4), "position": (0.0, 0.015, 0.0)},
    ),
    Cause(
        _awaits,
        {"rope tension": (0.0, 1e-3, 2e-3), "swing": (0.0, 3e-3, 3e-3), "lift-off time": (0.0, 4e-3, 0.01)},
        {"position": (0.0, 4e-3, 2e-3)},
    ),
    Cause(
        _bounces,
        {
            "rope tension": (0.2, 0.13, 0.35),
            "swing": (0.0, 0.02, 0.1),
            "position": (0.01, 0.0, 0.04),
            "lift-off time": (0.0, 0.01, 0.15),
        },
        {"swing": (0.0, 3e-3, 0.0), "position": (0.0, 0.04, 0.0)},
    ),
    Cause(_slides, {"rope tension": (0.0, 7e-3, 0.0), "swing": (0.0, 0.065, 0.0), "position": (0.0, 0.012, 0.0)}),
    Cause(
        _aside_bouncing,
        {"rope tension": (0.0, 0.05, 0.0), "swing": (0.04, 0.06, 0.04), "position": (0.0, 0.035, 0.0)},
    ),
    Cause(
        _lands_bouncing,
        {"rope tension": (0.0, 0.03, 0.0)},
        {"swing": (3e-4, 1e-4, 1.5e-3), "position": (0.0, 1e-3, 2e-3)},
    ),
    Cause(
        _awaits_bouncing,
        {"rope tension": (0.01, 0.01, 0.04), "lift-off time": (0.01, 0.01, 0.04)},
        {"position": (0.01, 0.01, 0.1)},
    ),
)


def _beside(h: Hook) -> float:
    """A rope's mass over that of its hook."""
    return h.rope_mass / (h.load - h.share)


def between(case: Case, model: int) -> Errors:
    """What ropes of four lumps may be wrong by, or two and none besides: frequencies of swings, how strings shake the
    load, and what little decides."""
    errors = _slower(case, model)
    inclined = _shaken(case, errors, (SHAKEN_LIGHT if lightly_hooked(case) else SHAKEN)[model])
    errors["rope tension"] = tipped(case, errors["swing"]) + tipping(case.hooks) * inclined
    for cause in CAUSES:
        if amount := cause.amount(case):
            for q, of in cause.relative.items():
                errors[q] += amount * of[model]
            for q, of in cause.metres.items():
                way = case.swings.least if q == "swing" else case.way
                errors[q] += amount * of[model] / way
    return errors


def chance(case: Case) -> Errors:
    """What the richest rung may be wrong by."""
    return between(case, FOUR)


def overshoot(case: Case, h: Hook, girder: bool) -> float:
    """Largest phi - 1: the block parts from its stools at the speed v, the winch halts and starts with a: of a linear
    oscillator at most k sqrt(v^2 + (a / w)^2) / w from the first, m a from the stop, 2 m a from the start, or what all
    moves of the list together make it; w: of the slowest hook, for a block on several pitches and rolls."""
    w = min(x.omega(girder) for x in case.hooks)
    parting = norm([h.picks, h.ramp / w]) / w / h.soft(girder)
    return parting / h.load / case.gravity + max(2.0 * h.ramp / case.gravity, h.rings)


def _slower(case: Case, model: int) -> Errors:
    """Errors by the frequencies of both swings of a double pendulum.
    On more than three hooks the block is lifted by one corner after the other, and rocks whatever moves it; let go
    aside it swings against its hooks, beside which ropes weigh more than beside the load."""
    heavy = max(h.rope_mass / h.load for h in case.hooks)
    beside = max(_beside(h) for h in case.hooks)
    slower, faster = heavy * heavy * SLOWER[model], heavy * heavy * FASTER[model]
    errors = swung(case, slower)
    omegas, moved, let_go = zip(*(nodding(h, case.gravity) for h in case.hooks), strict=True)
    turns = max(omegas) * case.lasts
    nods = max(moved) * case.swings.shaken((min(omegas), max(omegas))) + (0.0 if case.determinate else ROCKS)
    free = max(let_go) * case.swings.jumps * min(2.0, LET_FREE * beside * beside * SLOWER[model] * turns)
    errors["swing"] += free / case.swings.least
    errors["position"] += (free + nods * min(2.0, faster * turns)) / case.way
    return errors


def _shaken(case: Case, errors: Errors, times: tuple[float, float, float]) -> float:
    """How far ropes are inclined that swing like strings as their trolleys move; adds how they shake the load: the
    first mode, of amplitude A, is inclined by pi A / l and has a frequency of pi sqrt(m g / m_r l)."""
    heavy = max(h.rope_mass / h.load for h in case.hooks)
    omegas = [pi * sqrt(case.gravity * h.load / h.rope_mass / h.length) for h in case.hooks]
    amplitude = 2.0 / pi * case.swings.shaken((min(omegas), max(omegas)))
    errors["swing"] += times[0] * amplitude * heavy / pi / case.swings.least
    errors["position"] += times[1] * amplitude * heavy / pi / case.way
    return times[2] * pi * amplitude / min(h.length for h in case.hooks)


def swung(case: Case, shift: float) -> Errors:
    """Errors of the swing, of the place, and of what the swing is of the tension, for one of the frequency."""
    swing = shift * case.swings.envelope
    place = shift * case.swings.away / case.way
    return {"swing": swing, "position": place, "rope tension": tipped(case, swing), "lift-off time": 0.0}


def tipped(case: Case, swing: float) -> float:
    """Error of a hook's tension for one of the swing: it inclines the ropes, and hooks ahead carry more."""
    inclined = case.swings.most / min(h.reach for h in case.hooks)
    return swing * inclined * (tipping(case.hooks) + 2.0 * inclined)
