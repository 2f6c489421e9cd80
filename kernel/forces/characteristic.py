"""Actuator laws given as data: a piecewise linear effort over the coordinate or the speed of a joint.

A torque-speed curve of a motor, a buffer's force-travel curve.  P holds the piece that is active; its ends are guards,
so that no step crosses a kink and the integrators keep their order.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Hashable
from itertools import pairwise

import numpy as np
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars
from heavylift.kernel.description.forces import Characteristic

from .force_law import ForceLaw, LawOutput, Poses, SampledQuantity

FAR = 1e300  # beyond any coordinate


class CharacteristicLaw(ForceLaw[Characteristic]):
    """Effort = signal * f(x); its work counts as the actuator's."""

    works = True

    def check(self, f: Characteristic) -> None:
        n, m = len(f.x), len(f.effort)
        self.demand(f, "effort", n == m > 0, f"has {m} values at {n} places; give one for each place, at least one")
        low = next((b for a, b in pairwise(f.x) if b <= a), None)
        self.demand(f, "x", low is None, f"does not rise at {low}; its places must rise")

    def shape(self, f: Characteristic) -> Hashable:
        return f.of

    def numbers(self, f: Characteristic, poses: Poses) -> list[float]:
        return _piece(f, 0)

    def answer(
        self, f: Characteristic, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar
    ) -> LawOutput:
        lower, upper, x0, effort, slope = p
        x = joint[0 if f.of == "position" else 1]
        force = signal[0] * (effort + slope * (x - x0))
        return LawOutput(effort=force, work=force * joint[1], guards=[x - lower, upper - x], shown=[force, x])

    def guards(self, f: Characteristic) -> tuple[str, ...]:
        return "lower end", "upper end"

    def switch(self, f: Characteristic, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        x = float(shown[1])
        p[:] = _piece(f, bisect_right(f.x, x))
        return "piece", x

    def shows(self, f: Characteristic) -> list[SampledQuantity]:
        return [
            SampledQuantity("characteristic/effort", f.name, "N or N m"),
            SampledQuantity("characteristic/place", f.name, "SI"),
        ]


def _piece(f: Characteristic, i: int) -> list[float]:
    """Ends, a point and the slope of the piece below place i; the end values hold outside."""
    if i == 0:
        return [-FAR, f.x[0], f.x[0], f.effort[0], 0.0]
    if i == len(f.x):
        return [f.x[-1], FAR, f.x[-1], f.effort[-1], 0.0]
    slope = (f.effort[i] - f.effort[i - 1]) / (f.x[i] - f.x[i - 1])
    return [f.x[i - 1], f.x[i], f.x[i - 1], f.effort[i - 1], slope]
