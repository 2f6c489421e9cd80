"""Quantities with units, such as `900 t`, `3 m/min`, `0.15 deg/s`, and the pydantic types that read them into SI units.

A number without a unit is refused where a unit is needed (0 needs none), and the message for a unit of another
dimension names that dimension. `Dimension.read` raises ValueError with one sentence, for scene values and for action
phrases alike. Conversion factors are exact and a quantity is rounded only once, so `300 t` and `300000 kg`, or `0.3
m/min` and `5 mm/s`, are equal numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Literal

from .spelling import number_and_unit, punctuation, spelled

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

SMALL, LARGE = 1e-30, 1e30  # between which products of several quantities neither vanish nor overflow
LEAST = 5e-324
_DEGREE = Fraction(math.pi / 180)  # as `math.radians` has it
_MINUTE, _KILO, _MILLI = Fraction(60), Fraction(1000), Fraction(1, 1000)
_ONE, _MEGA, _GIGA = Fraction(1), _KILO**2, _KILO**3
_FOOT, _POUND = Fraction(3048, 10_000), Fraction(45_359_237, 10**8)  # by definition since 1959
_INCH, _LBF = _FOOT / 12, _POUND * Fraction(980_665, 10**5)
_KIP = _KILO * _LBF

CUSTOMARY = {  # units of the United States and of sailors: read, but not offered
    "length": {"ft": _FOOT, "in": _INCH},
    "mass": {"lb": _POUND},
    "force": {"lbf": _LBF, "kip": _KIP},
    "moment": {"lbf ft": _LBF * _FOOT, "kip ft": _KIP * _FOOT},
    "speed": {"ft/min": _FOOT / _MINUTE, "ft/s": _FOOT, "kn": Fraction(1852, 3600)},
    "acceleration": {"ft/s2": _FOOT},
    "moment of inertia": {"lb ft2": _POUND * _FOOT**2},
    "stiffness": {"lbf/in": _LBF / _INCH, "kip/in": _KIP / _INCH},
    "area": {"ft2": _FOOT**2, "in2": _INCH**2},
    "density": {"lb/ft3": _POUND / _FOOT**3},
    "mass per length": {"lb/ft": _POUND / _FOOT},
    "modulus": {"psi": _LBF / _INCH**2, "ksi": _KIP / _INCH**2},
    "second moment of area": {"in4": _INCH**4},
}


def offered(units: Iterable[str]) -> list[str]:
    """Return those units of a dimension that messages suggest to the user."""
    return [unit for unit in units if not any(unit in others for others in CUSTOMARY.values())]


@dataclass(frozen=True, eq=False)  # distinguished by identity, so that what was read before is known
class Dimension:
    """A physical dimension with its units and their factors to SI; messages suggest the first two units."""

    name: str
    units: dict[str, Fraction]

    def __post_init__(self) -> None:
        self.units.update(CUSTOMARY.get(self.name, {}))

    def read(self, value: object) -> float:
        """Return a quantity such as '900 t', or a plain number, in SI units; raises ValueError if it is invalid."""
        number = self.number(value)
        if not math.isfinite(number):
            raise ValueError(f"'{value}' is not a finite number")
        if number and not SMALL <= abs(number) <= LARGE:
            extreme = f"smaller than {SMALL:g}" if abs(number) < SMALL else f"larger than {LARGE:g}"
            raise ValueError(f"'{value}' is {extreme} in SI units, beyond any realistic {self.name}")
        return number

    def number(self, value: object) -> float:
        """Return a quantity in SI units as `read` does; infinite values and nan are accepted too."""
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise ValueError(f"{self.article} is needed here, such as {self._example(1.0)}")
        if not isinstance(value, str):
            return self._bare(float(str(value)), f"{value:.12g}" if isinstance(value, float) else str(value))
        return self._of_text(value)

    @lru_cache(4096)  # noqa: B019 - dimensions stay, and variants of a scene share nearly all texts
    def _of_text(self, value: str) -> float:
        if meant := punctuation(value, self.units):
            raise ValueError(f"'{value}' is not a valid {self.name}: {meant}")
        written, unit = number_and_unit(value)
        if not written:
            known = ", ".join(filter(None, offered(self.units)))
            raise ValueError(f"'{value}' is not a valid {self.name}: write a number and a unit of {known}")
        if not unit:
            return self._bare(_product(written, _ONE), written)
        if unit not in self.units:
            other = next((d.name for d in DIMENSIONS if unit in d.units), "")
            what = f"a unit of {other}" if other else "not a unit that is known here"
            short = spelled(unit, self.units)
            meant = f": write '{written} {short}'" if short else ""
            raise ValueError(
                f"'{value}' is not a valid {self.name}: '{unit}' is {what}; use {', '.join(offered(self.units))}{meant}"
            )
        return _product(written, self.units[unit])

    def show(self, si: float) -> str:
        """Return a value as text in the first unit of `units`; `si`: the value in SI units."""
        unit, factor = next(iter(self.units.items()))
        return f"{si / float(factor):.10g} {unit}".strip()

    def _bare(self, number: float, text: str) -> float:
        if number == 0 or not math.isfinite(number) or "" in self.units:
            return number
        raise ValueError(f"missing unit: write {self._example(number, text)}")

    @property
    def article(self) -> str:
        """The name of the dimension with its article, for messages."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"

    def _example(self, number: float, text: str = "") -> str:
        units = list(self.units.items())
        if len(units) == 1 or units[0][0] == "":
            return f"'{text or format(number, '.10g')} {units[0][0] or units[1][0]}'"
        first, second = units[0], units[1]
        other = number * float(first[1] / second[1])
        return f"'{text or format(number, '.10g')} {first[0]}' or '{other:.10g} {second[0]}'"


@dataclass(frozen=True, eq=False)
class Limited(Dimension):
    """A dimension whose values must lie in a range; both ends are texts with units, as in scenes."""

    lowest: str
    highest: str

    def read(self, value: object) -> float:
        """Return a value in SI units; raises ValueError if the value is outside the allowed range."""
        number = self.number(value)
        if not self.number(self.lowest) * (1 - 1e-9) <= number <= self.number(self.highest) * (1 + 1e-9):
            message = f"{value:.12g}" if isinstance(value, float) else value
            raise ValueError(f"{message} is out of range: choose {self.lowest} to {self.highest}")
        return number


def _product(text: str, factor: Fraction) -> float:
    """Return the float nearest to a decimal number times a factor; the result is 0, infinite or nan only if the number
    is."""
    number = float(text)
    if number == 0.0 and any(digit in text.lower().partition("e")[0] for digit in "123456789"):
        return LEAST
    if number == 0.0 or not math.isfinite(number):
        return number
    try:
        return float(Fraction(text) * factor) or LEAST
    except OverflowError:
        return math.copysign(math.inf, number)


LENGTH = Dimension("length", {"m": _ONE, "mm": _MILLI, "cm": Fraction(1, 100), "km": _KILO})
MASS = Dimension("mass", {"t": _KILO, "kg": _ONE})
FORCE = Dimension("force", {"kN": _KILO, "N": _ONE, "MN": _MEGA})
MOMENT = Dimension("moment", {"kN m": _KILO, "N m": _ONE, "MN m": _MEGA})
SPEED = Dimension("speed", {"m/min": 1 / _MINUTE, "m/s": _ONE, "mm/s": _MILLI})
ACCELERATION = Dimension("acceleration", {"m/s2": _ONE, "mm/s2": _MILLI})
ANGLE = Dimension("angle", {"deg": _DEGREE, "rad": _ONE})
TENSION_RATE = Dimension("rate of tension", {"kN/s": _KILO, "N/s": _ONE, "kN/min": _KILO / _MINUTE})
RATE = Dimension("angular rate", {"deg/s": _DEGREE, "rad/s": _ONE, "deg/min": _DEGREE / _MINUTE})
ANGULAR_ACCELERATION = Dimension("angular acceleration", {"deg/s2": _DEGREE, "rad/s2": _ONE})
TIME = Dimension("time", {"s": _ONE, "min": _MINUTE, "h": 60 * _MINUTE, "ms": _MILLI, "days": 1440 * _MINUTE})
FREQUENCY = Dimension("frequency", {"Hz": _ONE, "/s": _ONE, "/min": 1 / _MINUTE, "kHz": _KILO})
INERTIA = Dimension("moment of inertia", {"kg m2": _ONE, "t m2": _KILO})
STIFFNESS = Dimension("stiffness", {"kN/m": _KILO, "N/m": _ONE, "MN/m": _MEGA, "N/mm": _KILO})
TURN_STIFFNESS = Dimension("torsional stiffness", {"kN m/rad": _KILO, "N m/rad": _ONE, "MN m/rad": _MEGA})
DAMPING = Dimension("damping", {"kN s/m": _KILO, "N s/m": _ONE, "MN s/m": _MEGA})
TURN_DAMPING = Dimension("torsional damping", {"kN m s/rad": _KILO, "N m s/rad": _ONE, "MN m s/rad": _MEGA})
AREA = Dimension("area", {"m2": _ONE, "cm2": Fraction(1, 100) ** 2})
DENSITY = Dimension("density", {"kg/m3": _ONE, "t/m3": _KILO})
MASS_PER_LENGTH = Dimension("mass per length", {"t/m": _KILO, "kg/m": _ONE})
ROTARY_INERTIA = Dimension("moment of inertia per length", {"kg m": _ONE, "t m": _KILO})
RIGIDITY = Dimension("bending stiffness", {"MN m2": _MEGA, "N m2": _ONE, "kN m2": _KILO, "GN m2": _GIGA})
MODULUS = Dimension("modulus", {"GPa": _GIGA, "MPa": _MEGA, "Pa": _ONE, "N/mm2": _MEGA})
PRESSURE = Dimension("pressure", {"kPa": _KILO, "Pa": _ONE, "MPa": _MEGA, "kN/m2": _KILO})
SECOND_MOMENT = Dimension("second moment of area", {"m4": _ONE, "cm4": Fraction(1, 100) ** 4})
RATIO = Dimension("ratio", {"": _ONE, "%": Fraction(1, 100)})
RESPONSE = Dimension("motion per wave amplitude", {"m/m": _ONE, "": _ONE})
TURN_RESPONSE = Dimension("angle per wave amplitude", {"deg/m": _DEGREE, "rad/m": _ONE})
MOMENT_RESPONSE = Dimension("moment per wave amplitude", {"MN m/m": _MEGA, "kN m/m": _KILO, "N m/m": _ONE})

DURATION = Limited(TIME.name, TIME.units, "0.001 ms", "100 days")
SAMPLING = Limited(FREQUENCY.name, FREQUENCY.units, "0.001 Hz", "10 kHz")
EFFICIENCY = Limited("efficiency", RATIO.units, "50 %", "100 %")
ACCURACY = Limited("accuracy", RATIO.units, "1e-10 %", "10 %")

DIMENSIONS: tuple[Dimension, ...] = (
    *(LENGTH, MASS, FORCE, MOMENT, SPEED, ACCELERATION, ANGLE, RATE, ANGULAR_ACCELERATION, TIME, FREQUENCY),
    *(INERTIA, STIFFNESS, TURN_STIFFNESS, DAMPING, TURN_DAMPING, AREA, DENSITY, RATIO),
    *(MASS_PER_LENGTH, ROTARY_INERTIA, RIGIDITY, MODULUS, SECOND_MOMENT, PRESSURE),
    TENSION_RATE,
    *(RESPONSE, TURN_RESPONSE, MOMENT_RESPONSE),
)


@dataclass(frozen=True, eq=False)
class Either(Dimension):
    """A dimension that accepts the units of two others, such as length and angle for sliding and turning joints."""

    sliding: Dimension
    turning: Dimension


def either(first: Dimension, second: Dimension) -> Either:
    """Return a dimension that accepts the units of two dimensions."""
    return Either(f"{first.name} or {second.name}", {**first.units, **second.units}, first, second)


@dataclass(frozen=True, eq=False)
class Quantity:
    """Parser of quantities of one dimension, for pydantic. `least`: smallest allowed value, one of "" (any value),
    "zero" (zero or more), "positive" and "one" (one or more)."""

    dimension: Dimension
    least: Literal["", "zero", "positive", "one"] = ""

    def read(self, value: object) -> float:
        """Return the value of a quantity in SI units; raises ValueError if the quantity is invalid."""
        number = self.dimension.read(value)
        needed = {"": "", "zero": "zero or more", "positive": "greater than zero", "one": "1 or more"}[self.least]
        if needed and (number < (self.least == "one") or (number == 0 and self.least == "positive")):
            raise ValueError(f"{self.dimension.article} must be {needed} here, not {value}")
        return number

    def __get_pydantic_core_schema__(self, kind: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        from pydantic_core import core_schema  # of which the units on a command line need nothing

        return core_schema.no_info_before_validator_function(self.read, handler(kind))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        units = f"{self.dimension.name} with its unit: {', '.join(u or 'number' for u in self.dimension.units)}"
        if isinstance(self.dimension, Limited):
            units += f"; {self.dimension.lowest} to {self.dimension.highest}"
        return {"type": ["string", "number"], "description": units, "dimension": self.dimension.name}


STROKE = either(LENGTH, ANGLE)
STROKE_SPEED = either(SPEED, RATE)
STROKE_RAMP = either(ACCELERATION, ANGULAR_ACCELERATION)
REACH = either(STROKE, STROKE_SPEED)
EFFORT = either(FORCE, MOMENT)
ANY_STIFFNESS = either(STIFFNESS, TURN_STIFFNESS)
ANY_DAMPING = either(DAMPING, TURN_DAMPING)
EITHER = (STROKE, STROKE_SPEED, STROKE_RAMP, REACH, EFFORT, ANY_STIFFNESS, ANY_DAMPING)
NAMED: dict[str, Dimension] = {dimension.name: dimension for dimension in (*DIMENSIONS, *EITHER)}

Length = Annotated[float, Quantity(LENGTH)]
Extent = Annotated[float, Quantity(LENGTH, "positive")]
Gap = Annotated[float, Quantity(LENGTH, "zero")]
Swing = Annotated[float, Quantity(ANGLE, "positive")]
Mass = Annotated[float, Quantity(MASS, "positive")]
AnyMass = Annotated[float, Quantity(MASS, "zero")]
Force = Annotated[float, Quantity(FORCE, "positive")]
Speed = Annotated[float, Quantity(SPEED, "positive")]
Velocity = Annotated[float, Quantity(SPEED)]
Ramp = Annotated[float, Quantity(ACCELERATION, "positive")]
Gravity = Annotated[float, Quantity(ACCELERATION, "zero")]
Angle = Annotated[float, Quantity(ANGLE)]
Rate = Annotated[float, Quantity(RATE)]
Duration = Annotated[float, Quantity(DURATION)]
Delay = Annotated[float, Quantity(TIME, "zero")]
Sampling = Annotated[float, Quantity(SAMPLING)]
Accuracy = Annotated[float, Quantity(ACCURACY)]
Efficiency = Annotated[float, Quantity(EFFICIENCY)]
Frequency = Annotated[float, Quantity(FREQUENCY, "positive")]
Inertia = Annotated[float, Quantity(INERTIA, "zero")]
Product = Annotated[float, Quantity(INERTIA)]
TurnStiffness = Annotated[float, Quantity(TURN_STIFFNESS, "zero")]
TurnDamping = Annotated[float, Quantity(TURN_DAMPING, "zero")]
Stiffness = Annotated[float, Quantity(STIFFNESS, "zero")]
Damping = Annotated[float, Quantity(DAMPING, "zero")]
Ratio = Annotated[float, Quantity(RATIO, "zero")]
Factor = Annotated[float, Quantity(RATIO, "one")]
Number = Annotated[float, Quantity(RATIO)]
Stroke = Annotated[float, Quantity(STROKE)]
StrokeSpeed = Annotated[float, Quantity(STROKE_SPEED, "positive")]
StrokeRamp = Annotated[float, Quantity(STROKE_RAMP, "positive")]
Effort = Annotated[float, Quantity(EFFORT, "positive")]
Area = Annotated[float, Quantity(AREA, "zero")]
Density = Annotated[float, Quantity(DENSITY, "zero")]
MassPerLength = Annotated[float, Quantity(MASS_PER_LENGTH, "positive")]
RotaryInertia = Annotated[float, Quantity(ROTARY_INERTIA, "zero")]
Rigidity = Annotated[float, Quantity(RIGIDITY, "zero")]
Pressure = Annotated[float, Quantity(PRESSURE, "positive")]
Modulus = Annotated[float, Quantity(MODULUS, "zero")]
SecondMoment = Annotated[float, Quantity(SECOND_MOMENT, "zero")]
Tension = Annotated[float, Quantity(FORCE, "zero")]
Reach = Annotated[float, Quantity(REACH)]
Thrust = Annotated[float, Quantity(EFFORT)]
Instant = Annotated[float, Quantity(TIME, "zero")]
AnyStiffness = Annotated[float, Quantity(ANY_STIFFNESS, "zero")]
AnyDamping = Annotated[float, Quantity(ANY_DAMPING, "zero")]
