"""The body of a block, rigid or flexible: how its mass and moments of inertia are divided between a beam and a rigid
part.

A uniform beam along x has the moment m L^2 / 12 about y and z, and the height and width of the block contribute nothing
to it; if modes are given instead of a beam, the whole mass is in the rigid part. The rigid part gets the moments that
are missing to those of the block, so that a block with stiff modes moves like a rigid one.
"""

from dataclasses import replace

from heavylift.kernel.description.flexible import Flexible
from heavylift.kernel.description.mechanics import Body, Matrix, Vector


def block_body(given: Body, flexible: Flexible | None) -> Body:
    """Return a body with its flexible part, if any; the rigid part loses the mass properties of the beam."""
    if flexible is None or flexible.beam is None:
        return replace(given, flexible=flexible)
    beam = flexible.beam
    bends = beam.mass_per_length * beam.length
    left = max(0.0, given.mass - bends)
    about = bends * beam.length * beam.length / 12.0
    com: Vector = (0.0, 0.0, 0.0)
    if left:
        x, y, z = (given.mass / left * c for c in given.com)
        com = (x, y, z)
    whole, own, of_beam = _about_origin(given.mass, given.com), _about_origin(left, com), (
        beam.polar * beam.length, about, about,
    )  # fmt: skip

    def moment(i: int, j: int) -> float:
        return given.inertia[i][j] + whole[i][j] - own[i][j] - (of_beam[i] if i == j else 0.0)

    a, b, c = ((moment(i, 0), moment(i, 1), moment(i, 2)) for i in range(3))
    return Body(given.name, left, com, (a, b, c), flexible)


def _about_origin(mass: float, p: Vector) -> Matrix:
    """Return the moments of inertia (3, 3) [kg m2] of a point mass at p about the origin."""
    square = sum(x * x for x in p)
    a, b, c = (
        (mass * ((i == 0) * square - p[i] * p[0]), mass * ((i == 1) * square - p[i] * p[1]),
         mass * ((i == 2) * square - p[i] * p[2]))
        for i in range(3)
    )  # fmt: skip
    return a, b, c
