"""Numbers, units, ranges and uncertainties as text: the tokens common to values, phrases, arithmetic and options; and
hints for decimal commas, clock times, dashes and spelled-out units."""

import re
from collections.abc import Collection
from typing import NamedTuple

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
PLUS = r"\+-|\+/-|±"
_QUANTITY = re.compile(rf"\s*({NUMBER}|[+-]?(?:nan|inf))\s*(.*?)\s*")
_RANGE = re.compile(rf"\s*({NUMBER})\s*([^\d.]*?)\s*\.\.\s*({NUMBER})\s*(.*?)\s*(?:\bby\s+({NUMBER})\s*(.*?)\s*)?")
_SPREAD = re.compile(rf"\s*(.+?)\s*({PLUS}|\b(?:sd|sigma)\b)(.*)")
COMMA = re.compile(r"\s*([+-]?)(\d+(?:,\d+)+)(\.\d+)?\s*(.*?)\s*")
CLOCK = re.compile(r"\s*(\d+):([0-5]\d)(?::([0-5]\d))?\s*")
DASHES = re.compile(r"(?<!\w)[\N{MINUS SIGN}\N{EN DASH}\N{EM DASH}\N{HYPHEN}](?=\s*[\d.])")
SPELLED = {  # units as they are spoken
    **dict.fromkeys(("tonne", "ton", "te"), "t"), "kilogram": "kg", "kilo": "kg",
    **dict.fromkeys(("metre", "meter"), "m"), **dict.fromkeys(("millimetre", "millimeter"), "mm"),
    **dict.fromkeys(("centimetre", "centimeter"), "cm"), **dict.fromkeys(("kilometre", "kilometer"), "km"),
    **dict.fromkeys(("second", "sec"), "s"), **dict.fromkeys(("minute", "mins"), "min"),
    **dict.fromkeys(("hour", "hr"), "h"), "day": "days", "millisecond": "ms",
    "degree": "deg", "radian": "rad", "newton": "N", "kilonewton": "kN", "meganewton": "MN",
    "hertz": "Hz", "kilohertz": "kHz", "percent": "%", "pascal": "Pa", "megapascal": "MPa", "gigapascal": "GPa",
}  # fmt: skip


class Range(NamedTuple):
    """A range, `300 t..900 t by 50 t`: each number with its unit as text; without step: ""."""

    low: str
    unit_low: str
    high: str
    unit: str
    step: str
    unit_step: str


class Reader:
    """The unread rest of a line: `at` is the column of the next token."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0
        self.move(0)

    @property
    def rest(self) -> str:
        """The unread rest of the text."""
        return self.text[self.at :]

    def move(self, at: int) -> None:
        """Move to a column, and skip blanks after it."""
        self.at = len(self.text) - len(self.text[at:].lstrip())


def number_and_unit(text: str) -> tuple[str, str]:
    """Return number and unit of a quantity as text; two empty texts if it is not a quantity."""
    found = _QUANTITY.fullmatch(text)
    return (found[1], tidy(found[2])) if found else ("", "")


def unit_in(text: str, units: Collection[str]) -> str:
    """Return the unit in which a quantity is written, if it is one of `units`; else the first of them."""
    unit = number_and_unit(text)[1]
    return unit if unit in units else next(iter(units))


def range_of(text: str) -> Range | None:
    """Return the parts of a range; None for any other text."""
    found = _RANGE.fullmatch(text)
    return Range(*(part or "" for part in found.groups())) if found else None


def spread_of(text: str) -> tuple[str, str, str] | None:
    """Return value or name, "+-" or "sd", and half-width of `480 t +- 3 %`; None for any other text."""
    found = _SPREAD.fullmatch(text)
    return (found[1], "sd" if found[2].startswith("s") else "+-", found[3].strip()) if found else None


def punctuation(text: str, units: Collection[str]) -> str:
    """Return a hint what to write instead of a number with comma or dash, or of a clock time; "" for other texts."""
    if DASHES.search(text):
        return f"a minus sign is the '-' of the keyboard: write '{DASHES.sub('-', text.strip())}'"
    if found := COMMA.fullmatch(text):
        sign, parts, rest, unit = found[1], found[2].split(","), found[3] or "", tidy(found[4])
        unit = unit if unit in units else spelled(unit, units) or next(iter(units))
        whole, point = (f"'{sign}{mark.join(parts)}{rest} {unit}'" for mark in ("", "."))
        if len(parts) > 2 or rest:
            return f"thousands are not set apart: write {whole}"
        thousands = len(parts[1]) == 3 and parts[0] != "0"
        meant = f"{whole} or {point}, as it is meant" if thousands else point
        return f"a decimal has a point, no comma: write {meant}"
    if "min" in units and (found := CLOCK.fullmatch(text)):
        first, second, third = found.groups()
        seconds = 60 * int(first) + int(second)
        if third is not None:
            return f"write it in one unit, '{60 * seconds + int(third)} s'"
        return f"write '{seconds} s' or '{seconds} min', as it is meant"
    return ""


def spelled(unit: str, units: Collection[str]) -> str:
    """Return the known unit that is spelled out or differs in case; "" if there is none."""
    words = re.sub(r"\s*\bper\b\s*", "/", unit, flags=re.IGNORECASE)
    short = re.sub(r"[A-Za-z]+", lambda word: SPELLED.get(word[0].lower().removesuffix("s"), word[0]), words)
    same = [known for known in units if known and known.lower() == short.lower()]
    return short if short in same else same[0] if len(same) == 1 else ""


def tidy(unit: str) -> str:
    """Return a unit in the spelling of the tables: no superscripts, dots or double blanks."""
    for old, new in (("²", "2"), ("³", "3"), ("·", " "), ("*", " "), ("^", ""), ("°", "deg")):
        unit = unit.replace(old, new)
    return " ".join(unit.split())
