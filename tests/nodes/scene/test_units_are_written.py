"""Quantities carry units: every unit converts to SI, and missing or unsuitable units are reported."""

import math
from decimal import Context, Decimal
from fractions import Fraction
from random import Random

import pytest
from heavylift.nodes.scene.text import units

READS = [
    (units.LENGTH, "54 m", 54.0),
    (units.LENGTH, "5 mm", 0.005),
    (units.LENGTH, "-12.5 cm", -0.125),
    (units.MASS, "900 t", 900e3),
    (units.MASS, "9e5 kg", 900e3),
    (units.FORCE, "6.43 MN", 6.43e6),
    (units.SPEED, "3 m/min", 0.05),
    (units.SPEED, "5 mm/s", 0.005),
    (units.ACCELERATION, "0.05 m/s²", 0.05),
    (units.ANGLE, "90 deg", math.pi / 2),
    (units.ANGLE, "90°", math.pi / 2),
    (units.RATE, "0.15 deg/s", math.radians(0.15)),
    (units.TIME, "15 min", 900.0),
    (units.TIME, "1.5 h", 5400.0),
    (units.FREQUENCY, "2 Hz", 2.0),
    (units.INERTIA, "6.63e7 kg m2", 6.63e7),
    (units.INERTIA, "3 t·m²", 3e3),
    (units.STIFFNESS, "31.2 MN/m", 31.2e6),
    (units.TURN_DAMPING, "100 kN m s/rad", 1e5),
    (units.RATIO, "75 %", 0.75),
    (units.RATIO, 0.75, 0.75),
    (units.LENGTH, 0, 0.0),
    (units.SAMPLING, "0.001 Hz", 1e-3),
    (units.SAMPLING, "10 kHz", 1e4),
    (units.ACCURACY, "1e-10 %", 1e-12),
    (units.ACCURACY, 0.1, 0.1),
    (units.DURATION, "100 days", 8.64e6),
    (units.LENGTH, "10 ft", 3.048),
    (units.LENGTH, "1 in", 0.0254),
    (units.MASS, "1000 lb", 453.59237),
    (units.FORCE, "1 kip", 4448.2216152605),
    (units.SPEED, "3600 kn", 1852.0),
    (units.MODULUS, "1 ksi", 6.894757293168361e6),  # NIST SP 811, table B.8
    (units.DENSITY, "1 lb/ft3", 16.01846337396014),
    (units.MOMENT, "1 lbf ft", 1.3558179483314004),
]

REFUSES = [
    (units.MASS, 900, "missing unit: write '900 t' or '900000 kg'"),
    (units.MASS, "900", "missing unit: write '900 t' or '900000 kg'"),
    (units.SPEED, 3, "missing unit: write '3 m/min' or '0.05 m/s'"),
    (units.INERTIA, 6.63e7, "missing unit: write '66300000 kg m2' or '66300 t m2'"),
    (units.LENGTH, "3 kN", "'3 kN' is not a valid length: 'kN' is a unit of force; use m, mm, cm, km"),
    (
        units.TIME,
        "3 weeks",
        "'3 weeks' is not a valid time: 'weeks' is not a unit that is known here; use s, min, h, ms, days",
    ),
    (units.LENGTH, "long", "'long' is not a valid length: write a number and a unit of m, mm, cm, km"),
    (units.LENGTH, True, "a length is needed here, such as '1 m' or '1000 mm'"),
    (units.ACCELERATION, None, "an acceleration is needed here, such as '1 m/s2' or '1000 mm/s2'"),
    (units.TIME, "1e999 s", "'1e999 s' is not a finite number"),
    (units.MASS, math.nan, "'nan' is not a finite number"),
    (units.MASS, 10**400, f"'{10**400}' is not a finite number"),
    (units.SAMPLING, "1e-12 Hz", "1e-12 Hz is out of range: choose 0.001 Hz to 10 kHz"),
    (units.SAMPLING, "10.1 kHz", "10.1 kHz is out of range: choose 0.001 Hz to 10 kHz"),
    (units.ACCURACY, 1e9, "1000000000 is out of range: choose 1e-10 % to 10 %"),
    (units.ACCURACY, "9.9e-11 %", "9.9e-11 % is out of range: choose 1e-10 % to 10 %"),
    (units.TIME, "1:15", "'1:15' is not a valid time: write '75 s' or '75 min', as it is meant"),
    (units.TIME, "1:02:03", "'1:02:03' is not a valid time: write it in one unit, '3723 s'"),
    (units.LENGTH, "0,05 m", "'0,05 m' is not a valid length: a decimal has a point, no comma: write '0.05 m'"),
    (units.LENGTH, "0,125 m", "'0,125 m' is not a valid length: a decimal has a point, no comma: write '0.125 m'"),
    (
        units.LENGTH,
        "-1,000 metres",
        "'-1,000 metres' is not a valid length: a decimal has a point, no comma: "
        "write '-1000 m' or '-1.000 m', as it is meant",
    ),
    (units.MASS, "1,234,567 kg", "'1,234,567 kg' is not a valid mass: thousands are not set apart: write '1234567 kg'"),
    (units.MASS, "1,234.5 t", "'1,234.5 t' is not a valid mass: thousands are not set apart: write '1234.5 t'"),
    (
        units.MASS,
        "300 tonnes",
        "'300 tonnes' is not a valid mass: 'tonnes' is not a unit that is known here; use t, kg: write '300 t'",
    ),
    (
        units.SPEED,
        "3 Metres per Minute",
        "'3 Metres per Minute' is not a valid speed: 'Metres per Minute' is not "
        "a unit that is known here; use m/min, m/s, mm/s:"
        " write '3 m/min'",
    ),
    (
        units.FORCE,
        "5 KN",
        "'5 KN' is not a valid force: 'KN' is not a unit that is known here; use kN, N, MN: write '5 kN'",
    ),
    (units.DURATION, "2401 h", "2401 h is out of range: choose 0.001 ms to 100 days"),
]


@pytest.mark.parametrize(("dimension", "text", "si"), READS)
def test_units_are_converted_to_si(dimension: units.Dimension, text: object, si: float) -> None:
    assert dimension.read(text) == pytest.approx(si, rel=1e-15)


@pytest.mark.parametrize(("dimension", "text", "told"), REFUSES)
def test_texts_that_are_not_quantities_are_refused_with_the_expected_form(
    dimension: units.Dimension, text: object, told: str
) -> None:
    with pytest.raises(ValueError) as refusal:  # noqa: PT011
        dimension.read(text)
    assert str(refusal.value) == told


@pytest.mark.parametrize("dimension", units.DIMENSIONS, ids=lambda dimension: dimension.name)
def test_equal_quantities_are_equal_numbers_in_any_unit(dimension: units.Dimension) -> None:
    """Random decimals, said in each other unit that can say them exactly."""
    random = Random(dimension.name)
    for unit, factor in dimension.units.items():
        for other, size in dimension.units.items():
            for _ in range(50):
                decimal = Decimal(random.randrange(1, 10**6)).scaleb(-random.randrange(6))
                same = Fraction(decimal) * factor / size
                if text := exactly(same):
                    assert dimension.read(f"{text} {other}") == dimension.read(f"{decimal:f} {unit}"), (decimal, unit)


def exactly(x: Fraction) -> str:
    """A fraction as a decimal number, "" if it is none."""
    digits = 60
    scaled = x * 10**digits
    return f"{Decimal(scaled.numerator).scaleb(-digits, Context(prec=200)):f}" if scaled.denominator == 1 else ""


def test_a_quantity_beyond_the_range_of_floating_point_numbers_is_refused() -> None:
    with pytest.raises(ValueError, match="is not a finite number"):
        units.MASS.read("1e307 t")
    with pytest.raises(ValueError, match="is not a finite number"):
        units.MASS.read(f"1{'0' * 400} t")
    with pytest.raises(ValueError, match="smaller than 1e-30"):
        units.LENGTH.read("1e-400 mm")


WORDS = [
    (units.LENGTH, ("metres", "meters", "Millimetre", "KM")),
    (units.MASS, ("tonne", "Tons", "kilograms", "KG")),
    (units.TIME, ("seconds", "Sec", "minutes", "hours", "hr", "day")),
    (units.ANGLE, ("degrees", "radian")),
    (units.SPEED, ("metres per second", "meters/min", "MM/S")),
    (units.FORCE, ("newtons", "kilonewton")),
]


@pytest.mark.parametrize(("dimension", "word"), [(d, word) for d, words in WORDS for word in words])
def test_the_proposed_spelling_of_a_written_out_unit_is_accepted(dimension: units.Dimension, word: str) -> None:
    with pytest.raises(ValueError, match="write '7 ") as refusal:
        dimension.read(f"7 {word}")
    proposed = str(refusal.value).rpartition("write '")[2].removesuffix("'")
    assert dimension.read(proposed) > 0.0
