"""Table of scalar signals of a scene, which can be sampled and guarded by thresholds."""

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
    "gap"           between the boxes about `point` and `origin`, of half edges `numbers` (6) [m]: a
                    lower bound of their distance, a fifth less for long boxes; negative where they overlap
    "tension"       sum over `ropes` [N]; "length": unstretched length of ropes[0] [m]
    "load"          tension of `ropes` times numbers[0], less numbers[1] [kg, or 1 as a share of the rated load]
    "moment"        tension of `ropes` over that allowed by a load chart at the next longer radius of `point`;
                    `numbers`: the tension [N] of the empty hook, then radii [m] and tensions [N]
    "use"           the largest tension of `ropes`, each times its number [1, of the rated tension]
    "use by place"  load of `ropes` over that allowed by a chart at the world y of `point`, interpolated;
                    `numbers`: two as of "load", then places [m] and allowed loads
    "angle"         of body `of` about `axis`, as Measured [rad]
    "joint", "speed": coordinate and velocity of joint `of`
    "wind"          speed of the wind force `of` [m/s], which blows on `point`
    "swing along", "swing across": angle of ropes[0] to the vertical in the planes x, z and y, z [rad], positive if
                    its lower end is ahead in +x or +y; "off-lead": the angle in the rope's own vertical plane
    "pull"          force in the part at the upper end of ropes[0]: numbers[0] times its tension plus
                    numbers[1] [N/m] times its length [N]; "reserve": numbers[2] over this force [1]
    "side along", "side across": sum of the pulls of `ropes` at their lower ends in +x or +y [N]
    "place along", "place across": world x or y of `point`, less numbers[0] [m]

    If the lines of a rope run in several directions, only those that end on the body of `point` count; without ropes
    the line from `origin` to `point` is used.
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
    """Base class of all described items that have a name."""

    name: str


@dataclass(frozen=True)
class Threshold(ScalarSignal, Named):
    """A guard on a signal: reports when the signal crosses a value that is set at run time."""


def guard_of(name: str, x: ScalarSignal) -> Threshold:
    """Return the threshold that guards a signal."""
    return Threshold(name, **vars(x))
