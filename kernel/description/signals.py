"""The scalar signals of a scene, which can be sampled and guarded by thresholds."""

from dataclasses import dataclass
from typing import Literal

from .units import Point

Quantity = Literal[
    "height", "height difference", "height over", "tension", "load", "vertical load", "moment", "angle", "joint",
    "speed", "length", "wind", "swing along", "swing across", "boom lead", "side lead", "off-lead", "slope", "radius",
    "gap", "use", "use by place", "pull", "reserve", "side along", "side across", "place along", "place across",
    "track pressure", "corner load", "tipping", "joint moment", "starting moment", "overhang",
]  # fmt: skip


@dataclass(frozen=True)
class ScalarSignal:
    """A scalar quantity of a scene, such as a height, a tension or an angle, that can be sampled.

    "height"        of `point` in the world [m]; "height difference": above `origin` [m];
                    "height over": above it along the z axis of its body [m]
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
                    its lower end is ahead in +x or +y; "off-lead": the angle in the rope's own vertical plane;
                    "slope": the same, whichever end is the upper one
    "boom lead", "side lead": the same in the vertical plane of a boom, through `origin` and the upper end of ropes[0],
                    positive outwards, and across that plane, positive to its left [rad]
    "vertical load" vertical part of the tension of ropes[0] times numbers[0]
    "pull"          force in the part at the upper end of ropes[0]: numbers[0] times its tension plus
                    numbers[1] [N/m] times its length [N]; "reserve": numbers[2] over this force [1]
    "side along", "side across": sum of the pulls of `ropes` at their lower ends in +x or +y [N]
    "place along", "place across": world x or y of `point`, less numbers[0] [m]
    "track pressure", "corner load": below the left (1) or right (-1) track, or a corner, of the base whose middle is
                    `point`, by the weights of all that stands on it and the ropes that pull at that; `numbers`: cosine
                    and sine of an angle by which all that is slewed, length and width of the base [m], breadth of a
                    track [m] and its side, or the corner ahead or astern and left or right (1, -1), and what the
                    pressure [Pa] or load [N] is multiplied by and then increased by
    "tipping"       distance of that force from `point` over that at which it tips or, if numbers[4] is above zero, at
                    which a corner loses contact; the other numbers as before
    "joint moment"  of weights and rope pulls on all that joint `of` carries, about its axis [N m]; "starting moment":
                    with that which accelerates it at numbers[0] [rad/s2]

    "overhang"      how far `point` is below the plane z = 0 of the body of `origin`, or beside the face in it of half
                    edges `numbers` (2), whichever is less [m]; 0 above the plane and on the face

    If the lines of a rope run in several directions, only those that end on the body of `point` count; with both
    `origin` and `point` the line between them is used, except by the leads of booms.
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
    """Base class of all items of a description that have a name."""

    name: str


@dataclass(frozen=True)
class Threshold(ScalarSignal, Named):
    """An event condition on a scalar signal: reports when the signal crosses a value that is set at run time."""


def guard_of(name: str, x: ScalarSignal) -> Threshold:
    """Return the threshold that watches a scalar signal."""
    return Threshold(name, **vars(x))
