"""Wind and current forces on a vessel by direction-dependent coefficients, such as those of OCIMF, equal on port and
starboard.

The table of coefficients becomes its trigonometric polynomial (Trefethen, Spectral Methods in MATLAB, 2000, chapter 3):
C_x of cosines, C_y and C_z of sines of multiples of the direction beta. With the unit vector (c, s) of the stream these
are parts of (c + i s)^k, so that no step crosses a kink.
"""

from collections.abc import Hashable
from typing import Any

import numpy as np
from heavylift.kernel.algebra.arrays import times
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, sqrt
from heavylift.kernel.description.forces import Stream

from .force_law import ForceLaw, LawOutput, Poses, SampledQuantity, attachment, wrench

UNIT = 1e-6  # how far a direction may be off by rounding, and coefficients at both ends from zero
STILL = 1e-24  # [m2/s2]: keeps 0/0 away


class StreamLaw(ForceLaw[Stream]):
    """Force law of wind or current that flows past a point of a body: force and yaw moment."""

    works = True

    def check(self, f: Stream) -> None:
        size = norm(f.direction)
        self.demand(f, "direction", abs(size - 1.0) < UNIT, f"has length {size:g}; it must be a unit vector")
        enough = len(f.coefficients) > 1
        self.demand(f, "coefficients", enough, "are those of less than two directions; give them from 0 to 180 degrees")
        ends = max(abs(x) for row in (f.coefficients[0], f.coefficients[-1]) for x in row[1:])
        self.demand(f, "coefficients", ends < UNIT, "across and in yaw must be zero at 0 and at 180 degrees")

    def shape(self, f: Stream) -> Hashable:
        return len(f.coefficients)

    def numbers(self, f: Stream, poses: Poses) -> list[float]:
        pressure = 0.5 * f.density * f.area
        sizes = np.array([pressure, pressure, pressure * f.length])
        return [*f.at.p, *f.direction, *(sizes * harmonics(f.coefficients)).ravel().tolist()]

    def answer(self, f: Stream, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        x_P, _, v = attachment(ends[0], p[:3], "a")
        R = np.reshape(ends[0][:9], (3, 3))
        along, across, _ = R.T @ (signal[0] * p[3:6] - v)
        square = along * along + across * across
        speed = sqrt(square + STILL)
        c, s = along / speed, across / speed
        found, power = [0.0, 0.0, 0.0], (square, 0.0)  # u^2 (cos, sin) of k beta
        for row in np.reshape(p[6:], (-1, 3)):
            found = [a + row[i] * power[i > 0] for i, a in enumerate(found)]
            power = (power[0] * c - power[1] * s, power[0] * s + power[1] * c)
        force, moment = R @ np.array([found[0], found[1], 0.0]), R @ np.array([0.0, 0.0, found[2]])
        work = force @ v + moment @ ends[0][15:18]
        return LawOutput([wrench(x_P, force, moment)], work=work, shown=[signal[0], *found])

    def shows(self, f: Stream) -> list[SampledQuantity]:
        parts = [SampledQuantity("stream/force", f"{f.name}.{c}", "N or N m") for c in ("x", "y", "rz")]
        return [SampledQuantity("stream/speed", f.name, "m/s"), *parts]


def harmonics(table: tuple[tuple[float, float, float], ...]) -> np.ndarray:
    """Return the Fourier coefficients (n + 1, 3) of a table of C_x, C_y, C_z over directions beta = 0 to pi in n steps.

    Of cos(k beta) for C_x, of sin(k beta) for C_y and C_z.
    """
    n, rows = len(table) - 1, np.array(table)
    k = np.arange(n + 1)
    turns: Any = np.pi / n * np.outer(k, k)
    half = np.where((k == 0) | (k == n), 0.5, 1.0)
    x = times(cos(turns) * np.outer(half, half), rows[:, :1])
    return 2.0 / n * np.column_stack([x, times(sin(turns), rows[:, 1:])])
