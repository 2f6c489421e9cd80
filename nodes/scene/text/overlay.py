"""What is laid over the data of a scene: the scene that extends it, and settings of the command line.

`extends: other.yaml` merges mappings key by key (lists and values replace); marks keep their own file.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .source import DEEPEST, Mark, Path, Source, read

__all__ = ["merged", "override"]


def merged(below: Source, above: Source) -> Source:
    """A scene with another one laid over it."""
    keys, values = dict(below.keys), dict(below.values)
    found = Source(above.name, below.data, keys, values, below.faults + above.faults, root=above.root)
    found.data = _overlay(found, above, below.data, above.data, ())
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
    at: Any = source.data
    for depth, part in enumerate(path[:-1]):
        below = _child(at, part)
        if below is None and isinstance(at, dict) and isinstance(part, str):
            below = at[part] = {}
            source.keys[path[: depth + 1]] = Mark(file, 1, 1, setting)
        at = below
    last = path[-1]
    in_list = isinstance(at, list) and isinstance(last, int) and last < len(at)
    if in_list or (isinstance(at, dict) and isinstance(last, str)):
        _forget(source, path, at[last] if in_list else at.get(last))
        at[last] = inner.data["value"]
    else:
        source.fault(path, f"the scene has no place '{dotted}'", mark=Mark(file, 1, 1, setting))
        return
    source.keys[path] = Mark(file, 1, 1, setting)
    for below_path in inner.values:
        if below_path:
            source.values[(*path, *below_path[1:])] = mark


def _child(at: Any, part: str | int) -> Any:
    if isinstance(at, dict):
        return at.get(part)
    return at[part] if isinstance(at, list) and isinstance(part, int) and part < len(at) else None


def _overlay(merged: Source, child: Source, below: Any, above: Any, path: Path) -> Any:
    if isinstance(below, dict) and isinstance(above, dict):
        joined = dict(below)
        for key, value in above.items():
            joined[key] = _overlay(merged, child, below.get(key), value, (*path, key))
        if path:
            _take(merged, child, path)
        return joined
    _forget(merged, path, below)
    for found in _paths(above, path):
        _take(merged, child, found)
    return above


def _take(merged: Source, child: Source, path: Path) -> None:
    if path in child.values:
        merged.values[path] = child.values[path]
    if path in child.keys:
        merged.keys[path] = child.keys[path]


def _forget(source: Source, path: Path, value: Any) -> None:
    for found in _paths(value, path):
        source.keys.pop(found, None)
        source.values.pop(found, None)


def _paths(value: Any, path: Path) -> Iterator[Path]:
    """The path of a value and of all in it."""
    yield path
    below = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, each in below:
        yield from _paths(each, (*path, key))
