"""Estimates written back as inputs: the scene once more, comments kept, with the new values and their uncertainty.

The uncertainty stands in a comment above the part that has the input, one line each, `block.mass: 481.2 t +- 1.1 t`:
path, value, half-width at a level of 95 %.  What was written is read again, and is the scene with the new values or is
not written.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.loading import parse
from heavylift.nodes.scene.text.source import ordered, override, read
from ruamel.yaml import YAML

from .parameters import Parameter

__all__ = ["scene_text"]

WIDTH = 10_000  # lines stay as long as they are


def scene_text(
    scene: LoadedScene, inputs: Sequence[Parameter], estimates: Mapping[str, tuple[str, str]], source: str
) -> str:
    """The text of a scene with estimates, (value, uncertainty) by name, from the log `source`."""
    yaml = YAML()
    yaml.preserve_quotes, yaml.width = True, WIDTH  # type: ignore[assignment]
    yaml.indent(mapping=2, sequence=4, offset=2)
    data = yaml.load(scene.merged or scene.text)
    wanted = read(scene.merged or scene.text, scene.path.name)
    lines: dict[str | int, list[str]] = {}
    for p in inputs:
        if p.name not in estimates:
            continue
        value, half = estimates[p.name]
        for setting in filter(None, (p.whole if _at(data, p.path) is None else "", f"{_dotted(p)}={value}")):
            override(wanted, setting)
        _put(data, p, value, wanted.data)
        lines.setdefault(p.path[0], [f"from {source}, 95 %:"]).append(f"  {p.name}: {value} +- {half}")
    for key, told in lines.items():
        data.yaml_set_comment_before_after_key(key, before="\n".join(told))
    out = io.StringIO()
    yaml.dump(data, out)
    text = out.getvalue()
    if ordered(read(text, scene.path.name).data) != ordered(wanted.data):
        raise SceneError(f"{scene.path.name}: cannot be written with its comments; set the estimates with --set")
    parse(text, scene.path.name)
    return text


def _put(data: Any, p: Parameter, value: str, wanted: Any) -> None:
    """The value at its place; what is missing on the way as it is wanted."""
    for key in p.path[:-1]:
        below = _step(data, key)
        if below is None:
            data[key] = wanted[key]
            return
        data, wanted = (
            below,
            wanted[key if not isinstance(wanted, dict) or key in wanted else str(key).replace(" ", "_")],
        )
    key = p.path[-1]
    if isinstance(data, dict) and key not in data and str(key).replace(" ", "_") in data:
        key = str(key).replace(" ", "_")
    data[key] = value


def _step(data: Any, key: str | int) -> Any:
    if isinstance(data, list):
        return data[key] if isinstance(key, int) and key < len(data) else None
    return data.get(key, data.get(str(key).replace(" ", "_")))


def _at(data: Any, path: Sequence[str | int]) -> Any:
    for key in path:
        if (data := _step(data, key) if isinstance(data, dict | list) else None) is None:
            return None
    return data


def _dotted(p: Parameter) -> str:
    return ".".join(map(str, p.path))
