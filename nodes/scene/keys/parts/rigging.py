"""Rigging on the hooks of machines: a tree of slings, equalisers and frames, down to the lugs of a block.

Ends are given by words: `jib main` is a hook, `F1` a lug of the block, `beam.west` a point of the frame `beam`, and
`beam` alone the origin of the frame.
"""

from typing import Annotated, Literal

from heavylift.nodes.scene.keys.base import Base, Name, Place
from heavylift.nodes.scene.text import units as u
from pydantic import Discriminator, Field, Tag


class Edge(Base):
    """A rounded edge of a body over which ropes may bend, given by its axis from end to end.

    A rope slides freely along the edge; over it the ratio of tensions is exp(friction * wrap). The edges over which one
    rope bends must be parallel and stay so: on the same body, or on bodies that slide along one another or turn about
    the direction of the edges.
    """

    on: str
    start: Place = Field(alias="from")
    end: Place = Field(alias="to")
    radius: u.Extent
    friction: u.Ratio = 0.0
    inside: Place | None = None  # a point behind the edge as ropes see it; left out: the body's centre of mass


Termination = Literal[
    "ferrule", "aluminium ferrule", "spliced", "resin", "swaged", "cable-laid splice", "grommet"
]  # a row of `TERMINATIONS` each


class SlingType(Base):
    """The wire rope of a sling; the default is one of 96 mm diameter."""

    EA: u.Force = u.FORCE.read("445 MN")
    breaking: u.Force = u.FORCE.read("6.43 MN")
    WLL: u.Mass | None = None  # of one leg, as its certificate tells it
    termination: Termination | None = None  # left out: by EN 13414-1 a ferrule, by 0027/ND a hand splice, assumed
    diameter: u.Extent | None = None
    pin: u.Extent | None = None  # the smallest diameter that it is bent over; left out: 4 of its own, assumed
    legs: Literal["assembly", "single"] = "assembly"  # of several on one hook: bought as one, or chosen singly
    wear: u.Factor | None = None  # left out: 1.2 by 0027/ND 7.9.4
    factor: u.Factor = 5.0  # breaking force over its tension at rest; left out: by EN 13414-1 and its termination
    partial_factor: u.Factor | None = None  # breaking force over its largest tension; left out: by 0027/ND 7.3.1
    damping: u.Ratio = 0.05  # of critical, with half of its beam; assumed


class SlingKeys(Base):
    """Slings from hooks or frames to lugs of the block or to frames below, hooked at the start."""

    type: Literal["slings"] = "slings"
    on: str | Annotated[list[str], Field(min_length=1)]  # for all slings, or for each: hook, frame, point of a frame
    to: Annotated[list[str], Field(min_length=1)]  # of each: lug, frame, point of a frame
    length: u.Extent | list[u.Extent]  # of each sling
    slack: u.Gap = u.LENGTH.read("0.3 m")  # of the one that is tightest at the start; those that carry a frame: none
    sling: SlingType = SlingType()
    shackle: u.Mass | None = None  # what its shackles may carry, each; left out: they are not checked
    over_edges: list[str] = Field(default_factory=list)  # that they bend over where they meet them

    @property
    def holders(self) -> list[str]:
        """The name in the scene of the place to which each sling's upper end is attached."""
        return self.on if isinstance(self.on, list) else [self.on] * len(self.to)

    @property
    def lengths(self) -> list[float]:
        """The length of each sling [m]."""
        return self.length if isinstance(self.length, list) else [self.length] * len(self.to)


class Equaliser(Base):
    """A rope from one lug over a sheave to another lug; both ends carry the same load except for friction."""

    type: Literal["equaliser"]
    on: str  # where the sheave hangs: hook, frame, point of a frame
    to: tuple[str, str]
    length: u.Extent  # of the whole rope
    slack: u.Gap = u.LENGTH.read("0.3 m")  # at the start
    radius: u.Gap = 0.0  # of the sheave
    friction: u.Ratio = 0.0  # of the rope on it
    efficiency: u.Ratio = 1.0  # tension behind it over tension before
    sling: SlingType = SlingType()
    shackle: u.Mass | None = None  # what its shackles may carry, each; left out: they are not checked

    @property
    def holders(self) -> list[str]:
        """The name in the scene of the place to which the sheave is attached."""
        return [self.on]


class Frame(Base):
    """A rigid body between slings above and slings below it: spreader, lifting beam, or master link of a bridle."""

    type: Literal["spreader", "lifting beam", "link"]
    mass: u.Mass
    size: tuple[u.Extent, u.Extent, u.Extent]  # gives the moments of a uniform box, and is drawn
    com: Place = (0.0, 0.0, 0.0)  # from its middle
    points: dict[Name, Place] = Field(default_factory=dict)  # from its middle, where slings are
    capacity: u.Mass | None = None  # of what hangs below it; left out: it is not checked
    lug_capacity: u.Mass | None = None  # of each point; left out: they are not checked


class GearKeys(Base):
    """An item of rigging gear with an ID, which scenes use by `gear: ID`."""

    kind: Literal["sling", "shackle", "spreader", "lifting beam", "link"]
    WLL: u.Mass | None = None  # of one leg, of each shackle, of what hangs below a frame
    standard: str = ""  # by which it is rated: EN 13889
    certificate: str = ""  # its date
    mass: u.AnyMass | None = None
    EA: u.Force | None = None
    breaking: u.Force | None = None
    termination: Termination | None = None
    diameter: u.Extent | None = None
    length: u.Extent | None = None  # of a sling
    size: tuple[u.Extent, u.Extent, u.Extent] | None = None  # of a frame
    at: list[str] = Field(default_factory=list)  # where the scene uses it; made of the scene, not to be written


def _type(given: object) -> str:
    """Return the name of the model of keys that reads a rigging entry."""
    word = given.get("type", "slings") if isinstance(given, dict) else getattr(given, "type", "slings")
    return "frame" if word in ("spreader", "lifting beam", "link") else str(word)


Rigging = Annotated[
    Annotated[SlingKeys, Tag("slings")] | Annotated[Equaliser, Tag("equaliser")] | Annotated[Frame, Tag("frame")],
    Discriminator(_type),
]
