"""One-sided and dry contact of laws: springs that only push, and friction that sticks and slips."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from heavylift.kernel.compiler.symbol import Array, Scalar, maximum, minimum, select, sqrt

ROUND_OFF = 1e-12  # [m] deflection of a friction spring that round-off in places far from the origin can feign
RELAXED = 1.0 - 1e-5  # of its limit, below which friction at rest holds: more than rounding of poses changes it
SLIP_BLEND = 1e-6  # [m/s] below this speed the direction of sliding friction is that of the slip's start
JUST_BELOW = 1.0 - 1e-9  # part of the limit that a spring holds which begins to stick, so that it does not slip at once
SLOWEST = 1e-3 * SLIP_BLEND  # of a slip: below, the blend makes its direction, by turns of slip and stick
GIVEN_WAY = 0.5  # part that it holds after the limit has fallen below it
FAINT = 1e-6  # [m] deflection from which it then gives way wholly: halves of halves have no end as a pad is left


class FrictionForce(NamedTuple):
    """Force, guard, heat [W] and stored energy [J]."""

    force: Any
    guard: Scalar
    heat: Scalar
    stored: Scalar


def one_sided(force: Scalar, clamped: bool) -> Scalar:
    """max(0, force), or the force as it is: a step that ends behind an event sees a smooth law and is then cut.

    Where it is clamped, the dense output before the event suffers from the kink.
    """
    return maximum(force, 0.0) if clamped else force


def pushes(depth: Scalar, rate: Scalar, k: Scalar, d: Scalar, closed: Scalar, clamped: bool) -> FrictionForce:
    """A one-sided spring-damper."""
    trial = k * depth + d * rate
    on = closed > 0.0
    return FrictionForce(
        select(on, one_sided(trial, clamped), 0.0),
        select(on, trial, -minimum(depth, trial)),
        select(on, d * rate * rate, 0.0),
        select(on, 0.5 * k * depth * depth, 0.0),
    )


def friction(
    s: Array, v: Array, limit: Scalar, k: Scalar, d: Scalar, stick: Scalar, direction: Array, at_rest: bool
) -> FrictionForce:
    """(n,) dry friction: a spring-damper from its anchor (s from it) that slips at `limit`.

    Slipping, the force has the size of the limit and opposes the velocity; `direction` (n,) is that of the start of
    the slip, and the slip ends when the velocity along it falls through zero.  Where only rests are looked for, the
    direction is that of the spring, whose anchor gives way (radial return; Simo, Hughes 1998, 1.4), and the slip ends
    when the spring relaxes.
    """
    held = k * s + d * v
    size = sqrt(held @ held + 1e-300)
    u = held if at_rest else v + SLIP_BLEND * direction
    u = u * (1.0 / sqrt(u @ u + 1e-300))
    on = stick > 0.0
    return FrictionForce(
        np.array([-select(on, h, limit * w) for h, w in zip(held, u, strict=True)]),
        select(on, limit + k * ROUND_OFF - size, size - RELAXED * limit if at_rest else direction @ v),
        select(on, d * (v @ v), limit * (u @ v)),
        select(on, 0.5 * k * (s @ s), 0.0),
    )


def deflection(force: Any, velocity: Any, k: float, d: float) -> Any:
    """How far a friction spring is from its anchor to hold a force; without a spring nothing is held."""
    return (force - d * velocity) / k if k > 0.0 else 0.0 * force
