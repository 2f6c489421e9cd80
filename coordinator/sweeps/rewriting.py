"""A scene's text with other values in it: each is replaced where it stands, all else stays as it was written."""

from __future__ import annotations

from collections.abc import Mapping

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.text.source import Mark, Path, Source, ordered, read


def rewritten(text: str, name: str, changes: Mapping[Path, str]) -> str:
    """The text with these values at paths; a new key comes before the second of its mapping.

    A comment behind a value keeps its column as long as there is room.  Raises SceneError where a value cannot be
    replaced alone: one of several lines, an alias, one that stands in another file.
    """
    source, lines = read(text, name), text.splitlines(keepends=True)
    at = {path: _mark(source, path) for path in changes}
    for path in sorted(changes, key=lambda path: (at[path].line, at[path].column), reverse=True):  # the last one first
        line, column, value = at[path].line - 1, at[path].column - 1, changes[path]
        before, after = lines[line][:column], lines[line][column:]
        if path in source.values:
            lines[line] = before + _replaced(after, str(source.at(path)), value)
        elif before.strip(" -"):  # in braces, or the only key of its line
            lines[line] = f"{before}{path[-1]}: {value}, {after}"
        else:
            lines[line] = f"{before}{path[-1]}: {value}\n{' ' * column}{after}"
    found = "".join(lines)
    for path, value in changes.items():
        inside = source.at(path[:-1])
        if isinstance(inside, dict) and isinstance(path[-1], str):
            inside[path[-1]] = value
    if ordered(read(found, name).data) != ordered(source.data):
        raise SceneError(f"{name}: cannot be written with its comments; write each order on a line of its own")
    return found


def _mark(source: Source, path: Path) -> Mark:
    """Where a value stands, or the key before which a new one goes."""
    if path in source.values:
        return source.values[path]
    inside = source.at(path[:-1])
    keys = [source.keys[(*path[:-1], key)] for key in inside] if isinstance(inside, dict) else []
    own = [mark for mark in keys[1:2] if mark.line > keys[0].line]
    return (own or keys or [source.mark(path)])[0]


def _replaced(text: str, old: str, new: str) -> str:
    """A line from a value on, with another value."""
    if not text.startswith(old):
        return text
    rest = text[len(old) :]
    blanks = len(rest) - len(rest.lstrip(" "))
    if rest[blanks : blanks + 1] == "#":
        rest = " " * max(1, blanks + len(old) - len(new)) + rest[blanks:]
    return new + rest
