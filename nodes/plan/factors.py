"""Factors that lead from the static load to the design load, for which hooks, slings, shackles and lugs are chosen."""

from typing import Annotated, Literal, TypeAlias

from heavylift.kernel.description.units import Area, Gap, Unit

from .actions import Item

AtLeastOne: TypeAlias = Annotated[float, Unit("ratio", "one")]
Practice: TypeAlias = Literal["none", "0027/ND"]
Place: TypeAlias = Literal["onshore", "inshore", "offshore"]


class Factors(Item, frozen=True, kw_only=True):
    """The load factors of a lift as given in a scene.

    An omitted factor is taken from the practice (standard) of the lift, if its clause is known."""

    place: Place | None = None  # where it is; left out: onshore, unless something floats
    rigging: Annotated[float, Unit("mass", "zero")] | None = None  # slings and shackles on each hook; else of the gear
    weight: AtLeastOne | None = None  # contingency of the weight
    cog: tuple[Gap, Gap, Gap] | None = None  # half edges of the box that the centre of mass is in, along u, v, w
    cog_factor: AtLeastOne | None = None  # instead of that box
    dynamic: AtLeastOne | None = None  # dynamic amplification of the load at rest
    dynamics: Literal["included", "not included"] | None = None  # in capacities and charts of hooks
    tilt: Annotated[float, Unit("angle", "positive")] | None = None  # of a load on two hooks
    tilt_factor: AtLeastOne | None = None  # instead of that angle
    heights: AtLeastOne | None = None  # of a load on more than three hooks, for the tolerance of their heights
    yaw: AtLeastOne | None = None  # of two hooks, where several slings hang on one
    skew: AtLeastOne | None = None  # of four and more slings from one hook to a rigid load
    consequence: AtLeastOne | None = None  # of lugs
    wind: Annotated[float, Unit("speed", "zero")] | None = None  # on the load; 0: in no wind
    area: Area = 0.0  # of the load in that wind; left out: of the largest face of its box
    drag: Annotated[float, Unit("ratio", "zero")] = 1.2  # its coefficient
    tandem: AtLeastOne | None = None  # capacity over the share of each crane of several


class Factor(Item, frozen=True, kw_only=True):
    """A load factor: name, value and source."""

    name: str
    value: float
    source: str
