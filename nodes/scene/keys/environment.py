"""The keys for the environment of a scene's machines: `waves:` and `vessels:`, `floor:` and `obstacles:`, `wind:`.

Waves are regular, or a sum of irregular seas. A vessel's axes are x to its bow, y to port, z up; its
origin lies on the waterline at rest, and all responses refer to it. The phase of a response is counted from the wave's
elevation at the origin: cos(w t + phase).

Blocks have rigid contacts with friction with the floor and obstacles.

The wind becomes forces of a mechanism. Turbulence has the spectrum of EN 1991-1-4, B.1: n S / s² = 6.8 f / (1 + 10.2
f)^(5/3), f = n L / v, with the frequency n, the spectral density S, the mean speed v, the standard deviation s and the
length scale L. It is generated as a sum of harmonics with random frequencies and phases (Shinozuka and Deodatis,
Applied Mechanics Reviews 44 (1991) 191-204) and stored as one speed per second. Periods longer than twenty minutes or
shorter than two seconds are omitted.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import pi, sqrt
from random import Random
from typing import Annotated, Literal

from heavylift.kernel.algebra.dense import product
from heavylift.kernel.algebra.elementary import cos, power
from heavylift.kernel.description.mechanics import Matrix, Vector
from heavylift.nodes.scene.text import units as u
from heavylift.nodes.sea.spectra import Component
from pydantic import Field, model_validator

from .base import Base, Direction, Place, turned
from .parts.forces import Matrix6, WindForceKeys
from .parts.mechanics import Moments
from .seas import Sea, StreamKeys

Response = tuple[Annotated[float, u.Quantity(u.RESPONSE, "zero")], u.Angle]
TurnResponse = tuple[Annotated[float, u.Quantity(u.TURN_RESPONSE, "zero")], u.Angle]
LoadResponse = tuple[u.Stiffness, u.Angle]
MomentResponse = tuple[Annotated[float, u.Quantity(u.MOMENT_RESPONSE, "zero")], u.Angle]
BLOCK = "block"
QUANTILE = r"^(MPM|P[1-9][0-9]?(\.[0-9]+)?)$"
USUAL, LONGEST = 7200.0, 86400.0  # [s] of a history, where no end is given, and of any; then its last speed goes on
HARMONICS = 128
BANDS = 500  # of half a per cent of the frequency
SLOWEST, FASTEST = 1.0 / 1200.0, 0.5  # [Hz] of them; half of one speed a second


class Waves(Base):
    """A regular wave, or several irregular seas acting together."""

    height: u.Extent | None = None  # from trough to crest
    period: u.Duration | None = None
    seas: dict[str, Sea] = Field(default_factory=dict)  # such as {wind: {...}, swell: {...}}
    heading: u.Angle = 0.0  # to which it travels, from x towards y; 180 deg: against a bow that points along x
    ramp: u.Duration = 30.0  # in which it grows
    depth: u.Extent | None = None  # of the water; left out: deep
    origin: Place = (0.0, 0.0, 0.0)  # where its elevation goes with the cosine of time
    density: u.Density = 1025.0  # of the water
    quantile: Annotated[str, Field(pattern=QUANTILE)] = "P90"  # of an irregular sea that a verdict means; MPM: the mode
    duration: u.Duration | None = None  # of the operation that it is for, if stationary; left out: that of the scene

    @model_validator(mode="after")
    def _one(self) -> "Waves":
        if bool(self.seas) == bool(self.height and self.period) or (self.height is None) != (self.period is None):
            raise ValueError("waves are either regular, with 'height' and 'period', or irregular, with 'seas'")
        return self

    @property
    def regular(self) -> tuple[float, float]:
        """Amplitude [m] and frequency [rad/s] of a regular wave; zero for irregular seas."""
        return (0.5 * self.height, 2.0 * pi / self.period) if self.height and self.period else (0.0, 0.0)

    def harmonics(self, seed: int) -> list[Component]:
        """Return the harmonic components of all seas together."""
        return [x for name, sea in sorted(self.seas.items()) for x in sea.harmonics(self.heading, f"{seed} {name}")]

    def bands(self) -> list[Component]:
        """Return the harmonic components of all seas in narrow frequency bands, independent of the seed of a run."""
        fine = {name: sea.model_copy(update={"components": BANDS}) for name, sea in self.seas.items()}
        return self.model_copy(update={"seas": fine}).harmonics(0)


class Responses(Base):
    """Motions of a vessel's origin per wave amplitude, with their phases."""

    surge: Response = (0.0, 0.0)
    sway: Response = (0.0, 0.0)
    heave: Response = (0.0, 0.0)
    roll: TurnResponse = (0.0, 0.0)
    pitch: TurnResponse = (0.0, 0.0)
    yaw: TurnResponse = (0.0, 0.0)


class LoadResponses(Base):
    """Wave forces and moments about a vessel's origin per wave amplitude, with their phases."""

    surge: LoadResponse = (0.0, 0.0)
    sway: LoadResponse = (0.0, 0.0)
    heave: LoadResponse = (0.0, 0.0)
    roll: MomentResponse = (0.0, 0.0)
    pitch: MomentResponse = (0.0, 0.0)
    yaw: MomentResponse = (0.0, 0.0)


class Mooring(Base):
    """Stiffness of a mooring at the origin of its vessel."""

    surge: u.Stiffness = 0.0
    sway: u.Stiffness = 0.0
    yaw: u.TurnStiffness = 0.0


class Floating(Base):
    """Hydrostatics and hydrodynamics of a vessel; matrices are in SI units, with rows and columns from surge to yaw."""

    hydrodynamics: str = (
        ""  # a file of the hull beside the scene, or a bundled one; it replaces the next keys and `loads`
    )
    beside: str = ""  # in place of it: another vessel, whose file has this one as its second hull
    waterplane: Annotated[float, u.Quantity(u.AREA, "positive")] | None = None
    GM: u.Extent | None = None  # of roll, with all that stands on it at the start
    GML: u.Extent | None = None  # of pitch
    added_mass: Matrix6 | None = None  # at the wave's frequency, as `damping`
    damping: Matrix6 | None = None
    current: StreamKeys | None = None  # its coefficients of that of the scene
    wind: StreamKeys | None = None
    mooring: Mooring = Mooring()
    loads: LoadResponses = LoadResponses()  # of the wave

    @model_validator(mode="after")
    def _one(self) -> "Floating":
        missing = [key for key in ("waterplane", "GM", "GML") if getattr(self, key) is None]
        if self.hydrodynamics and self.beside:
            raise ValueError("'beside' names the vessel whose file has the hydrodynamics: leave 'hydrodynamics' out")
        if (self.hydrodynamics or self.beside) and (
            len(missing) < 3 or self.added_mass or self.loads != LoadResponses()
        ):
            raise ValueError("'hydrodynamics' gives waterplane, GM, GML, added mass and loads: leave them out")
        if self.current and (self.current.height or 0.0) > 0.0:
            raise ValueError("current: its centre of pressure is in the water: give a 'height' of 0 m or less")
        if self.wind and (self.wind.height or 0.0) < 0.0:
            raise ValueError("wind: its centre of pressure is above the water: give a 'height' of 0 m or more")
        if missing and not (self.hydrodynamics or self.beside):
            raise ValueError(f"a floating vessel needs '{missing[0]}', or a file with its 'hydrodynamics'")
        return self


class Vessel(Base):
    """A vessel whose motion in waves is either `given` by responses, or computed from `forces` on a free body."""

    mass: u.Mass  # without what stands on it
    size: tuple[u.Extent, u.Extent, u.Extent]  # of its hull, a uniform box unless `inertia` is given
    draught: u.Extent
    at: Place = (0.0, 0.0, 0.0)  # its origin
    heading: u.Angle = 0.0  # where its bow points, from x towards y; what stands on it turns with it
    com: Place = (0.0, 0.0, 0.0)
    inertia: Moments | None = None  # about its centre of mass
    motion: Literal["given", "forces"] = "given"
    responses: Responses | None = None  # if it is given
    floating: Floating | None = None  # if it follows from forces

    @property
    def attitude(self) -> Matrix:
        """Rotation matrix from the axes of a vessel at rest to the world frame."""
        return turned(0.0, 0.0, self.heading)

    def place(self, p: Sequence[float]) -> Vector:
        """Return the world position [m] of a point on a vessel at rest."""
        x, y, z = (a + b for a, b in zip(product(self.attitude, p), self.at, strict=True))
        return x, y, z

    @model_validator(mode="after")
    def _one(self) -> "Vessel":
        needs, other = ("responses", "floating") if self.motion == "given" else ("floating", "responses")
        if getattr(self, needs) is None:
            raise ValueError(f"motion: {self.motion} needs '{needs}'")
        if getattr(self, other) is not None:
            raise ValueError(f"motion: {self.motion} needs no '{other}': leave it out")
        return self


class Floor(Base):
    """A level floor that all blocks can touch."""

    height: u.Length = 0.0
    friction: u.Ratio = 0.0
    restitution: u.Ratio = 0.0


class Obstacle(Base):
    """A fixed box in the yard or on a vessel, such as a wall, a guide or a quay, that all blocks can touch."""

    box: tuple[u.Extent, u.Extent, u.Extent]
    at: Place  # its middle, in the frame of what it is on
    rotation: tuple[u.Angle, u.Angle, u.Angle] = (0.0, 0.0, 0.0)  # about x, then y, then z
    on: str = "world"  # or a vessel
    meets: Literal["boxes", "corners", "lower corners"] = "boxes"  # lower corners of blocks cost half, and miss its own
    overlap: u.Gap = 0.0  # of a block's box with its own that is meant, where corners meet; more is red
    friction: u.Ratio = 0.0
    restitution: u.Ratio = 0.0
    stiffness: u.Stiffness = 0.0  # that a block meets as it hits it; left out: the force is not checked
    capacity: u.Force | None = None  # that it bears; left out: not checked

    @model_validator(mode="after")
    def _overlaps(self) -> "Obstacle":
        if self.overlap and self.meets == "boxes":
            raise ValueError("'overlap' does not apply to whole boxes: remove it, or write 'meets: lower corners'")
        return self


class Fender(Base):
    """A fender, which pushes a point of a vessel away from its face and holds the point along the face by friction."""

    on: str = "world"  # a quay, or a vessel
    at: Place  # of the middle of its face, in the frame of what it is on
    size: tuple[u.Extent, u.Extent] | None = None  # width and height of its face; left out: it has no ends
    facing: Direction  # away from what it is on
    vessel: str  # that leans on it
    meets: Place  # point of this vessel
    stiffness: u.Stiffness
    damping: u.Damping = 0.0
    friction: u.Ratio = 0.0
    capacity: u.Force | None = None  # its rated reaction; left out: it is not checked


class Area(Base):
    """Projected areas of a body, seen along its axes."""

    sides: tuple[u.Area, u.Area, u.Area]
    drag: u.Ratio | None = None  # left out: that of the wind


class WindKeys(Base):
    """Wind on the block, with the sides of its box as areas, and on other bodies, with the areas given in `on`."""

    speed: u.Velocity
    direction: Direction  # to which it blows
    gusts: list[tuple[u.Instant, u.Velocity]] = Field(default_factory=list)  # speeds over time, in place of one
    turbulence: Annotated[u.Ratio, Field(le=0.5)] = 0.0  # standard deviation over speed; by the scene's seed
    scale: u.Extent = u.LENGTH.read("130 m")  # of turbulence; EN 1991-1-4 at 40 m over open country
    drag: u.Ratio = 1.2  # of a box; assumed
    density: u.Density = 1.225
    on: dict[str, Area] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _one(self) -> "WindKeys":
        if self.gusts and self.turbulence:
            raise ValueError("give the wind either 'gusts' or a 'turbulence'")
        if not any(self.direction):
            raise ValueError("the direction of the wind is a zero vector; give one component other than 0")
        return self

    def history(self, seed: int, end: float | None) -> list[tuple[float, float]]:
        """Return the wind speeds [m/s] over time [s]; empty for a steady wind."""
        return turbulent(self.speed, self.turbulence, self.scale, seed, end) if self.turbulence else self.gusts

    def forces(
        self, block: tuple[float, float, float] | None, seed: int, end: float | None
    ) -> dict[str, WindForceKeys]:
        """Return the wind forces on the block and on other bodies, by the name of the force law.

        `block`: edges of the block's box [m], or None; `end`: end of the run [s], if known."""
        areas = dict(self.on)
        if block is not None:
            x, y, z = block
            areas.setdefault(BLOCK, Area.model_construct(sides=(y * z, z * x, x * y)))
        gusts = self.history(seed, end)
        return {
            f"wind.{body}": WindForceKeys.model_construct(
                type="wind",
                body=body,
                sides=area.sides,
                drag=self.drag if area.drag is None else area.drag,
                direction=self.direction,
                speed=self.speed,
                gusts=gusts,
                density=self.density,
            )
            for body, area in sorted(areas.items())
        }


def turbulent(speed: float, turbulence: float, scale: float, seed: int, end: float | None) -> list[tuple[float, float]]:
    """Return pairs of time [s] and speed [m/s] of a turbulent wind with the mean speed `speed` [m/s]."""
    random = Random(f"wind {seed}")
    ends = [SLOWEST * float(power(FASTEST / SLOWEST, i / HARMONICS)) for i in range(HARMONICS + 1)]
    speeds = [speed] * (int(min(end or USUAL, LONGEST)) + 2)
    for low, high in pairwise(ends):
        n = low + (high - low) * random.random()  # so that it never comes again
        f = n * scale / abs(speed) if speed else 0.0
        s = turbulence * speed
        S = s * s / n * 6.8 * f / float(power(1.0 + 10.2 * f, 5.0 / 3.0))
        size, w, phase = sqrt(2.0 * S * (high - low)), 2.0 * pi * n, 2.0 * pi * random.random()
        turn, here, following = 2.0 * float(cos(w)), size * float(cos(phase)), size * float(cos(w + phase))
        for t in range(len(speeds)):
            speeds[t] += here
            here, following = following, turn * following - here  # cos(a + w) = 2 cos w cos a - cos(a - w)
    return [(float(t), v) for t, v in enumerate(speeds)]
