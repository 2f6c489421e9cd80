"""What is laid over the data of a scene: the scene that extends it, and settings of the command line.

`extends: other.yaml` merges mappings key by key (lists and values replace); marks keep their own file.
"""

from __future__ import annotations

from collections.abc import Iterator

from .source import DEEPEST, Data, Mark, Path, Source, child, read

__all__ = ["merged", "override"]


def merged(below: Source, above: Source) -> Source:
    """A scene with another one laid over it."""
    keys, values = dict(below.keys), dict(below.values)
    found = Source(above.name, below.data, keys, values, below.faults + above.faults, root=above.root)
    laid = _overlay(found, above, below.data, above.data, ())
    found.data = laid if isinstance(laid, dict) else {}
    found.values[()] = above.mark(())
    return found


def override(source: Source, setting: str) -> None:
    """Lays one `dotted.path=text` over the scene; its marks point into the setting itself."""
    dotted, equals, text = setting.partition("=")
    file = "--set"
    path: Path = tuple(int(part) if part.isdecimal() and len(part) < 10 else part for part in dotted.strip().split("."))
    mark = Mark(file, 1, len(dotted) + 2 + len(text) - len(text.lstrip()), setting)
    if not equals or not dotted.strip():
        source.fault((), "write a setting as key=value", mark=Mark(file, 1, 1, setting))
        return
    inner = read(f"value: {text.strip()}", file)
    if inner.faults:
        source.fault(path, inner.faults[0].sentence, mark=mark)
        return
    if len(path) > DEEPEST:
        source.fault((), f"a setting has at most {DEEPEST} levels, this one has {len(path)}", mark=mark)
        return
    at: Data = source.data
    for depth, part in enumerate(path[:-1]):
        below = child(at, part)
        if below is None and isinstance(at, dict) and isinstance(part, str):
            below = at[part] = {}
            source.keys[path[: depth + 1]] = Mark(file, 1, 1, setting)
        at = below
    last, value = path[-1], inner.data["value"]
    _forget(source, path, child(at, last))
    match at, last:
        case dict(), str():
            at[last] = value
        case list(), int() if last < len(at):
            at[last] = value
        case _:
            source.fault(path, f"the scene has no place '{dotted}'", mark=Mark(file, 1, 1, setting))
            return
    source.keys[path] = Mark(file, 1, 1, setting)
    for below_path in inner.values:
        if below_path:
            source.values[(*path, *below_path[1:])] = mark


def _overlay(merged: Source, upper: Source, below: Data, above: Data, path: Path) -> Data:
    if isinstance(below, dict) and isinstance(above, dict):
        joined = dict(below)
        for key, value in above.items():
            joined[key] = _overlay(merged, upper, below.get(key), value, (*path, key))
        if path:
            _take(merged, upper, path)
        return joined
    _forget(merged, path, below)
    for found in _paths(above, path):
        _take(merged, upper, found)
    return above


def _take(merged: Source, upper: Source, path: Path) -> None:
    if path in upper.values:
        merged.values[path] = upper.values[path]
    if path in upper.keys:
        merged.keys[path] = upper.keys[path]


def _forget(source: Source, path: Path, value: Data) -> None:
    for found in _paths(value, path):
        source.keys.pop(found, None)
        source.values.pop(found, None)


def _paths(value: Data, path: Path) -> Iterator[Path]:
    """The path of a value and of all in it."""
    yield path
    below = value if isinstance(value, dict) else dict(enumerate(value)) if isinstance(value, list) else {}
    for key, each in below.items():
        yield from _paths(each, (*path, key))
