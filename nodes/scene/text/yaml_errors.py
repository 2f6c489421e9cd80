"""Explanation of errors in a text that is not YAML, in the user's terms, with the place where they begin."""

import re
from collections.abc import Sequence

from ruamel.yaml.error import MarkedYAMLError
from ruamel.yaml.reader import ReaderError

Place = tuple[int, int]  # line and column, from 0

QUOTE = "the quote that opens here is never closed"
TABS = "indent with spaces, not tabs"
BRACKETS = {"sequence": ("list", "]"), "mapping": ("mapping", "}")}
RESERVED = re.compile(r"found character '(.)' that cannot start any token")
STRAY = re.compile(r"found '([\]}])'")


def explained(error: MarkedYAMLError, lines: Sequence[str]) -> tuple[str, Place]:
    """Return a sentence about an error and its place in these lines."""
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
        return "text follows behind the closing quote: put the quotes around all of it", here
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
    """Return a sentence about a character that no text may contain, and its place."""
    before = text[: error.position].splitlines() or [""]
    return f"delete the control character U+{error.character:04X} here", (len(before) - 1, len(before[-1]))


def _opened(lines: Sequence[str], at: Place) -> tuple[str, Place] | None:
    """Explain text behind a closing quote: where the quote opens that closes too late, if that is known."""
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
    """Explain a misplaced colon: a second one in a line, or an error of the line above."""
    line, column = at
    if re.search(r":\s", lines[line][:column]):
        return "a second ':' in one line: put the inner key on a line of its own, or quotes around the text", at
    above = next((i for i in range(line - 1, -1, -1) if lines[i].partition("#")[0].strip()), line)
    text = lines[above].partition("#")[0]
    begin = len(text) - len(text.lstrip())
    if found := re.match(r"[\s-]*[^:'\"]+:(?=\S)", text):
        return "a blank is missing behind this colon: write 'key: value'", (above, found.end() - 1)
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
