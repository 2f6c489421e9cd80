"""Shapes of the modes of a beam for what slides along it: Chebyshev polynomials that follow them smoothly."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from heavylift.kernel.algebra.arrays import times
from heavylift.kernel.algebra.polynomials import derivative, integral, polynomials, product, roots, series, spline
from heavylift.kernel.errors import KernelError

from .attachment import Track
from .modes import FlexibleModes
from .rounding import rounded

SMOOTH, NOT_SMOOTH = 1e-6, 1e-2  # errors of polynomials, sought and refused; shapes are 1 at most


@lru_cache(maxsize=64)
def track(modes: FlexibleModes, joint: str) -> Track:
    """Displacements and rotations (slopes) of every mode as polynomials of the place along the beam.

    Raises KernelError naming the joint that slides if this is no beam or a mode is not smooth.
    """
    beam, m = modes.flexible.beam, len(modes.mass)
    if beam is None or beam.start:
        raise KernelError(f"joint '{joint}': body '{modes.name}' is no beam from its origin on; a slider needs one")
    x = roots(4 * beam.elements)
    places = (1.0 + x) * beam.length / 2.0
    nodal = modes.shapes.reshape(-1, 6, m)[:, :4].reshape(-1, 4 * m)  # ux uy uz rx; ry and rz are slopes
    # where elements are most accurate, at their nodes, and smooth between them, as the modes are
    moved = spline(modes.nodes[:, 0], nodal, min(7, (beam.elements - 1) | 1), places)
    whole = series(moved, min(beam.elements + 8, len(x) - 1))
    T = polynomials(x, len(whole) - 1)
    fits = {n: whole[: n + 1] for n in range(8, beam.elements + 9, 2)}
    errors = {n: float(np.abs(times(T[:, : n + 1], c) - moved).max(initial=0.0)) for n, c in fits.items()}
    least = min(errors.values())
    if least > NOT_SMOOTH:
        raise KernelError(
            f"joint '{joint}': polynomials follow the modes of '{modes.name}' to {least:.1g} only; "
            "give its beam fewer modes or loads, or more elements"
        )
    fit = fits[next(n for n, error in errors.items() if error <= max(SMOOTH, 2.0 * least))]
    fit = fit.reshape(-1, 4, m)
    slopes = derivative(fit) * (2.0 / beam.length)
    coefficients = rounded(np.concatenate([fit, -slopes[:, 2:3], slopes[:, 1:2]], axis=1))
    turned = coefficients[:, 4:]
    y, z = (product(turned[:, d, :, None], turned[:, d, None, :]) for d in (0, 1))
    g = integral(y + z) * (beam.length / 2.0)
    g[0] += modes.shortening(0.0)
    return Track(np.zeros(3), 2.0 / beam.length, coefficients, rounded(g))
