"""What can be sampled of a scene, and what thresholds guard: one table of quantities."""

from dataclasses import dataclass
from typing import Literal

from .units import Point

Quantity = Literal[
    "height", "height difference", "tension", "load", "moment", "angle", "joint", "speed", "length", "wind",
    "swing along", "swing across", "off-lead", "radius", "gap", "use", "use by place",
    "pull", "reserve", "side along", "side across", "place along", "place across",
]  # fmt: skip


@dataclass(frozen=True)
class ScalarSignal:
    """A scalar of a scene.

    "height"        of `point` in the world [m]; "height difference": above `origin` [m]
    "radius"        of `point`: its horizontal distance from `origin` [m]
    "gap"           between the boxes about `point` and `origin`, of half edges `numbers` (6) [m]: never more than
                    their distance, of long ones a fifth less; negative where they overlap
    "tension"       sum over `ropes` [N]; "length": unstretched length of ropes[0] [m]
    "load"          their tension times numbers[0], less numbers[1] [kg, or 1 as a share of what is rated]
    "moment"        their tension over what a chart by the radius of `point` allows: of the next longer radius;
                    `numbers`: the tension [N] up to which nothing hangs there, then radii [m] and tensions [N]
    "use"           the largest of their tensions, each times its number [1, of what is rated]
    "use by place"  their load over what a chart by the world y of `point` allows, interpolated; `numbers`: two as of
                    "load", then places [m] and what is allowed there
    "angle"         of body `of` about `axis`, as Measured [rad]
    "joint", "speed": coordinate and velocity of joint `of`
    "wind"          speed of the wind force `of` [m/s], which blows on `point`
    "swing along", "swing across": angle of ropes[0] to the vertical in the planes x, z and y, z [rad], positive where
                    its lower end is ahead in +x or +y; "off-lead": in its own plane
    "pull"          in the part at the upper end of ropes[0]: numbers[0] times its tension, and numbers[1] [N/m] times
                    its length [N]; "reserve": numbers[2] over that [1]
    "side along", "side across": what `ropes` pull together in +x or +y where their lower ends are [N]
    "place along", "place across": world x or y of `point`, less numbers[0] [m]

    Of a rope whose lines go several ways `point` tells on which body those end that count; without ropes the line is
    that from `origin` to `point`.
    """

    quantity: Quantity
    of: str = ""
    point: Point | None = None
    ropes: tuple[str, ...] = ()
    axis: int = 0
    coordinate: str = ""  # of a joint that has several
    origin: Point | None = None
    numbers: tuple[float, ...] = ()


@dataclass(frozen=True)
class Named:
    """Base of named items."""

    name: str


@dataclass(frozen=True)
class Threshold(ScalarSignal, Named):
    """A guard on a signal that reports when it crosses a value set at run time."""


def guard_of(name: str, x: ScalarSignal) -> Threshold:
    """The threshold that guards a signal."""
    return Threshold(name, **vars(x))
