"""Ropes of the rigging that run over something, and how high what holds them hangs above what they hold."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.description import mechanics as k
from heavylift.kernel.description.forces import Reeving, Sheave, Signal
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.reeving import ReevingLaw
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.nodes.scene.keys.parts.rigging import Equaliser

SPREAD = 1e-6  # [m] less: what holds a frame tells nothing of where it points
HALVINGS = 60


def equalising(
    name: str, given: Equaliser, sheave: k.Point, R: np.ndarray, ends: tuple[k.Point, k.Point], at: kinematics.Poses
) -> Reeving:
    """The rope of an equaliser over its sheave on a body of attitude R, that turns as the rope runs."""
    p, q = (kinematics.place(end, at).tolist() for end in ends)
    d = norm([q[0] - p[0], q[1] - p[1]])
    axis = [(p[1] - q[1]) / d, (q[0] - p[0]) / d, 0.0] if d > SPREAD else [0.0, 1.0, 0.0]
    x, y, z = (sum(float(R[j][i]) * axis[j] for j in range(3)) for i in range(3))
    over = Sheave(sheave, (x, y, z), given.radius, given.friction, given.efficiency)
    return Reeving(name, ends[0], (over,), ends[1], given.sling.EA, Signal(given.length))


def height_of(
    make: Callable[[float], Reeving], low: float, length: float, slack: float, at: kinematics.Poses, what: str
) -> float:
    """The z above `low` at which what holds a rope over something hangs if the rope has some slack [m]; raises
    ValueError with a sentence where it cannot run, or does not reach `what`."""

    def long(z: float) -> float:
        try:
            return ReevingLaw().start_length(make(z), lambda body: (at[body][1], at[body][0]))
        except KernelError as error:
            raise ValueError(str(error)) from None

    if long(low) > length - slack:
        raise ValueError(f"{length:g} m of rope with {slack:g} m of slack do not reach {what}")
    high = low + length
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if long(middle) > length - slack else (middle, high)
    return low
