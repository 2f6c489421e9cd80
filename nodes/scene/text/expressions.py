"""Arithmetic with parameters: values of a scene or a machine type that begin with `=`, such as `=0.7 t/m*boom`.

    sum      = product {("+" | "-") product}
    product  = factor {("*" | "/") factor}
    factor   = {"+" | "-"} atom
    atom     = number [unit] | parameter ["." ("x" | "y" | "z")] | function "(" sum {"," sum} ")" | "(" sum ")"
    function = sqrt | sin | cos | tan | acos | asin | atan2 | min | max;  pi is a number

Numbers are floats in SI units, operations are evaluated in the order of the text, and functions give the same bits
everywhere. Each value carries the exponents of kg, m, s and rad, so metres are never added to tonnes.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

from heavylift.kernel.algebra.elementary import atan2, cos, sin

from .spelling import NUMBER, Reader, number_and_unit
from .units import DIMENSIONS, Dimension

Exponents = tuple[int, int, int, int]  # of kg, m, s, rad
PLAIN: Exponents = (0, 0, 0, 0)
ANGLE: Exponents = (0, 0, 0, 1)
BASE: dict[str, Exponents] = {  # without their powers of ten
    **dict.fromkeys(("kg", "t", "lb"), (1, 0, 0, 0)),
    **dict.fromkeys(("m", "mm", "cm", "km", "ft", "in"), (0, 1, 0, 0)),
    "kn": (0, 1, -1, 0),
    **dict.fromkeys(("s", "min", "h", "ms", "days"), (0, 0, 1, 0)),
    **dict.fromkeys(("rad", "deg"), ANGLE),
    **dict.fromkeys(("N", "kN", "MN", "GN", "lbf", "kip"), (1, 1, -2, 0)),
    **dict.fromkeys(("Pa", "MPa", "GPa", "psi", "ksi"), (1, -1, -2, 0)),
    **dict.fromkeys(("Hz", "kHz"), (0, 0, -1, 0)),
    **dict.fromkeys(("", "%"), PLAIN),
}
TURNS: dict[str, Callable[[float], float]] = {"sin": sin, "cos": cos, "tan": lambda x: sin(x) / cos(x)}
FUNCTIONS = ("sqrt", *TURNS, "acos", "asin", "atan2", "min", "max")
LONGEST, DEEPEST = 500, 20  # characters of an expression, levels of brackets
UNIT = "|".join(
    re.escape(u).replace(r"\ ", r"\s+")
    for u in sorted({u for d in DIMENSIONS for u in d.units if u}, key=lambda u: -len(u))
)
QUANTITY = re.compile(rf"(?P<number>{NUMBER})(?:\s*(?P<unit>{UNIT})(?![\w/%]))?")
WORD = re.compile(r"[A-Za-z_]\w*(?:\s+[A-Za-z_]\w*)*(?:\.[xyz]\b)?")


class ExpressionError(ValueError):
    """Raised for an expression that cannot be parsed or computed.

    `column`: place of the error in the expression, counted from 0."""

    def __init__(self, sentence: str, column: int = 0) -> None:
        super().__init__(sentence)
        self.column = column


@dataclass(frozen=True)
class Value:
    """A number in SI units with its dimension."""

    number: float
    exponents: Exponents = PLAIN


def value_of(text: object) -> Value | None:
    """Return the value of a quantity written in a scene, such as "42 m" or 8; None for anything else."""
    if isinstance(text, bool) or not isinstance(text, str | int | float):
        return None
    if not isinstance(text, str):
        return Value(float(text))
    number, unit = number_and_unit(text)
    known = next((d for d in DIMENSIONS if unit in d.units), None)
    if not number or not known:
        return None
    return Value(known.number(text) if unit else float(number), _exponents(unit))


def dimension_of(text: object) -> Dimension | None:
    """Return the dimension of a quantity written in a scene; None for anything else."""
    number, unit = number_and_unit(str(text))
    return next((d for d in DIMENSIONS if number and unit in d.units), None)


def shown_as(value: Value) -> str | float:
    """Return a value as exact text in the form that scenes use; raises ExpressionError if no unit fits."""
    if not math.isfinite(value.number):
        raise ExpressionError("the result is not a finite number; check the expression")
    if value.exponents == PLAIN:
        return value.number
    if value.exponents not in _units():
        raise ExpressionError(
            f"the result is in {_named(value.exponents)}, which is not a unit of scenes; check the expression"
        )
    return f"{value.number!r} {_units()[value.exponents]}"


def evaluated(text: str, lookup: Callable[[str], Value | None]) -> Value:
    """Return the value of an expression, given without its `=`; raises ExpressionError if it is invalid.

    `lookup`: function that returns the values of parameters."""
    if len(text) > LONGEST:
        raise ExpressionError(f"an expression has at most {LONGEST} characters, this one has {len(text)}")
    reader = _Arithmetic(text, lookup)
    value = reader.sum()
    if reader.at < len(text):
        raise ExpressionError(f"add an operator before '{reader.rest}', or remove this part", reader.at)
    return value


class _Arithmetic(Reader):
    """The part of an expression that has not been read yet."""

    def __init__(self, text: str, lookup: Callable[[str], Value | None]) -> None:
        super().__init__(text)
        self.lookup, self.depth = lookup, 0

    def sum(self) -> Value:
        left = self.product()
        while sign := self._take("+", "-"):
            at = self.at
            right = self.product()
            if left.exponents != right.exponents:
                both = f"{_named(left.exponents)} and {_named(right.exponents)} cannot be added or subtracted"
                raise ExpressionError(both, at)
            total = left.number + right.number if sign == "+" else left.number - right.number
            left = Value(total, left.exponents)
        return left

    def product(self) -> Value:
        left = self.factor()
        while sign := self._take("*", "/"):
            at = self.at
            right = self.factor()
            if sign == "/" and right.number == 0.0:
                raise ExpressionError("division by zero: this expression is zero", at)
            number = left.number * right.number if sign == "*" else left.number / right.number
            left = Value(number, _times(left.exponents, right.exponents, 1 if sign == "*" else -1))
        return left

    def factor(self) -> Value:
        negative = False
        while sign := self._take("+", "-"):
            negative ^= sign == "-"
        value = self.atom()
        return Value(-value.number, value.exponents) if negative else value

    def atom(self) -> Value:
        if found := QUANTITY.match(self.text, self.at):
            self.move(found.end())
            value = value_of(" ".join(found[0].split()))
            assert value is not None
            return value
        if self._take("("):
            return self._list(1)[0]
        found = WORD.match(self.text, self.at)
        if not found:
            raise ExpressionError(f"a number, a parameter or a bracket is expected here, not '{self.rest}'", self.at)
        at, word = self.at, " ".join(found[0].split())
        self.move(found.end())
        if word in FUNCTIONS:
            if not self._take("("):
                raise ExpressionError(f"write the values of '{word}' in brackets after it", self.at)
            return self._called(word, at)
        if word == "pi":
            return Value(math.pi)
        value = self.lookup(word)
        if value is None:
            raise ExpressionError(f"there is no parameter '{word}'", at)
        return value

    def _list(self, most: int) -> list[Value]:
        """Return the values up to the closing bracket, at most `most` of them."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise ExpressionError(f"brackets are nested deeper than {DEEPEST} levels; simplify the expression", self.at)
        values = [self.sum()]
        while len(values) < most and self._take(","):
            values.append(self.sum())
        if not self._take(")"):
            raise ExpressionError("a closing bracket ) is missing here", self.at)
        self.depth -= 1
        return values

    def _called(self, name: str, at: int) -> Value:
        values = self._list(8)
        wanted = {"atan2": 2}.get(name, 1)
        if name not in ("min", "max") and len(values) != wanted:
            raise ExpressionError(f"'{name}' needs {wanted} value{'s' if wanted > 1 else ''}, not {len(values)}", at)
        kinds = {value.exponents for value in values}
        first, exponents = values[0].number, values[0].exponents
        if len(kinds) > 1:
            raise ExpressionError(f"the values of '{name}' must all have units of the same kind", at)
        if name in ("min", "max"):
            return Value((min if name == "min" else max)(value.number for value in values), exponents)
        if not all(math.isfinite(value.number) for value in values):
            raise ExpressionError(f"'{name}' needs finite numbers", at)
        if name == "atan2":
            return Value(float(atan2(first, values[1].number)), ANGLE)
        if name == "sqrt":
            if first < 0.0 or any(x % 2 for x in exponents):
                raise ExpressionError("this value has no square root: it is negative, or its unit is not a square", at)
            kg, m, s, rad = (x // 2 for x in exponents)
            return Value(math.sqrt(first), (kg, m, s, rad))
        return self._turned(name, values[0], at)

    def _turned(self, name: str, value: Value, at: int) -> Value:
        """Return the value of a trigonometric function or of its inverse; `at`: its column in the text."""
        inverse = name in ("acos", "asin")
        if value.exponents not in ((PLAIN,) if inverse else (PLAIN, ANGLE)):
            needed = "a ratio" if inverse else "an angle"
            raise ExpressionError(f"'{name}' needs {needed}, not {_named(value.exponents)}", at)
        x = value.number
        if not inverse:
            return Value(float(TURNS[name](x)))
        if not -1.0 <= x <= 1.0:
            raise ExpressionError(f"'{name}' needs a ratio from -1 to 1, not {x:g}", at)
        other = math.sqrt(1.0 - x * x)
        return Value(float(atan2(other, x) if name == "acos" else atan2(x, other)), ANGLE)

    def _take(self, *signs: str) -> str:
        sign = self.text[self.at : self.at + 1]
        if not sign or sign not in signs:
            return ""
        self.move(self.at + 1)
        return sign


def _times(a: Exponents, b: Exponents, sign: int) -> Exponents:
    kg, m, s, rad = (x + sign * y for x, y in zip(a, b, strict=True))
    return kg, m, s, rad


@cache
def _exponents(unit: str) -> Exponents:
    """Return the dimension of a unit as exponents; "kN m/rad" is kg m2 / s2 / rad."""
    over, *under = unit.split("/")
    found = PLAIN
    for part, sign in ((over, 1), *((each, -1) for each in under)):
        for word in part.split():
            name = word.rstrip("0123456789")
            for _ in range(int(word[len(name) :] or 1)):
                found = _times(found, BASE[name], sign)
    return found


@cache
def _units() -> Mapping[Exponents, str]:
    """Return the SI unit for each dimension."""
    found: dict[Exponents, str] = {}
    for dimension in DIMENSIONS:
        for unit, factor in dimension.units.items():
            if factor == 1:
                found.setdefault(_exponents(unit), unit)
    return found


def _named(exponents: Exponents) -> str:
    """Return the unit of a dimension in words, for use in error messages."""
    if exponents == PLAIN:
        return "numbers"
    if exponents in _units():
        return _units()[exponents]
    parts = zip(("kg", "m", "s", "rad"), exponents, strict=True)
    return " ".join(f"{unit}{x if x != 1 else ''}" for unit, x in parts if x)
