"""Numbers, units, ranges and uncertainties as text: the tokens that values, phrases, arithmetic and options have in
common.

The module also gives hints for decimal commas, clock times, dashes and spelled-out units, and explains YAML errors in
the user's terms, at the place where they begin.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:  # a scene that is remembered is not parsed
    from ruamel.yaml.error import MarkedYAMLError
    from ruamel.yaml.reader import ReaderError

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
    """A range such as `300 t..900 t by 50 t`: numbers and units as text; those of the step may be empty."""

    low: str
    unit_low: str
    high: str
    unit: str
    step: str
    unit_step: str


class Reader:
    """Parser of a line, which reads it token by token; `at` is the column of the next token."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0
        self.move(0)

    @property
    def rest(self) -> str:
        """The text that has not been read yet."""
        return self.text[self.at :]

    def move(self, at: int) -> None:
        """Move to a column and skip the spaces that follow."""
        self.at = len(self.text) - len(self.text[at:].lstrip())


def number_and_unit(text: str) -> tuple[str, str]:
    """Return the number and the unit of a quantity as text; two empty texts if the text is not a quantity."""
    found = _QUANTITY.fullmatch(text)
    return (found[1], tidy(found[2])) if found else ("", "")


def unit_in(text: str, units: Collection[str]) -> str:
    """Return the unit of a quantity if it is one of `units`; otherwise the first of `units`."""
    unit = number_and_unit(text)[1]
    return unit if unit in units else next(iter(units))


def range_of(text: str) -> Range | None:
    """Return the parts of a range; None if the text is not a range."""
    found = _RANGE.fullmatch(text)
    return Range(*(part or "" for part in found.groups())) if found else None


def spread_of(text: str) -> tuple[str, str, str] | None:
    """Split a text such as `480 t +- 3 %` into value or name, "+-" or "sd", and half-width; None for other texts."""
    found = _SPREAD.fullmatch(text)
    return (found[1], "sd" if found[2].startswith("s") else "+-", found[3].strip()) if found else None


def punctuation(text: str, units: Collection[str]) -> str:
    """Return a hint for a number with a decimal comma, a dash as minus sign, or the form of a clock time; else ""."""
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
    """Return the known unit that `unit` means, if `unit` is written out or with other capitals; otherwise ""."""
    words = re.sub(r"\s*\bper\b\s*", "/", unit, flags=re.IGNORECASE)
    short = re.sub(r"[A-Za-z]+", lambda word: SPELLED.get(word[0].lower().removesuffix("s"), word[0]), words)
    same = [known for known in units if known and known.lower() == short.lower()]
    return short if short in same else same[0] if len(same) == 1 else ""


def tidy(unit: str) -> str:
    """Return a unit in standard spelling, without superscripts, dots and double spaces."""
    for old, new in (("²", "2"), ("³", "3"), ("·", " "), ("*", " "), ("^", ""), ("°", "deg")):
        unit = unit.replace(old, new)
    return " ".join(unit.split())


Place = tuple[int, int]  # line and column, from 0

QUOTE = "the quote that opens here is never closed"
TABS = "indent with spaces, not tabs"
BRACKETS = {"sequence": ("list", "]"), "mapping": ("mapping", "}")}
RESERVED = re.compile(r"found character '(.)' that cannot start any token")
STRAY = re.compile(r"found '([\]}])'")


def explained(error: MarkedYAMLError, lines: Sequence[str]) -> tuple[str, Place]:
    """Return a sentence that explains a YAML error, and the place of the error (line, column) in `lines`."""
    context, problem = error.context or "", " ".join(str(error.problem or error.context).split())
    mark = error.problem_mark or error.context_mark
    here = (min(mark.line, len(lines) - 1), mark.column) if mark else (0, 0)
    begin = (error.context_mark.line, error.context_mark.column) if error.context_mark else here
    if "\\t" in problem:
        return (f"a tab stands before this; {TABS}" if here[1] else TABS), here
    if "quoted scalar" in context and "end of stream" in problem:
        return QUOTE, begin
    if here[1] and "scalar" in problem and (opened := _opened(lines, here)):
        return opened
    if found := re.search(r"flow (sequence|mapping)", context):
        what, bracket = BRACKETS[found[1]]
        return f"the {what} that opens here is not closed by '{bracket}', or a comma is missing in it", begin
    if "could not find expected ':'" in problem:
        return "a colon is missing behind this key: write 'key: value'", begin
    if problem == "mapping values are not allowed here":
        return _value(lines, here)
    if "block sequence" in problem or ("block end" in problem and "mapping start" in problem):
        return _indent(lines, here)
    if "block end" in problem and "'-'" in problem:
        return "an item of a list stands among keys: indent it below the key whose list it is in", here
    if "block end" in problem and "scalar" in problem:
        return "text follows after the closing quote: put the quotes around all of it", here
    if found := STRAY.search(problem):
        return f"nothing is open that this '{found[1]}' closes", here
    if problem == "sequence entries are not allowed here":
        return "a list with '-' begins on a line of its own; in one line write [first, second]", here
    if found := RESERVED.search(problem):
        return f"a text that begins with '{found[1]}' needs quotes around it", here
    if "undefined alias" in problem:
        return (
            f"{problem.removeprefix('found ')}: no '&name' stands above; a text that begins with '*' needs quotes",
            here,
        )
    if "another document" in problem:
        return "'---' begins a second document; a scene is one", here
    return f"this is not YAML: {problem}", here


def unreadable(error: ReaderError, text: str) -> tuple[str, Place]:
    """Return a sentence about the first character that YAML does not allow, and its place (line, column)."""
    before = text[: error.position].splitlines() or [""]
    return f"delete the control character U+{error.character:04X} here", (len(before) - 1, len(before[-1]))


def _opened(lines: Sequence[str], at: Place) -> tuple[str, Place] | None:
    """Explain text after a closing quote, and return its place, or that of the quote that closes too late; None if
    there is no such text."""
    before = "\n".join([*lines[: at[0]], lines[at[0]][: at[1]]]).rstrip(" ")
    quote = before[-1:]
    start = before.rfind(quote, 0, -1) if quote in ("'", '"') else -1
    line, column = before.count("\n", 0, start), start - before.rfind("\n", 0, start) - 1
    if start < 0 or (line == at[0] and not re.search(r"[,:]\s", before[start + 1 : -1])):
        return None  # all in one value: it is the text behind it that is wrong
    return f"the quote that opens here closes only at the next one, in line {at[0] + 1}: one of them is missing", (
        line,
        column,
    )


def _value(lines: Sequence[str], at: Place) -> tuple[str, Place]:
    """Explain a misplaced colon: a second one in a line, or an error in the line above."""
    line, column = at
    if re.search(r":\s", lines[line][:column]):
        return "a second ':' in one line: put the inner key on a line of its own, or quotes around the text", at
    above = next((i for i in range(line - 1, -1, -1) if lines[i].partition("#")[0].strip()), line)
    text = lines[above].partition("#")[0]
    begin = len(text) - len(text.lstrip())
    if found := re.match(r"[\s-]*[^:'\"]+:(?=\S)", text):
        return "a space is missing after this colon: write 'key: value'", (above, found.end() - 1)
    if ":" not in text:
        return "a colon is missing behind this key: write 'key: value'", (above, begin)
    return _indent(lines, (line, _indented(lines[line])))


def _indent(lines: Sequence[str], at: Place) -> tuple[str, Place]:
    line = at[0]
    above = next((i for i in range(line - 1, -1, -1) if lines[i].partition("#")[0].strip()), line)
    own, other = _indented(lines[line]), _indented(lines[above])
    message = f"this line is indented by {own}, line {above + 1} above it by {other}"
    return f"{message}: the keys of one mapping and the items of one list begin in one column", (line, own)


def _indented(text: str) -> int:
    return len(text) - len(text.lstrip(" "))
