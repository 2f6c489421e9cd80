"""Quantities with units, `900 t`, `3 m/min`, `0.15 deg/s`, and the pydantic types that read them into SI.

A number without a unit is refused where a unit is needed (0 needs none), and a unit of another kind is
named as what it is.  `Dimension.read` raises ValueError with one sentence, in scene values and in action
phrases alike.  Factors are exact and a quantity is rounded once, so that equal ones are equal numbers in any unit:
`300 t` and `300000 kg`, `0.3 m/min` and `5 mm/s`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated

from pydantic import BeforeValidator, WithJsonSchema

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_DEGREE = Fraction(math.pi / 180)  # as `math.radians` has it
_MINUTE, _KILO, _MILLI = Fraction(60), Fraction(1000), Fraction(1, 1000)
_ONE, _MEGA, _GIGA = Fraction(1), _KILO**2, _KILO**3


@dataclass(frozen=True)
class Dimension:
    """A kind of quantity: its units with their factors to SI; the first two units stand in its messages."""

    name: str
    units: dict[str, Fraction]

    def read(self, value: object) -> float:
        """The value in SI units, from '900 t' or a number that needs no unit."""
        number = self.number(value)
        if not math.isfinite(number):
            raise ValueError(f"'{value}' is no finite number")
        return number

    def number(self, value: object) -> float:
        """As `read`, but perhaps infinite or nan."""
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise ValueError(f"{self.article} is needed here, such as {self._example(1.0)}")
        if not isinstance(value, str):
            return self._bare(float(str(value)), f"{value:.12g}" if isinstance(value, float) else str(value))
        match = re.fullmatch(rf"\s*({NUMBER}|[+-]?(?:nan|inf))\s*(.*?)\s*", value)
        if not match:
            known = ", ".join(unit for unit in self.units if unit)
            raise ValueError(f"'{value}' is no {self.name}: write a number and a unit of {known}")
        number, unit = float(match[1]), tidy(match[2])
        if not unit:
            return self._bare(number, match[1])
        if unit not in self.units:
            other = next((d.name for d in DIMENSIONS if unit in d.units), "")
            what = f"a unit of {other}" if other else "not a unit that is known here"
            raise ValueError(f"'{value}' is no {self.name}: '{match[2]}' is {what}; use {', '.join(self.units)}")
        return _product(match[1], self.units[unit])

    def show(self, si: float) -> str:
        """A value in the dimension's first unit, as a user writes it."""
        unit, factor = next(iter(self.units.items()))
        return f"{si / float(factor):.10g} {unit}".strip()

    def _bare(self, number: float, text: str) -> float:
        if number == 0 or not math.isfinite(number) or "" in self.units:
            return number
        raise ValueError(f"missing unit: write {self._example(number, text)}")

    @property
    def article(self) -> str:
        """The name with its article, for sentences."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"

    def _example(self, number: float, text: str = "") -> str:
        units = list(self.units.items())
        if len(units) == 1 or units[0][0] == "":
            return f"'{text or format(number, '.10g')} {units[0][0] or units[1][0]}'"
        first, second = units[0], units[1]
        other = number * float(first[1] / second[1])
        return f"'{text or format(number, '.10g')} {first[0]}' or '{other:.10g} {second[0]}'"


@dataclass(frozen=True)
class Limited(Dimension):
    """A quantity that makes sense between two ends only, written as a user writes them."""

    lowest: str
    highest: str

    def read(self, value: object) -> float:
        """The value in SI units, at an end or between them."""
        number = self.number(value)
        if not self.number(self.lowest) * (1 - 1e-9) <= number <= self.number(self.highest) * (1 + 1e-9):
            message = f"{value:.12g}" if isinstance(value, float) else value
            raise ValueError(f"{message} is out of range: choose {self.lowest} to {self.highest}")
        return number


def _product(text: str, factor: Fraction) -> float:
    """The float nearest to a decimal number times a factor; infinite or nan where the number is."""
    number = float(text)
    if number == 0.0 or not math.isfinite(number):
        return number
    try:
        return float(Fraction(text) * factor)
    except OverflowError:
        return math.copysign(math.inf, number)


def tidy(unit: str) -> str:
    """A unit in the spelling of the tables: no superscripts, dots or doubled blanks."""
    for old, new in (("²", "2"), ("³", "3"), ("·", " "), ("*", " "), ("^", ""), ("°", "deg")):
        unit = unit.replace(old, new)
    return " ".join(unit.split())


LENGTH = Dimension("length", {"m": _ONE, "mm": _MILLI, "cm": Fraction(1, 100), "km": _KILO})
MASS = Dimension("mass", {"t": _KILO, "kg": _ONE})
FORCE = Dimension("force", {"kN": _KILO, "N": _ONE, "MN": _MEGA})
MOMENT = Dimension("moment", {"kN m": _KILO, "N m": _ONE, "MN m": _MEGA})
SPEED = Dimension("speed", {"m/min": 1 / _MINUTE, "m/s": _ONE, "mm/s": _MILLI})
ACCELERATION = Dimension("acceleration", {"m/s2": _ONE, "mm/s2": _MILLI})
ANGLE = Dimension("angle", {"deg": _DEGREE, "rad": _ONE})
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
SECOND_MOMENT = Dimension("second moment of area", {"m4": _ONE, "cm4": Fraction(1, 100) ** 4})
RATIO = Dimension("ratio", {"": _ONE, "%": Fraction(1, 100)})

DURATION = Limited(TIME.name, TIME.units, "0.001 ms", "100 days")
SAMPLING = Limited(FREQUENCY.name, FREQUENCY.units, "0.001 Hz", "10 kHz")
EFFICIENCY = Limited("efficiency", RATIO.units, "50 %", "100 %")
ACCURACY = Limited("accuracy", RATIO.units, "1e-10 %", "10 %")

DIMENSIONS: tuple[Dimension, ...] = (
    *(LENGTH, MASS, FORCE, MOMENT, SPEED, ACCELERATION, ANGLE, RATE, ANGULAR_ACCELERATION, TIME, FREQUENCY),
    *(INERTIA, STIFFNESS, TURN_STIFFNESS, DAMPING, TURN_DAMPING, AREA, DENSITY, RATIO),
    *(MASS_PER_LENGTH, ROTARY_INERTIA, RIGIDITY, MODULUS, SECOND_MOMENT),
)


def either(first: Dimension, second: Dimension) -> Dimension:
    """A dimension that reads both, such as a length of a sliding or an angle of a turning joint."""
    return Dimension(f"{first.name} or {second.name}", {**first.units, **second.units})


def _positive(dimension: Dimension, least: str) -> Callable[[object], float]:
    def read(value: object) -> float:
        number = dimension.read(value)
        if number < 0 or (number == 0 and least == "positive"):
            message = "greater than zero" if least == "positive" else "zero or more"
            raise ValueError(f"{dimension.article} must be {message} here, not {value}")
        return number

    return read


def _schema(dimension: Dimension) -> WithJsonSchema:
    message = f"{dimension.name} with its unit: {', '.join(u or 'number' for u in dimension.units)}"
    if isinstance(dimension, Limited):
        message += f"; {dimension.lowest} to {dimension.highest}"
    return WithJsonSchema({"type": ["string", "number"], "description": message, "dimension": dimension.name})


STROKE = either(LENGTH, ANGLE)
STROKE_SPEED = either(SPEED, RATE)
STROKE_RAMP = either(ACCELERATION, ANGULAR_ACCELERATION)
REACH = either(STROKE, STROKE_SPEED)
EFFORT = either(FORCE, MOMENT)
ANY_STIFFNESS = either(STIFFNESS, TURN_STIFFNESS)
ANY_DAMPING = either(DAMPING, TURN_DAMPING)

Length = Annotated[float, BeforeValidator(LENGTH.read), _schema(LENGTH)]
Extent = Annotated[float, BeforeValidator(_positive(LENGTH, "positive")), _schema(LENGTH)]
Gap = Annotated[float, BeforeValidator(_positive(LENGTH, "zero")), _schema(LENGTH)]
Swing = Annotated[float, BeforeValidator(_positive(ANGLE, "positive")), _schema(ANGLE)]
Mass = Annotated[float, BeforeValidator(_positive(MASS, "positive")), _schema(MASS)]
Force = Annotated[float, BeforeValidator(_positive(FORCE, "positive")), _schema(FORCE)]
Moment = Annotated[float, BeforeValidator(_positive(MOMENT, "positive")), _schema(MOMENT)]
Speed = Annotated[float, BeforeValidator(_positive(SPEED, "positive")), _schema(SPEED)]
Velocity = Annotated[float, BeforeValidator(SPEED.read), _schema(SPEED)]
Ramp = Annotated[float, BeforeValidator(_positive(ACCELERATION, "positive")), _schema(ACCELERATION)]
Gravity = Annotated[float, BeforeValidator(_positive(ACCELERATION, "zero")), _schema(ACCELERATION)]
Angle = Annotated[float, BeforeValidator(ANGLE.read), _schema(ANGLE)]
Rate = Annotated[float, BeforeValidator(RATE.read), _schema(RATE)]
Duration = Annotated[float, BeforeValidator(DURATION.read), _schema(DURATION)]
Sampling = Annotated[float, BeforeValidator(SAMPLING.read), _schema(SAMPLING)]
Accuracy = Annotated[float, BeforeValidator(ACCURACY.read), _schema(ACCURACY)]
Efficiency = Annotated[float, BeforeValidator(EFFICIENCY.read), _schema(EFFICIENCY)]
Frequency = Annotated[float, BeforeValidator(_positive(FREQUENCY, "positive")), _schema(FREQUENCY)]
Inertia = Annotated[float, BeforeValidator(_positive(INERTIA, "zero")), _schema(INERTIA)]
Product = Annotated[float, BeforeValidator(INERTIA.read), _schema(INERTIA)]
TurnStiffness = Annotated[float, BeforeValidator(_positive(TURN_STIFFNESS, "zero")), _schema(TURN_STIFFNESS)]
TurnDamping = Annotated[float, BeforeValidator(_positive(TURN_DAMPING, "zero")), _schema(TURN_DAMPING)]
Stiffness = Annotated[float, BeforeValidator(_positive(STIFFNESS, "zero")), _schema(STIFFNESS)]
Damping = Annotated[float, BeforeValidator(_positive(DAMPING, "zero")), _schema(DAMPING)]
Ratio = Annotated[float, BeforeValidator(_positive(RATIO, "zero")), _schema(RATIO)]
Factor = Annotated[float, BeforeValidator(_positive(RATIO, "positive")), _schema(RATIO)]
Number = Annotated[float, BeforeValidator(RATIO.read), _schema(RATIO)]
Stroke = Annotated[float, BeforeValidator(STROKE.read), _schema(STROKE)]
StrokeRamp = Annotated[float, BeforeValidator(_positive(STROKE_RAMP, "positive")), _schema(STROKE_RAMP)]
Effort = Annotated[float, BeforeValidator(_positive(EFFORT, "positive")), _schema(EFFORT)]
Area = Annotated[float, BeforeValidator(_positive(AREA, "zero")), _schema(AREA)]
Density = Annotated[float, BeforeValidator(_positive(DENSITY, "zero")), _schema(DENSITY)]
MassPerLength = Annotated[float, BeforeValidator(_positive(MASS_PER_LENGTH, "positive")), _schema(MASS_PER_LENGTH)]
RotaryInertia = Annotated[float, BeforeValidator(_positive(ROTARY_INERTIA, "zero")), _schema(ROTARY_INERTIA)]
Rigidity = Annotated[float, BeforeValidator(_positive(RIGIDITY, "zero")), _schema(RIGIDITY)]
Modulus = Annotated[float, BeforeValidator(_positive(MODULUS, "zero")), _schema(MODULUS)]
SecondMoment = Annotated[float, BeforeValidator(_positive(SECOND_MOMENT, "zero")), _schema(SECOND_MOMENT)]
Tension = Annotated[float, BeforeValidator(_positive(FORCE, "zero")), _schema(FORCE)]
Push = Annotated[float, BeforeValidator(FORCE.read), _schema(FORCE)]
Twist = Annotated[float, BeforeValidator(MOMENT.read), _schema(MOMENT)]
Reach = Annotated[float, BeforeValidator(REACH.read), _schema(REACH)]
Thrust = Annotated[float, BeforeValidator(EFFORT.read), _schema(EFFORT)]
Instant = Annotated[float, BeforeValidator(_positive(TIME, "zero")), _schema(TIME)]
AnyStiffness = Annotated[float, BeforeValidator(_positive(ANY_STIFFNESS, "zero")), _schema(ANY_STIFFNESS)]
AnyDamping = Annotated[float, BeforeValidator(_positive(ANY_DAMPING, "zero")), _schema(ANY_DAMPING)]
