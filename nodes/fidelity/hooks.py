"""The numbers of one hook that its rules need, and how several share a block whose girders bend.

A rigid block on hooks that all rise alike: T = C^-1 (plane), sum T = W, no moment about the centre of mass, with C the
compliances of ropes and slings, and with the girders' sin(pi y_i / L) sin(pi y_j / L) / k for hooks of one crane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from math import fsum, sqrt

from heavylift.kernel.algebra.dense import dot, least_norm, norm, singular_values, solve

SINGULAR = 1e-9  # singular value, relative, of hooks in one line


@dataclass(frozen=True)
class Hook:
    """One hook under its largest static load; compliances in m/N, speeds of its winch in m/s."""

    rope: str
    crane: str
    load: float  # on the rope, with hook block and loader [kg]
    share: float  # of it, what the block weighs on it [kg]
    length: float  # longest while loaded [m]
    reach: float  # from the trolley to the block's centre of mass then [m]
    rubs: float  # damping of the rope over its stiffness [s]
    rope_mass: float  # of that length [kg]
    place: tuple[float, float]  # from the block's centre of mass, at the start [m]
    depth: float  # of the loader below the hook [m]
    beam: float  # between the slings [m]
    soft_rope: float
    soft_slings: float
    soft_girder: float  # deflection there under all that the block loads its crane with, per force of this hook
    bend: float  # sin(pi y / L) / sqrt(k) of its place on the girder [1 / sqrt(N/m)]
    aside: float  # way of the rope's end to the side as the girder bends by 1 m at this place [m]
    slides: float  # way of its trolley into its servo, down the slope of the girder, there and back [m]
    tilts: float  # way to the side per way that its trolley traverses, as the bent girder slopes
    traverses: float  # longest of these ways [m]
    rings: float  # dynamic part of its load from what the list does as it hangs, relative
    picks: float  # fastest hoisting while the block may part, less what the stools give way
    ramp: float  # [m/s2]

    @property
    def light(self) -> bool:
        """Whether what hangs between rope and slings weighs less than the rope."""
        return self.load - self.share < self.rope_mass

    def soft(self, girder: bool) -> float:
        """Of all that the block hangs from [m/N]."""
        return self.soft_rope + self.soft_slings + girder * self.soft_girder

    def stretch(self, g: float, girder: bool) -> float:
        """How far all gives way under the block [m]."""
        return self.share * g * self.soft(girder)

    def sag(self, g: float) -> float:
        """Of the girder under the block [m]."""
        return self.share * g * self.soft_girder

    def omega(self, girder: bool) -> float:
        """Of the block on this hook, up and down [rad/s]."""
        return 1.0 / sqrt(self.share * self.soft(girder))


def nodding(h: Hook, g: float) -> tuple[float, float, float]:
    """Frequency [rad/s] of a block that swings against its hook, two points of a double pendulum, and what part that is
    of the block's way as the trolley moves, and as the block is let go aside of a hook that hangs plumb."""
    hook, d = h.load - h.share, h.reach - h.length
    inner, outer = g * h.load / h.length, g * h.share / d
    a, b = (inner + outer) / hook, g / d
    root = sqrt((a - b) * (a - b) / 4.0 + outer * b / hook)
    slow, fast = (a + b) / 2.0 - root, (a + b) / 2.0 + root
    first, second = 1.0 - slow / b, 1.0 - fast / b  # ways of the hook in either swing, for one of the block
    return sqrt(fast), (1.0 - first) / (first - second), first / (first - second)


def redistribution(hooks: Sequence[Hook]) -> float:
    """Largest relative change of a hook's load if girders do not bend."""
    rigid = [[(a.soft_rope + a.soft_slings) * (a is b) for b in hooks] for a in hooks]
    bent = [[x + a.bend * b.bend * (a.crane == b.crane) for x, b in zip(row, hooks, strict=True)]
            for row, a in zip(rigid, hooks, strict=True)]  # fmt: skip
    before, after = (_shares(hooks, C) for C in (bent, rigid))
    return max(abs(b - a) * h.share / h.load for a, b, h in zip(before, after, hooks, strict=True))


def coupling(hooks: Sequence[Hook]) -> float:
    """Part of what a trolley moves of its load, as a straight pendulum, that the sixth of the ropes' mass moves which
    couples their ends."""
    moved = sum((h.load - h.share) * (h.length + h.depth) + h.share * h.reach for h in hooks)
    return sum(h.rope_mass * h.length for h in hooks) / 6.0 / moved


def leaning(hooks: Sequence[Hook], g: float) -> float:
    """How far the centre of mass moves aside as ropes and slings of different hooks stretch differently [m]."""
    pairs = ((a, b, _apart(a, b)) for a, b in combinations(hooks, 2))
    return max(
        (abs(a.stretch(g, False) - b.stretch(g, False)) / d * (a.reach - a.length) for a, b, d in pairs if d > 0.0),
        default=0.0,
    )


def _apart(a: Hook, b: Hook) -> float:
    return norm([p - q for p, q in zip(a.place, b.place, strict=True)])


def tipping(hooks: Sequence[Hook]) -> float:
    """Largest relative change of a hook's load as ropes are inclined by 1 rad: what swings pulls below the hooks."""
    C = [[(a.soft_rope + a.soft_slings) * (a is b) for b in hooks] for a in hooks]
    moment = sum(h.share * (h.reach - h.length) for h in hooks)
    found = (_carried(hooks, C, [0.0, *pull]) for pull in ((moment, 0.0), (0.0, moment)))
    return max(abs(T) / h.load for tensions in found for T, h in zip(tensions, hooks, strict=True))


def _shares(hooks: Sequence[Hook], C: Sequence[Sequence[float]]) -> list[float]:
    """Per hook, relative to the shares that statics found."""
    tensions = _carried(hooks, C, [fsum(h.share for h in hooks), 0.0, 0.0])
    return [T / h.share for T, h in zip(tensions, hooks, strict=True)]


def _carried(hooks: Sequence[Hook], C: Sequence[Sequence[float]], W: list[float]) -> list[float]:
    """What each hook has of a weight and two moments [kg, kg m]; of hooks in one line, without leaning off it."""
    A = [(1.0, *h.place) for h in hooks]
    columns = [solve(C, list(column)) for column in zip(*A, strict=True)]  # of C^-1 A
    N = [[dot(a, column) for column in columns] for a in zip(*A, strict=True)]
    tilt = least_norm(N, W, SINGULAR * max(singular_values(N)))
    return [dot(row, tilt) for row in zip(*columns, strict=True)]
