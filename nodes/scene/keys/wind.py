"""The key `wind:` of a scene, and the forces of a mechanism that it stands for.

Turbulence has the spectrum of EN 1991-1-4, B.1: n S / s² = 6.8 f / (1 + 10.2 f)^(5/3), f = n L / v, of the standard
deviation s and the length L.  It is written as a sum of harmonics with random frequencies and phases (Shinozuka and
Deodatis, Applied Mechanics Reviews 44 (1991) 191-204) and given as a history, one speed a second.  What is slower than
twenty minutes or faster than two seconds is left out.
"""

from __future__ import annotations

from itertools import pairwise
from math import pi, sqrt
from random import Random
from typing import Annotated

from heavylift.kernel.algebra.elementary import cos, power
from heavylift.nodes.scene.text import units as u
from pydantic import Field, model_validator

from .base import Base, Direction
from .parts.forces import Wind as Force

BLOCK = "block"
USUAL, LONGEST = 7200.0, 86400.0  # [s] of a history, where no end is given, and of any; then its last speed goes on
HARMONICS = 128
SLOWEST, FASTEST = 1.0 / 1200.0, 0.5  # [Hz] of them; half of one speed a second


class Area(Base):
    """What the wind sees of a body along its own axes."""

    sides: tuple[u.Area, u.Area, u.Area]
    drag: u.Ratio | None = None  # left out: that of the wind


class Wind(Base):
    """Wind on the block, whose sides are those of its box, and on other bodies whose sides are given in `on`."""

    speed: u.Velocity
    direction: Direction  # to which it blows
    gusts: list[tuple[u.Instant, u.Velocity]] = Field(default_factory=list)  # speeds over time, in place of one
    turbulence: Annotated[u.Ratio, Field(le=0.5)] = 0.0  # standard deviation over speed; by the scene's seed
    scale: u.Extent = u.LENGTH.read("130 m")  # of turbulence; EN 1991-1-4 at 40 m over open country
    drag: u.Ratio = 1.2  # of a box; assumed
    density: u.Density = 1.225
    on: dict[str, Area] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _one(self) -> Wind:
        if self.gusts and self.turbulence:
            raise ValueError("give the wind either 'gusts' or a 'turbulence'")
        if not any(self.direction):
            raise ValueError("the direction of the wind has no length")
        return self

    def forces(self, block: tuple[float, float, float] | None, seed: int, end: float | None) -> dict[str, Force]:
        """By name; `block`: the size of its box [m], if there is one; `end`: of the run [s], if it is known."""
        areas = dict(self.on)
        if block is not None:
            x, y, z = block
            areas.setdefault(BLOCK, Area.model_construct(sides=(y * z, z * x, x * y)))
        gusts = turbulent(self.speed, self.turbulence, self.scale, seed, end) if self.turbulence else self.gusts
        return {
            f"wind.{body}": Force.model_construct(
                type="wind",
                body=body,
                sides=area.sides,
                drag=self.drag if area.drag is None else area.drag,
                direction=self.direction,
                speed=self.speed,
                gusts=gusts,
                density=self.density,
            )
            for body, area in sorted(areas.items())
        }


def turbulent(speed: float, turbulence: float, scale: float, seed: int, end: float | None) -> list[tuple[float, float]]:
    """Times [s] and speeds [m/s] of a wind of this mean until the end of the run, if it is known."""
    random = Random(f"wind {seed}")
    ends = [SLOWEST * float(power(FASTEST / SLOWEST, i / HARMONICS)) for i in range(HARMONICS + 1)]
    speeds = [speed] * (int(min(end or USUAL, LONGEST)) + 2)
    for low, high in pairwise(ends):
        n = low + (high - low) * random.random()  # so that it never comes again
        f = n * scale / abs(speed) if speed else 0.0
        s = turbulence * speed
        S = s * s / n * 6.8 * f / float(power(1.0 + 10.2 * f, 5.0 / 3.0))
        size, w, phase = sqrt(2.0 * S * (high - low)), 2.0 * pi * n, 2.0 * pi * random.random()
        turn, here, following = 2.0 * float(cos(w)), size * float(cos(phase)), size * float(cos(w + phase))
        for t in range(len(speeds)):
            speeds[t] += here
            here, following = following, turn * following - here  # cos(a + w) = 2 cos w cos a - cos(a - w)
    return [(float(t), v) for t, v in enumerate(speeds)]
