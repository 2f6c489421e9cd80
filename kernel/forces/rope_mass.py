"""What the ends of a rope bear of its own mass, as if it were straight and evenly stretched.

Half of its weight pulls each end down, and a third of its mass moves with each; the sixth that couples the motion of
both ends is left out (Rayleigh 1877, The Theory of Sound, section 156).  So a mass on a rope, up and down, and a
straight pendulum that it makes, keep their frequencies.  The masses join the bodies before anything is traced; what
they do not weigh, a sixth of the rope at each end, is a force.  At the lower end the tension is smaller by half of the
weight than in the middle.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.symbol import Array, Scalar, maximum
from heavylift.kernel.description.mechanics import WORLD, Body, Point, RigidRope, Rope, System
from heavylift.kernel.multibody.fixed_masses import gathered

MOVES, WEIGHS = 1.0 / 3.0, 1.0 / 2.0  # parts of a rope's mass at each end


def with_rope_masses(system: System) -> System:
    """The system with the masses that its ropes move on their bodies."""
    borne: dict[str, list[tuple[float, Point]]] = {}
    for rope in system.straight_ropes:
        for mass, end in _ends(rope):
            borne.setdefault(end.body, []).append((mass, end))
    if not borne:
        return system
    return replace(system, bodies=tuple(_with(b, borne.get(b.name, [])) for b in system.bodies))


def not_weighed(weight: Scalar) -> Scalar:
    """What the bodies at each end of a rope do not weigh of its own weight [N]."""
    return (WEIGHS - MOVES) * weight


def pulls_down(weight: Scalar, x: Array) -> Array:
    """(6,) wrench of that at an end, at x from the tree's point."""
    f = -not_weighed(weight)
    return join([x[1] * f, -x[0] * f, 0.0], [0.0, 0.0, f])


def at_the_hook(tension: Scalar, weight: Scalar) -> Any:
    """Tension at the lower end of a rope, from that in its middle [N]."""
    return maximum(tension - WEIGHS * weight, 0.0)


def _ends(rope: Rope | RigidRope) -> Iterator[tuple[float, Point]]:
    """What moves with each end that is not the ground's."""
    for line in rope.lines if rope.mass else ():
        for end in (line.a, line.b):
            if end.body != WORLD:
                yield MOVES * line.share * rope.mass, end


def _with(body: Body, borne: list[tuple[float, Point]]) -> Body:
    """A body with masses at points of it."""
    if not borne:
        return body
    parts = [(body.mass, np.array(body.com)), *((m, np.array(p.p)) for m, p in borne)]
    mass, com, inertia = gathered(np.array(body.inertia), parts)
    px, py, pz = com.tolist()
    a, b, c = ((u, v, w) for u, v, w in inertia.tolist())
    return replace(body, mass=mass, com=(px, py, pz), inertia=(a, b, c))
