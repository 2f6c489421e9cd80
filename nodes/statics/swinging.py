"""Ramps that leave no swing: for each such move, the swing periods when it begins and when it stops.

The action list is followed statically. Where such a move begins to change its speed, the vibration modes about the
equilibrium are computed. The mode used is the one with the widest swing of the moved bodies: the largest |sum d . p|^2
/ w^4, where w is the mode's frequency, d are the displacements of the bodies along the move and p their momenta in the
mode. So the period depends on the present positions of ropes, hook, beam and block, and not on stiff servos. Periods
are rounded to five digits, to which LAPACK's eigenvalues agree on every processor.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isclose
from typing import TYPE_CHECKING

import msgspec
from heavylift.kernel.cache import remembered
from heavylift.nodes.plan import plan, pulses
from heavylift.nodes.plan.actions import Move
from heavylift.nodes.plan.verbs import VERBS

from .static_path import at_rest, plan_key

if TYPE_CHECKING:
    from heavylift.kernel.analysis.modes import Modes

    from .listening import At, MoveModes
    from .state import StaticState

PASSES = 4  # times that a list is followed until the periods are those of the moves with them
SAME = 1e-3  # relative change of a period that makes no difference to what is left
FAINT = 1e-3  # part of the largest momentum, squared, below which a mode does not count
STILL = 1e-3  # [kg] of which that is made, or [m] of a way, that is none
ALONG = {"x": 0, "y": 1}


class RampTiming(msgspec.Struct, frozen=True):
    """Swing periods [s] at the beginning of a move and at its stop, and the time between these instants [s].

    `why`: reason why there are no periods, or ""."""

    periods: tuple[float, float] = (0.0, 0.0)
    between: float = 0.0
    why: str = ""


def swing_free(built: plan.Plan, keep: bool = True) -> tuple[plan.Plan, list[tuple[str, str]]]:
    """Return the plan with the swing periods of its swing-free ramps, and errors for moves without a period.

    Each error is (place in the scene, sentence). A move that does not take place before the scene ends keeps its
    provisional acceleration."""
    orders = ((i, k, x) for i, action in enumerate(built.actions) for k, x in enumerate(action.orders))
    moves = {(i, k): x for i, k, x in orders if isinstance(x, Move) and x.pulses}
    if not moves:
        return built, []
    found = _chosen(built, moves, keep)
    wrong = {moves[at].where: f"{moves[at].actuator}: {x.why}" for at, x in found.items() if x.why}
    return _with(built, found), list(wrong.items())


def _chosen(built: plan.Plan, moves: Mapping[At, Move], keep: bool) -> dict[At, RampTiming]:
    """Return the swing periods of the moves, from the cache if possible."""
    whole = at_rest(built)
    if not keep:
        return _sought(whole, moves)
    return remembered(f"{plan_key(whole)}.swings", dict[tuple[int, int], RampTiming], lambda: _sought(whole, moves))


def _sought(whole: plan.Plan, moves: Mapping[At, Move]) -> dict[At, RampTiming]:
    """Return the swing periods of the moves, found by iteration: the periods depend on the times of the moves, which
    depend on the periods."""
    # a first guess of one second, just to have definite durations
    found = _listened(_with(whole, dict.fromkeys(moves, RampTiming((1.0, 1.0)))), moves)
    for _ in range(PASSES - 1):
        if any(x.why for x in found.values()) or all(_near(*x.periods) for x in found.values()):
            break
        before, found = found, _listened(_with(whole, found), moves)
        # periods depend on rope lengths when moves begin, and those times on the periods
        if all(_near(a, b) for at, x in found.items() for a, b in zip(before[at].periods, x.periods, strict=True)):
            break
    return found


def _near(a: float, b: float) -> bool:
    return isclose(a, b, rel_tol=SAME)


def _with(built: plan.Plan, found: Mapping[At, RampTiming]) -> plan.Plan:
    """Return the plan with these swing periods in its moves."""
    actions = tuple(
        msgspec.structs.replace(
            action,
            orders=tuple(
                _move(x, found.get((i, k), RampTiming()), built.gravity) if isinstance(x, Move) and x.pulses else x
                for k, x in enumerate(action.orders)
            ),
        )
        for i, action in enumerate(built.actions)
    )
    return msgspec.structs.replace(built, actions=actions)


def _move(m: Move, x: RampTiming, gravity: float) -> Move:
    if not x.periods[0]:
        return msgspec.structs.replace(m, pulses=0)
    speed, (first, last) = abs(m.speed), x.periods
    accel = speed / first if m.pulses == 1 else m.accel
    # the period changes linearly with the rope length during the move, as far as that matters
    slope = (last - first) / x.between if x.between > 0.0 and not _near(first, last) else 0.0
    left = 0.0
    for period in x.periods if slope else ():
        # what remains of the swing because the ramp was designed for the period at its begin
        middle = period + 0.5 * slope * pulses.ramp(m.pulses, speed, accel, period)[-1][0]
        left += pulses.residual(m.pulses, speed, accel, period, middle, gravity)
    return msgspec.structs.replace(m, accel=accel, periods=x.periods, left=left)


def _listened(built: plan.Plan, moves: Mapping[At, Move]) -> dict[At, RampTiming]:
    """Return the swing periods of the moves, from following the action list statically."""
    from .listening import SignalsOnPath  # compiles, which what is kept does not need

    r = SignalsOnPath(built, frozenset(moves))
    r.walk()
    found, why = {}, r.why or (r.cut if built.end is None else "")
    for at, move in moves.items():
        heard = r.heard.get(at)
        if heard is not None:
            found[at] = _choice(heard, _displacements(move, r.states, heard.times[0]))
        elif why:
            found[at] = RampTiming(why=f"no length is known for this ramp, write an acceleration: {why}")
    return found


def _displacements(move: Move, states: list[StaticState], begun: int) -> dict[str, list[float]]:
    """Return the displacement of each body along a move that begins at the state with index `begun`, scaled so that the
    largest is 1; empty if none moves."""
    # the state when the move begins, and the first one after which it has gone some way
    at = [x for x in states if x.t <= begun * 1e-9][-1]
    went = (x for x in states if abs(x.references[move.actuator] - at.references[move.actuator]) > STILL)
    later = next((x for x in went if x.t > at.t), at)
    axis = ALONG.get(VERBS[move.verb].along)
    counts = [axis in (None, i) for i in range(3)]
    distances = {
        body: [(q - p) * x for p, q, x in zip(pose[0], later.poses[body][0], counts, strict=True)]
        for body, pose in at.poses.items()
    }
    longest = max(abs(x) for distance in distances.values() for x in distance)
    return {body: [x / longest for x in distance] for body, distance in distances.items()} if longest else {}


def _choice(heard: MoveModes, ways: Mapping[str, list[float]]) -> RampTiming:
    periods = [_period(modes, ways) for modes in heard.modes]
    if not all(periods):
        return RampTiming(why="nothing swings that it moves: write an acceleration after 'ramp'")
    return RampTiming((periods[0], periods[-1]), (heard.times[-1] - heard.times[0]) * 1e-9)


def _period(modes: Modes, ways: Mapping[str, list[float]]) -> float:
    """Return the period [s] of the mode with the largest motion along these displacements; 0 if there is none."""
    moved = []
    for mode in modes.oscillations:
        p = abs(
            sum(d * p for body, distance in ways.items() for d, p in zip(distance, mode.momenta[body], strict=True))
        )
        moved.append((p * p, mode.frequency))
    least = max([FAINT * max((p for p, _ in moved), default=0.0), STILL])
    # amplitude of a mode under a step of acceleration: momentum over frequency squared; compared squared
    swinging = [(p / (f * f * f * f), f) for p, f in moved if p > least]
    # five digits are equal on every processor
    return float(f"{1.0 / max(swinging)[1]:.5g}") if swinging else 0.0
