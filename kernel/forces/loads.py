"""Forces from outside: loads that are given, and the drag of the wind (EN 13001-2, 4.2.3.1; closed form C16)."""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, sqrt
from heavylift.kernel.description.forces import Load, Wind

from .force_law import ForceLaw, LawOutput, Poses, SampledQuantity, attachment, wrench

UNIT = 1e-6  # how far a direction may be off by rounding


class LoadLaw(ForceLaw[Load]):
    """Force and moment times the signal; what they do to the body is work."""

    works = True

    def shape(self, f: Load) -> Hashable:
        return f.axes, any(f.force), any(f.moment)

    def numbers(self, f: Load, poses: Poses) -> list[float]:
        return [*f.at.p, *f.force, *f.moment]

    def answer(self, f: Load, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        body = ends[0]
        x, _, v = attachment(body, p[:3], "a")
        force: Array = signal[0] * p[3:6] if any(f.force) else np.zeros(3)
        moment: Array = signal[0] * p[6:9] if any(f.moment) else np.zeros(3)
        if f.axes == "body":
            R = np.reshape(body[:9], (3, 3))
            force, moment = R @ force, R @ moment
        work = force @ v + moment @ body[15:18]
        return LawOutput([wrench(x, force, moment)], work=work, shown=[signal[0]])

    def shows(self, f: Load) -> list[SampledQuantity]:
        return [SampledQuantity("load/signal", f.name, "1")]


class WindLaw(ForceLaw[Wind]):
    """Drag at a point that may move itself."""

    works = True

    def check(self, f: Wind) -> None:
        size = norm(f.direction)
        self.demand(f, "direction", abs(size - 1.0) < UNIT, f"has length {size:g}; it must be a unit vector")

    def numbers(self, f: Wind, poses: Poses) -> list[float]:
        half = 0.5 * f.density * f.drag
        return [*f.at.p, half * f.area, *f.direction, *(half * side for side in f.sides)]

    def shape(self, f: Wind) -> Hashable:
        return any(f.sides)

    def answer(self, f: Wind, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        x, _, v = attachment(ends[0], p[:3], "a")
        u = signal[0] * p[4:7] - v
        size = p[3] * sqrt(u @ u)
        if any(f.sides):
            size += p[7:] @ abs(np.reshape(ends[0][:9], (3, 3)).T @ u)
        force = size * u
        return LawOutput([wrench(x, force)], work=force @ v, shown=[signal[0], sqrt(force @ force)])

    def shows(self, f: Wind) -> list[SampledQuantity]:
        return [SampledQuantity("wind/speed", f.name, "m/s"), SampledQuantity("wind/force", f.name, "N")]
