"""How a load answers the whole action list, by linear theory: one oscillator, integrated exactly from knot to knot.

    u'' + 2 z w u' + w^2 u = -r''     u: from its rest r [m]

The rest moves with what the load hangs from, in ramps of constant acceleration a, and jumps where the load is let go
off-lead or a hook is taken from it.  Between two knots (u, u' / w) goes round -a / w^2, on a circle or a spiral.
One oscillator is the pendulum along the rails, one across; one is a load up and down on its hook.

No frequency is known before the equations are solved: answers are those of all that it may be.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import groupby
from math import fsum, pi, sqrt

from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.elementary import cos, exp, sin

KNOWN = 0.05  # relative uncertainty of a frequency from lengths alone
PLACES = 25  # at which it is tried
STEP = 1e-3  # relative, of a frequency: for derivatives
OVERDAMPED = 0.9  # part of the critical damping above which more changes little
FADED = 60.0  # exponent behind which nothing is left
STILL = 1e-6  # excursion of nothing that moves [m]
Omegas = tuple[float, float]  # lowest and highest that it may be [rad/s]


@dataclass(frozen=True, order=True)
class Knot:
    """At t [s] the rest accelerates by so much more [m/s2], jumps [m], or the load stands still there."""

    t: float
    accel: float = 0.0
    jump: float = 0.0
    stands: bool = False


@dataclass(frozen=True)
class Answer:
    """Largest distance from the rest [m], and the place at each of the times asked [m], after it the size [m]."""

    largest: float
    at: tuple[float, ...]
    sizes: tuple[float, ...]


def moved(t: float, way: float, ramping: float, cruising: float) -> Iterator[Knot]:
    """A move of the rest from t on: two ramps and a cruise; a jump where it takes no time."""
    if ramping <= 0.0:
        yield Knot(t, jump=way)
        return
    a = way / (ramping * (ramping + cruising))
    yield from (Knot(t, a), Knot(t + ramping, -a))
    yield from (Knot(t + ramping + cruising, -a), Knot(t + 2.0 * ramping + cruising, a))


def together(knots: Iterable[Knot]) -> tuple[Knot, ...]:
    """Knots in order, those of one time as one."""
    times = ((t, list(same)) for t, same in groupby(sorted(knots), lambda knot: knot.t))
    return tuple(
        Knot(t, fsum(k.accel for k in same), fsum(k.jump for k in same), any(k.stands for k in same))
        for t, same in times
    )


def answer(knots: Sequence[Knot], w: float, damping: float = 0.0, times: Sequence[float] = ()) -> Answer:
    """Of an oscillator at rest before the first knot; where it is just before each of `times`, which are in order."""
    return _answered(tuple(knots), w, damping, tuple(times))


@lru_cache(maxsize=4096)  # a scene is looked at more than once
def _answered(knots: tuple[Knot, ...], w: float, damping: float, times: tuple[float, ...]) -> Answer:
    marks = [(t, False, Knot(t)) for t in times]
    x = v = rest = largest = 0.0  # v: speed over w
    damping = min(damping, OVERDAMPED)
    slows = sqrt(1.0 - damping * damping)
    places, sizes, now = list[float](), list[float](), 0.0
    for t, moves, knot in sorted([*((k.t, True, k) for k in knots), *marks]):
        out, angle = x - rest, w * (t - now)
        fades = exp(-min(FADED, damping * angle)) if damping else 1.0
        c, s = cos(slows * angle), sin(slows * angle) / slows
        ends = out * c + (v + damping * out) * s, v * c - (out + damping * v) * s
        largest = max(largest, _farthest(out, v, rest, angle, ends))
        x, v = rest + fades * ends[0], fades * ends[1]
        now = t
        if not moves:
            places.append(x)
            sizes.append(norm((x, v)))
        else:
            rest -= knot.accel / (w * w)
            x, v = (0.0, 0.0) if knot.stands else (x - knot.jump, v)
    largest = max(largest, abs(rest) + norm((x - rest, v)))
    return Answer(largest, tuple(places), tuple(sizes))


def frequencies(omegas: Omegas) -> Iterator[float]:
    """All that a frequency may be."""
    low, high = omegas[0] * (1.0 - KNOWN), omegas[1] * (1.0 + KNOWN)
    for i in range(PLACES):
        yield low + (high - low) * i / (PLACES - 1)


def _farthest(x: float, v: float, middle: float, turned: float, ends: tuple[float, float]) -> float:
    """From the rest, on an arc about `middle` that begins at (x, v) from there, turns by an angle and ends so."""
    crosses = (v >= 0.0) != (ends[1] >= 0.0)
    first, second = (1.0, -1.0) if v >= 0.0 else (-1.0, 1.0)  # sides on which it is farthest, in the order passed
    passed = [first] if crosses or turned >= pi else []
    passed += [second] if turned >= 2.0 * pi or (turned >= pi and not crosses) else []
    radius = norm((x, v))
    return max([abs(middle + x), abs(middle + ends[0]), *(abs(middle + side * radius) for side in passed)])


@dataclass(frozen=True)
class Swings:
    """The load as a pendulum: knots along the rails and across, frequencies that it may have, when stages begin."""

    knots: tuple[tuple[Knot, ...], tuple[Knot, ...]]
    omegas: Omegas
    begins: tuple[float, ...]

    @cached_property
    def _tried(self) -> list[list[tuple[Answer, Answer]]]:
        """For each frequency and each axis the answers a little below it and a little above."""
        moving = [knots for knots in self.knots if knots]
        return [
            [(answer(k, w - STEP * w, 0.0, self.begins), answer(k, w + STEP * w, 0.0, self.begins)) for k in moving]
            for w in frequencies(self.omegas)
        ]

    @cached_property
    def least(self) -> float:
        """How far the load swings out at least [m]; where nothing moves, as far as a jump to 1 cm/s2 would."""
        found = min(max((low.largest for low, _ in axes), default=0.0) for axes in self._tried)
        return found if found > STILL else 0.01 / (self.omegas[1] * self.omegas[1])

    @cached_property
    def most(self) -> float:
        """How far the load swings out at most [m]."""
        return max(sum(low.largest for low, _ in axes) for axes in self._tried)

    @cached_property
    def envelope(self) -> float:
        """Relative error of the largest excursion or of the frequency, whichever is more, for one of the frequency."""
        return max([2.0, *(_slope(axes) for axes in self._tried if axes)])

    @cached_property
    def away(self) -> float:
        """Error of the load's place as stages begin for a relative error of the frequency [m]."""
        return max(sum(_drift(low, high) for low, high in axes) for axes in self._tried)

    @property
    def jumps(self) -> float:
        """How far the load is let go aside, and as hooks are taken from it, in all [m]."""
        return fsum(abs(knot.jump) for knots in self.knots for knot in knots)

    @property
    def lands(self) -> bool:
        """Whether the load stands again after it has hung."""
        return any(knot.stands for knots in self.knots for knot in knots)

    def shaken(self, omegas: Omegas) -> float:
        """How far something of such frequencies swings as the load is moved, but for jumps, at most [m]."""
        moving = [[replace(k, jump=0.0) for k in knots if k.accel or k.stands] for knots in self.knots]
        return max(sum(answer(knots, w).largest for knots in moving if knots) for w in frequencies(omegas))

    def along(self, axis: int) -> bool:
        """Whether anything moves the load along the rails (0), or across (1)."""
        return bool(self.knots[axis])

    def at(self, times: Sequence[float]) -> float:
        """How far the load may swing at any of these times [m]."""
        tried = ([answer(k, w, 0.0, times).sizes for k in self.knots if k] for w in frequencies(self.omegas))
        return max((sum(sizes) for axes in tried for sizes in zip(*axes, strict=True)), default=0.0)


def _slope(axes: Sequence[tuple[Answer, Answer]]) -> float:
    largest = max(low.largest for low, _ in axes)
    changes = sum(abs(high.largest - low.largest) for low, high in axes) / (2.0 * STEP)
    return changes / largest if largest > 0.0 else 0.0


def _drift(low: Answer, high: Answer) -> float:
    return max((abs(b - a) for a, b in zip(low.at, high.at, strict=True)), default=0.0) / (2.0 * STEP)
