"""Estimates written back as inputs: the scene once more, comments kept, with the new values and their uncertainty.

The uncertainty stands in a comment above the part that has the input, one line each, `block.mass: 481.2 t +- 1.1 t`:
path, value, half-width at a level of 95 %.  What was laid over the scene for its run, by `extends` or `--set`, is
written out.  The text is read again, and is the scene with the new values or is not written.
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

from .parameters import Parameter, settings

__all__ = ["scene_text"]

WIDTH = 10_000  # lines stay as long as they are


def scene_text(
    scene: LoadedScene, inputs: Sequence[Parameter], estimates: Mapping[str, tuple[str, str]], source: str
) -> str:
    """The text of a scene with estimates, (value, uncertainty) by name, from the log `source`."""
    name = scene.path.name
    yaml = YAML()
    yaml.preserve_quotes, yaml.width = True, WIDTH
    yaml.indent(mapping=2, sequence=4, offset=2)
    data, wanted = yaml.load(scene.text), read(scene.merged or scene.text, name)
    fitted = [p for p in inputs if p.name in estimates]
    for setting in settings(fitted, [estimates[p.name][0] for p in fitted]):
        override(wanted, setting)
    data = _laid(data, wanted.data)
    for part in dict.fromkeys(p.path[0] for p in fitted):
        told = [f"  {p.name}: {' +- '.join(estimates[p.name])}" for p in fitted if p.path[0] == part]
        data.yaml_set_comment_before_after_key(part, before="\n".join([f"from {source}, 95 %:", *told]))
    out = io.StringIO()
    yaml.dump(data, out)
    if ordered(read(out.getvalue(), name).data) != ordered(wanted.data):
        raise SceneError(f"{name}: cannot be written with its comments; set the estimates with --set")
    parse(out.getvalue(), name)
    return out.getvalue()


def _laid(data: Any, wanted: Any) -> Any:
    """The data as wanted; what is so already stays the object that it is, with its comments and style."""
    if isinstance(data, dict) and isinstance(wanted, dict):
        for key in [key for key in data if key not in wanted]:
            del data[key]
        for key, value in wanted.items():
            data[key] = _laid(data.get(key), value)
        return data
    if isinstance(data, list) and isinstance(wanted, list) and len(data) == len(wanted):
        for i, value in enumerate(wanted):
            data[i] = _laid(data[i], value)
        return data
    return data if data == wanted and type(data) is not bool else wanted
