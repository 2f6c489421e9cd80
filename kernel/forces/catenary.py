"""The elastic catenary in closed form: end forces from the distance of the ends, on floats and in traced code.

Lengths are relative to the unstretched length L, forces to the weight w L of the line; k = w L / (2 EA). A line that
hangs from both ends has the horizontal force H = x / (2 (u + k)) and the mean vertical force V = z / (2 (tanh u + k)),
where u, half the difference of asinh(V / H) between its ends, solves sinh(u)^2 (x^2 / (u + k)^2 + z^2 / (sinh u + k
cosh u)^2) = 1. A line of which a part lies has V = H sinh m at the fairlead, z = H (cosh m - 1) + k V^2, and x = 1 - V
+ H m + 2 k H. (Irvine, Cable Structures, 1981; the same solution as in Jonkman, NREL/TP-500-41958, 2007.)

Both equations have one unknown and one root. Newton's iteration is written so that it approaches the root from one
side, and has a fixed number of steps: it needs no start value from earlier steps, and its derivatives are those of the
solution.
"""

from functools import cache
from typing import NamedTuple

from heavylift.kernel.algebra.elementary import exp, log
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalar, maximum, minimum, select, sqrt

STEPS = {"hanging": 10, "lying": 7}  # before the last, random lines miss 1e-7 of their length
SMALL = 0.5  # below it sinh is a series, whose error is less than rounding
SERIES = (156.0, 110.0, 72.0, 42.0, 20.0)  # products of neighbours: (2 n)(2 n + 1)
PLUMB, LEVEL = 1e-6, 1e-6  # least horizontal and vertical distance
STEEPEST = 16.0  # m at which the horizontal force of a slack line is 2e-7 of its vertical one, and stays
LEAST = 1e-9
THIRD = 1.0 / 3.0


class EndForces(NamedTuple):
    """Horizontal force H and vertical force V at the fairlead of a catenary line, divided by its weight."""

    H: Scalar
    V: Scalar
    turn: Scalar  # difference of asinh(V / H) between the ends of the part that hangs
    missed: Scalar  # error of the length before the last iteration


def hanging(x: Scalar, z: Scalar, k: Scalar) -> EndForces:
    """Return the end forces of a hanging line, its ends x > 0 apart horizontally and z vertically (in line lengths)."""
    x = maximum(x, PLUMB)
    chord = sqrt(x * x + z * z)
    share, stretch = x * x * (1.0 / (chord * chord)), log(chord)
    wide = exp(log(6.0 * k / share) * THIRD)  # of a line as long as its chord
    steep = log(2.0 / minimum(x, 1.0))
    sagging = minimum(sqrt(6.0 * maximum(-stretch, 0.0) / share), steep + log(1.0 + steep) + 0.5) + minimum(wide, 1.0)
    u = select(stretch > 0.0, minimum(k / maximum(stretch, LEAST), wide), sagging)
    u, missed = _iterated("hanging", u, x, z, k)
    s, C, _ = _sinh(u)
    return EndForces(x / (2.0 * (u + k)), 0.5 * z * C / (s + k * C) + 0.5, 2.0 * u, missed)


def lying(x: Scalar, z: Scalar, k: Scalar) -> EndForces:
    """Return the end forces of a line that partly lies on the seabed, z > 0 (in line lengths) below its fairlead."""
    z = maximum(z, LEVEL)
    low = 2.0 * z / (1.0 + sqrt(1.0 + 4.0 * k * z))  # the vertical force of a slack line
    slack = (1.0 - x) / low
    tip = maximum(z - k, LEAST)
    lifts = log((1.0 + tip) / maximum(1.0 - tip, LEAST))  # m where the whole line hangs
    wide = exp(log(12.0 * k) * THIRD)
    near = maximum(slack, LEAST)
    sagging = 3.0 * near + minimum(wide, 4.0 * k / (3.0 * near * near))
    stretched = minimum(wide, sqrt(4.0 * k / maximum(-slack, LEAST)))
    far = 0.6 - 1.25 * log(maximum(1.0 - slack, LEAST))
    m = select(slack > 0.5, far, select(slack > 0.0, sagging, stretched))
    m, missed = _iterated("lying", minimum(maximum(maximum(m, lifts), LEAST), STEEPEST), x, z, k)
    s, C, _ = _sinh(m)
    H = _lying_force(s, C, z, k)[0]
    return EndForces(H, H * s, m, missed)


def line_shape(x: float, z: float, k: float, seabed: bool, n: int) -> tuple[EndForces, list[tuple[float, float]]]:
    """Return the end forces of a line and the positions, from its anchor, of n + 1 points that divide it evenly."""
    found = lying(x, z, k) if seabed and z > 0.0 else hanging(x, z, k)
    if seabed and found.V > 1.0:
        found = hanging(x, z, k)
    H, low = found.H, found.V - 1.0
    lies = max(-low, 0.0) if seabed else 0.0
    low = max(low, 0.0) if seabed else low

    def asinh(y: float) -> float:
        size = float(log(abs(y) + sqrt(y * y + 1.0)))
        return size if y > 0.0 else -size

    points = []
    for i in range(n + 1):
        s = i / n
        v = low + max(s - lies, 0.0)
        along = min(s, lies) + H * (asinh(v / H) - asinh(low / H)) + 2.0 * k * H * s
        points.append((along, sqrt(H * H + v * v) - sqrt(H * H + low * low) + k * (v * v - low * low)))
    return found, points


def _sinh(u: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Return sinh u, cosh u and sinh u - u of a positive number."""
    series: Scalar = 1.0
    for c in SERIES:
        series = 1.0 + u * u * (1.0 / c) * series
    small, E = u * u * u * (1.0 / 6.0) * series, exp(u)
    more = select(u < SMALL, small, 0.5 * (E - 1.0 / E) - u)
    s = u + more
    return s, sqrt(1.0 + s * s), more


def _lying_force(s: Scalar, C: Scalar, z: Scalar, k: Scalar) -> tuple[Scalar, Scalar]:
    """Return the horizontal force H of a line that partly lies, and its derivative by m."""
    b = s * s / (C + 1.0)
    root = sqrt(b * b + 4.0 * k * z * s * s)
    H = 2.0 * z / (b + root)
    return H, -H / (b + root) * s * (1.0 + (b + 4.0 * k * z * C) / root)


def _hanging_step(u: Array, p: Array) -> Outputs:
    (m,), (x, z, k) = u, p
    s, C, _ = _sinh(m)
    X, Z, slope = x * s / (m + k), z * s / (s + k * C), C / s
    A = X * X + Z * Z
    error = 0.5 * log(A)
    by_m = (X * X * (slope - 1.0 / (m + k)) + Z * Z * (slope - (C + k * s) / (s + k * C))) / A
    rise = error + m * by_m
    # of m times the error, which is convex
    after = select(rise > 0.0, m - m * error / select(rise > 0.0, rise, 1.0), 2.0 * m)
    return {"next": [minimum(maximum(after, 0.2 * m), 5.0 * m)], "missed": [abs(error)]}


def _lying_step(u: Array, p: Array) -> Outputs:
    (m,), (x, z, k) = u, p
    s, C, more = _sinh(m)
    H, by_m = _lying_force(s, C, z, k)
    error = 1.0 - H * more + 2.0 * k * H - x
    slope = by_m * (2.0 * k - more) - H * (C - 1.0)
    low = 2.0 * z / (1.0 + sqrt(1.0 + 4.0 * k * z))
    least = maximum(x + low - 1.0, LEAST * z)  # what is left to a slack line
    left = (least - error) / least
    steep = select(left > 0.0, log(maximum(left, LEAST)) * least * left, -error) / slope
    flat = -m * error / (2.0 * error + m * slope)  # of m^2 times the error
    after = m + select(1.0 - x > 0.5 * low, steep, flat)
    slack = select(m >= STEEPEST, maximum(-error, 0.0), abs(error))
    return {"next": [minimum(minimum(maximum(after, 0.3 * m), 3.0 * m), STEEPEST)], "missed": [slack]}


@cache
def _step(kind: str) -> Function:
    """Return one step of the iteration, whose code all lines share."""
    return Function(f"catenary_{kind}", {"hanging": _hanging_step, "lying": _lying_step}[kind], {"u": 1, "p": 3})


def _iterated(kind: str, u: Scalar, *p: Scalar) -> tuple[Scalar, Scalar]:
    missed: Scalar = 0.0
    for _ in range(STEPS[kind]):
        found = _step(kind)(u=[u], p=p)
        u, missed = found.next[0], found.missed[0]
    return u, missed
