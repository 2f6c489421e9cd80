"""Inputs of a scene by the path that `--set` takes, with `x`, `y`, `z` for the numbers of a place: `block.com.x`.

Each has its value, the unit in which it is written, and a scale, by which it may be off: its own size, of a place at
least a metre, of an efficiency a tenth.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import floor, inf, log10
from typing import Any, get_args

from heavylift.kernel.errors import SceneError
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.loading import parse
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path, read
from heavylift.nodes.scene.text.units import DIMENSIONS, EFFICIENCY, NUMBER, Dimension, Limited, tidy
from pydantic import BaseModel

__all__ = ["Parameter", "parameters", "settings", "varied"]

AXES = {"x": 0, "y": 1, "z": 2}
SCALES = {"length": 1.0, "efficiency": 0.1}  # SI, of quantities whose own size says little of their uncertainty
FREE = ("length", "angle")  # may change their sign
FAR = 20.0  # times more or less: an input that leads there is not told by the log
DIGITS = 6  # of a value without uncertainty


@dataclass(frozen=True)
class Parameter:
    """An input: how it was named, its path in the scene's data, value and scale in SI, unit and what that is in SI;
    `whole`: what must be written first for the path to be there."""

    name: str
    path: Path
    value: float
    scale: float
    unit: str
    factor: float
    bounds: tuple[float, float]
    whole: str = ""

    def rounded(self, value: float, sigma: float) -> tuple[str, str]:
        """A value and two standard uncertainties, as people write them, to two digits of the latter."""
        half = 2.0 * sigma / self.factor
        places = 1 - floor(log10(half)) if half > 0.0 else DIGITS
        texts = (f"{round(x, places):.{max(0, places)}f} {self.unit}" for x in (value / self.factor, half))
        first, second = (text.strip() for text in texts)
        return first, second


def parameters(scene: LoadedScene, names: Sequence[str]) -> list[Parameter]:
    """The inputs of these names; SceneError for one that the scene has not, or that is no quantity."""
    data = read(scene.merged or scene.text, scene.path.name).data
    found = [_parameter(scene, data, name) for name in dict.fromkeys(names)]
    if twice := next((p for i, p in enumerate(found) if p.path in [q.path for q in found[:i]]), None):
        raise SceneError(f"--estimate {twice.name}: is named twice; once is enough")
    return found


def settings(inputs: Sequence[Parameter], values: Sequence[str]) -> list[str]:
    """What `--set` takes to give inputs these values."""
    first = dict.fromkeys(p.whole for p in inputs if p.whole)
    return [*first, *(f"{'.'.join(map(str, p.path))}={text}" for p, text in zip(inputs, values, strict=True))]


def varied(scene: LoadedScene, inputs: Sequence[Parameter], values: Sequence[float]) -> LoadedScene:
    """The scene with other values, modelled and integrated as it was; SceneError if it is none."""
    texts = [f"{x / p.factor!r} {p.unit}".strip() for p, x in zip(inputs, values, strict=True)]
    other = parse(scene.merged or scene.text, scene.path.name, settings(inputs, texts))
    return replace(other, plan=_as(other.plan, scene.plan))


def _as(new: Plan, old: Plan) -> Plan:
    """How it is modelled and integrated, and what follows a log, do not change with an input."""
    import msgspec

    kept = ("fidelity", "method", "tolerance", "step", "driven", "end")
    return msgspec.structs.replace(new, **{key: getattr(old, key) for key in kept})


def _parameter(scene: LoadedScene, data: dict[str, Any], name: str) -> Parameter:
    at: Any = scene.scene
    kind: Any = type(scene.scene)
    written: Any = data
    path, whole = list[str | int](), ""
    for word in name.split("."):
        key: str | int = word
        if isinstance(at, BaseModel):
            field = next((f for f in type(at).model_fields if word in (f, f.replace("_", " "))), "")
            known = [f.replace("_", " ") for f in type(at).model_fields]
            if not field:
                raise SceneError(f"--estimate {name}: there is no '{word}'; {closest(word, known)}")
            info = type(at).model_fields[field]
            at, kind, key = getattr(at, field), (info.annotation, *info.metadata), info.alias or field
            key = field if isinstance(written, dict) and field in written else key
        elif isinstance(at, dict):
            if word not in at:
                raise SceneError(f"--estimate {name}: there is no '{word}'; {closest(word, at)}")
            at = at[word]
        elif isinstance(at, list | tuple):
            number = AXES.get(word, int(word) if word.isdecimal() else -1)
            if not 0 <= number < len(at):
                raise SceneError(f"--estimate {name}: there is no '{word}' among {len(at)}")
            if not isinstance(written, list):
                numbers = ", ".join(f"{x!r} {_si(_dimension(kind))}" for x in at)
                whole = f"{'.'.join(map(str, path))}=[{numbers}]"
            at, key = at[number], number
        else:
            raise SceneError(f"--estimate {name}: '{path[-1]}' is a quantity and has no '{word}'")
        written = _below(written, key)
        path.append(key)
    dimension = _dimension(kind)
    if dimension is None or isinstance(at, bool) or not isinstance(at, int | float | None):
        raise SceneError(f"--estimate {name}: is no quantity; name one, such as block.mass")
    if at is None:
        raise SceneError(f"--estimate {name}: the scene gives it no value; write one from which to begin")
    text = re.fullmatch(rf"\s*{NUMBER}\s*(.*?)\s*", str(written)) if written is not None else None
    unit = tidy(text[1]) if text else next(iter(dimension.units))
    scale = max(abs(at), SCALES.get(dimension.name, 0.0)) if dimension.name != "efficiency" else SCALES["efficiency"]
    factor = float(dimension.units.get(unit, 1))
    bounds = (at / FAR, at * FAR) if at > 0.0 and dimension.name not in FREE else (-inf, inf)
    if isinstance(dimension, Limited):
        bounds = (dimension.number(dimension.lowest), dimension.number(dimension.highest))
    return Parameter(name, tuple(path), float(at), scale or 1.0, unit, factor, bounds, whole)


def _below(data: Any, key: str | int) -> Any:
    if isinstance(data, dict):
        return data.get(key)
    return data[key] if isinstance(data, list) and isinstance(key, int) and key < len(data) else None


def _dimension(kind: Any) -> Dimension | None:
    """The dimension that an annotation of a key tells, however deep."""
    told = getattr(kind, "json_schema", None)
    if isinstance(told, dict) and (name := told.get("dimension", "")):
        return next((d for d in (*DIMENSIONS, EFFICIENCY) if d.name == name), None)
    parts = kind if isinstance(kind, tuple) else (*get_args(kind), *getattr(kind, "__metadata__", ()))
    return next((found for part in parts if (found := _dimension(part))), None)


def _si(dimension: Dimension | None) -> str:
    return next((unit for unit, factor in dimension.units.items() if factor == 1), "") if dimension else ""
