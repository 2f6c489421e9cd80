"""Numbers with their uncertainty, as they are written in scenes, maps of log columns, and options.

    480 t +- 3 %, 480 t +- 10 t     half-width at a level of 95 %, that is two standard uncertainties; also +/- and ±
    480 t sd 5 t, 480 t sd 1 %      standard uncertainty; also sigma
    460..500 t                      uniform between two ends; the nominal value is the middle

For a value in %, a half-width in % is absolute: `97 % +- 1 %` is 96 to 98 %. For other values it is relative.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Literal, TypeAlias

from .source import Data, Path, SourceText, mapped
from .spelling import PLUS, number_and_unit, range_of, spread_of, tidy
from .units import ACCURACY, DURATION, SAMPLING, Dimension, Either, Limited, Quantity, offered

MARKED = re.compile(rf"{PLUS}|sd|sigma|\.\.")  # what every such form has in it
_LONGEST = 200  # characters of a number with its uncertainty
_SETTINGS = (ACCURACY, DURATION, SAMPLING)  # of a run: nobody measures them
Kind: TypeAlias = Literal["normal", "uniform"]


@dataclass(frozen=True)
class Stated:
    """A number with its uncertainty as text: nominal value, form of the uncertainty (`+-`, `sd`, `..`), half-width."""

    value: str
    how: str
    half: str

    @property
    def kind(self) -> Kind:
        """The kind of distribution: normal, or uniform between two ends."""
        return "uniform" if self.how == ".." else "normal"


def separated(source: SourceText, is_text: Callable[[Path], bool]) -> dict[Path, Stated]:
    """Return the stated uncertainties of a scene by path, and replace uncertain numbers by nominal values.

    Errors are added to the source. `is_text`: function that returns whether the value at a path is free text, which is
    not searched."""
    found: dict[Path, Stated] = {}

    def nominal(data: Data, path: Path) -> Data:
        try:
            stated = _stated(data) if isinstance(data, str) and MARKED.search(data) and not is_text(path) else None
        except ValueError as error:
            source.fault(path, str(error))
            return data
        if stated is None:
            return data
        found[path] = stated
        return stated.value

    source.data = mapped(source.data, nominal)
    return found


def standard(stated: Stated, quantity: Quantity) -> float:
    """Return a stated uncertainty as standard uncertainty in SI units; raises ValueError if that is impossible."""
    dimension, value = quantity.dimension, quantity.read(stated.value)
    if dimension in _SETTINGS:
        raise ValueError(f"{dimension.article} is a setting of the run, not an input: write it without uncertainty")
    unit = number_and_unit(stated.value)[1]
    units = _plain(dimension, unit or number_and_unit(stated.half)[1]).units
    part, width = half_width(stated.half, units, stated.how, relative=unit != "%")
    if part and value == 0.0:
        raise ValueError(f"'{stated.how} {stated.half}' of a value of 0 is 0: write the uncertainty with a unit")
    half = part * abs(value) + width
    reach = 2.0 * half if stated.how.startswith("s") else half
    low, high = value - reach, value + reach
    if quantity.least and (low < 0.0 or (low == 0.0 and quantity.least == "positive")):
        least = "greater than zero" if quantity.least == "positive" else "zero or more"
        raise ValueError(
            f"the range reaches down to {dimension.show(low)}, but {dimension.article} must be {least} here"
        )
    if isinstance(dimension, Limited):
        ends = dimension.number(dimension.lowest), dimension.number(dimension.highest)
        if low < ends[0] * (1 - 1e-9) or high > ends[1] * (1 + 1e-9):
            raise ValueError(
                f"the range from {dimension.show(low)} to {dimension.show(high)} is not within {dimension.lowest} to "
                f"{dimension.highest}; write the range that is meant, such as '97..100 %'"
            )
    return reach / (math.sqrt(3.0) if stated.kind == "uniform" else 2.0)


def half_width(text: str, units: Mapping[str, Fraction], how: str = "+-", relative: bool = True) -> tuple[float, float]:
    """Return a half-width such as `3 %` or `10 t` as (fraction of the value, amount in SI units), of which one is 0.

    Raises ValueError for an invalid text. `relative`: % means a fraction of the value."""
    number, unit = number_and_unit(text)
    width, text = float(number) if number else math.nan, f"{how} {text.strip()}".strip()
    if not 0.0 <= width < math.inf:
        raise ValueError(
            f"'{text}' is not a valid uncertainty: write a number and a unit, such as '+- 5 kN' or '+- 1 %'"
        )
    if unit == "%" and relative:
        return width / 100.0, 0.0
    if unit not in units:
        what = f"'{unit}' is not a unit of this quantity" if unit else "the unit is missing"
        raise ValueError(f"'{text}': {what}; use {', '.join(dict.fromkeys(('%', *filter(None, offered(units)))))}")
    return 0.0, width * float(units[unit])


def _stated(text: str) -> Stated | None:
    """Return the parts of a number with uncertainty; None for other texts."""
    if len(text) > _LONGEST:
        return None
    if (form := spread_of(text)) and (number := number_and_unit(form[0])[0]) and math.isfinite(float(number)):
        return Stated(*form)
    ends = range_of(text)
    if ends is None or ends.step:
        return None
    low, high, unit = Decimal(ends.low), Decimal(ends.high), ends.unit
    if ends.unit_low and tidy(ends.unit_low) != tidy(unit):
        raise ValueError(f"'{text}': write both ends in one unit, such as '460..500 t'")
    if not low < high:
        raise ValueError(f"'{text}': the first number must be less than the second one")
    return Stated(f"{(low + high) / 2} {unit}".strip(), "..", f"{(high - low) / 2} {unit}".strip())


def _plain(dimension: Dimension, unit: str) -> Dimension:
    """Return the dimension to which a unit belongs if the dimension is a combination of two; else the dimension
    itself."""
    while isinstance(dimension, Either):
        dimension = dimension.sliding if unit in dimension.sliding.units else dimension.turning
    return dimension
