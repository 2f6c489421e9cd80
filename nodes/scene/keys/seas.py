"""The keys of an irregular sea in a scene, the shape of its spectrum, its direction and its components; loads of the
water on a block that passes the splash zone."""

from itertools import pairwise
from math import pi
from typing import Annotated, Literal

from heavylift.kernel.description.forces import InputSignal, Stream
from heavylift.kernel.description.mechanics import Point
from heavylift.nodes.scene.text import units as u
from heavylift.nodes.sea.spectra import HIGHEST, LOWEST, Component, Density, between, components, jonswap, torsethaugen
from pydantic import Field, model_validator

from .base import Base, Direction, unit

EVEN = 1e-6  # [rad] of directions in equal steps

Push = Annotated[float, u.Quantity(u.FORCE, "zero")]


class Sea(Base):
    """An irregular sea, which may be a wind sea or a swell."""

    spectrum: Literal["jonswap", "pierson-moskowitz", "torsethaugen"] = "jonswap"  # torsethaugen: two peaks
    Hs: u.Extent  # significant wave height
    Tp: u.Duration | None = None  # peak period
    table: list[tuple[u.Frequency, u.Ratio]] = Field(default_factory=list)  # in place of Tp: densities, scaled to Hs
    gamma: Annotated[u.Ratio, Field(ge=1.0, le=10.0)] = 3.3  # of JONSWAP's peak
    heading: u.Angle | None = None  # left out: that of the waves
    spreading: Annotated[u.Ratio, Field(le=50.0)] = 0.0  # s of cos^2s about the heading; 0: long crests
    components: int = Field(default=200, ge=10, le=2000)

    def harmonics(self, heading: float, seed: str) -> list[Component]:
        """Return the harmonic components of the sea, with random phases that the seed determines."""
        parts, to = self._parts(), heading if self.heading is None else self.heading
        n = self.components // len(parts)
        named = [(x, seed if i == 0 else f"{seed} {i}") for i, x in enumerate(parts)]
        return [x for part, own in named for x in components(*part, n, to, self.spreading, own)]

    def _parts(self) -> list[tuple[Density, float, tuple[float, float]]]:
        """Return, for each peak that is scaled alone, its density S(w), its height, and its lowest and highest
        frequency [rad/s]."""
        if self.table:
            table = [(2.0 * pi * f, x) for f, x in self.table]
            return [(lambda w: between(table, w), self.Hs, (table[0][0], table[-1][0]))]
        T, gamma = self.Tp or 1.0, self.gamma if self.spectrum == "jonswap" else 1.0
        if self.spectrum == "torsethaugen":
            return [(x.density, x.Hs, _ends(x.Tp)) for x in torsethaugen(self.Hs, T)]
        return [(lambda w: jonswap(w, self.Hs, T, gamma), self.Hs, _ends(T))]

    @model_validator(mode="after")
    def _shaped(self) -> "Sea":
        if bool(self.table) == (self.Tp is not None):
            raise ValueError("a sea has either a peak period 'Tp' or a 'table' of spectral densities")
        frequencies = [f for f, _ in self.table]
        if self.table and (frequencies != sorted({*frequencies}) or len(frequencies) < 2):
            raise ValueError("frequencies of the 'table' must be in ascending order, at least two")
        if self.table and not any(x for _, x in self.table):
            raise ValueError("the densities of the 'table' are all zero; give one above zero")
        return self


class CurrentKeys(Base):
    """A uniform water current, which exerts forces on vessels that have current coefficients."""

    speed: u.Speed
    heading: u.Angle = 0.0  # to which it flows, from x towards y; 0 deg relative to the bow: from astern
    density: u.Density = 1025.0


class StreamKeys(Base):
    """Coefficients of wind or current forces on a vessel that is symmetric about its centre plane.

    A coefficient is a force divided by 1/2 density speed^2 area, or a moment divided by the same and by the length."""

    area: u.Area
    length: u.Extent
    height: u.Length | None = None  # of the centre of pressure over the waterline, negative in water; left out: 0 m
    coefficients: list[
        tuple[u.Angle, u.Number, u.Number, u.Number]
    ]  # to where it goes, 0 deg from astern; surge, sway, yaw

    @model_validator(mode="after")
    def _even(self) -> "StreamKeys":
        n = len(self.coefficients) - 1
        if n < 1 or any(abs(row[0] - pi * i / n) > EVEN for i, row in enumerate(self.coefficients)):
            raise ValueError("coefficients: give one row for each direction, from 0 deg to 180 deg in equal steps")
        if any(self.coefficients[0][2:] + self.coefficients[-1][2:]):
            raise ValueError("coefficients of sway and yaw must be zero at 0 deg and 180 deg")
        return self

    def stream(self, vessel: str, of: str, direction: Direction, signal: InputSignal, density: float) -> Stream:
        """Return the force of the wind or current on a vessel."""
        rows = tuple((x, y, z) for _, x, y, z in self.coefficients)
        size, at = (self.area, self.length), Point(vessel, (0.0, 0.0, self.height or 0.0))
        return Stream(f"{vessel}.{of}", at, *size, unit(direction), signal, density, rows)


def _ends(Tp: float) -> tuple[float, float]:
    peak = 2.0 * pi / Tp
    return LOWEST * peak, HIGHEST * peak


class Splash(Base):
    """Water loads on a block that is lowered upright into the water, as functions of the depth of its lowest point."""

    level: u.Length = 0.0  # height of still water
    buoyancy: Annotated[list[tuple[u.Gap, Push]], Field(min_length=2)]  # upward; the last one holds below
    # of slam, drag and inertia, such as by DNV-RP-N103: not applied, but checks count it upward and downward
    amplitude: list[tuple[u.Gap, Push]] = Field(default_factory=list)

    @model_validator(mode="after")
    def _curves(self) -> "Splash":
        for name, curve in (("buoyancy", self.buoyancy), ("amplitude", self.amplitude)):
            if any(b[0] <= a[0] for a, b in pairwise(curve)):
                raise ValueError(f"the depths of '{name}' must be in ascending order")
        if self.buoyancy[0] != (0.0, 0.0):
            raise ValueError("'buoyancy' must begin at the depth 0 m with 0 kN")
        return self
