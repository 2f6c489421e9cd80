"""Inputs of a scene by the path that `--set` takes, with `x`, `y`, `z` for the numbers of a place: `block.com.x`.

They are estimated, or their uncertainty is stated; either way the scene of a recording runs again in this process with
other values.  Each has a value, the unit in which it is written, and a scale, by which it may be off: its own size, of
a place at least a metre, of what lies between two ends a fifth of their distance.  Estimates are written back into the
scene, its comments kept; their uncertainty stands in a comment above the part, `block.mass: 481.2 t +- 1.1 t`.
"""

from __future__ import annotations

import io
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import floor, inf, log10
from pathlib import Path as FilePath
from typing import Any, get_args

import msgspec
import numpy as np
from heavylift.coordinator.run import run
from heavylift.coordinator.run.resume import Beginning
from heavylift.kernel.errors import HeavyliftError, RecordingError, SceneError
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.keys.base import written
from heavylift.nodes.scene.loading import parse
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.overlay import override
from heavylift.nodes.scene.text.source import Path, Source, ordered, read
from heavylift.nodes.scene.text.units import NUMBER, Dimension, Limited, Quantity, tidy
from heavylift.recordings import Recording
from numpy.typing import NDArray
from pydantic import BaseModel
from ruamel.yaml import YAML

from .alignment import Curve
from .mapping import PLUS, Channel, stated
from .validation import curves_of

__all__ = ["Parameter", "parameters", "scene_text", "simulator", "spread", "uncertain", "varied"]

AXES = {"x": 0, "y": 1, "z": 2}
LEAST = {"length": 1.0}  # scale [SI] of quantities whose own size says little of their uncertainty
SIGNED = ("length", "angle")
FAR = 20.0  # times more or less: an input that leads there is not told by the log
DIGITS = 6  # of a value without uncertainty
SAMPLES = (20.0, 100.0)  # [Hz] at least and at most, between which samples are as many as the log's rows
TIGHT = 1e-7  # tolerance at which differences of two runs are those of their inputs
Floats = NDArray[np.float64]
Simulate = Callable[[Floats], list[Curve]]
KEPT = ("fidelity", "method", "tolerance", "tensions_only", "step", "driven", "end")  # of a plan, whatever an input is


@dataclass(frozen=True)
class Parameter:
    """An input: how it was named, value, scale and bounds in SI, its unit among those that it can have, its path in the
    scene's data; `whole`: what must be written first for the path to be there."""

    name: str
    value: float
    scale: float
    bounds: tuple[float, float] = (-inf, inf)
    unit: str = ""
    units: Mapping[str, Fraction] = field(default_factory=lambda: {"": Fraction(1)})
    path: Path = ()
    whole: str = ""

    @property
    def factor(self) -> float:
        """What its unit is in SI."""
        return float(self.units[self.unit])

    def rounded(self, value: float, sigma: float) -> tuple[str, str]:
        """A value and two standard uncertainties, as people write them, to two digits of the latter."""
        half = 2.0 * sigma / self.factor
        places = 1 - floor(log10(half)) if half > 0.0 else DIGITS
        texts = (f"{round(x, places):.{max(0, places)}f} {self.unit}" for x in (value / self.factor, half))
        first, second = (text.strip() for text in texts)
        return first, second


def parameters(scene: LoadedScene, names: Sequence[str]) -> list[Parameter]:
    """The inputs of these names; SceneError for one that the scene has not, or that is no quantity."""
    source = read(scene.merged or scene.text, scene.path.name)
    found = [_parameter(scene, source, name) for name in names]
    if twice := next((p for i, p in enumerate(found) if p.path in [q.path for q in found[:i]]), None):
        raise SceneError(f"input {twice.name}: is named twice; once is enough")
    return found


def uncertain(scene: LoadedScene, texts: Sequence[str]) -> tuple[list[Parameter], Floats]:
    """Inputs with their standard uncertainties (m,), as in `block.mass +- 3 %`, which is that at a level of 95 %."""
    parts = [re.split(PLUS, text, maxsplit=1) for text in texts]
    if bare := next((text for text, part in zip(texts, parts, strict=True) if len(part) < 2), ""):
        raise SceneError(f"input {bare}: write its uncertainty behind it, such as 'block.mass +- 3 %'")
    inputs, sigma = parameters(scene, [name.strip() for name, _ in parts]), []
    for p, (_, half) in zip(inputs, parts, strict=True):
        try:
            sigma.append(stated(half, np.array([p.value]), p.units)[0])
        except ValueError as error:
            raise SceneError(f"input {p.name}: {error}") from None
    return inputs, np.array(sigma)


def varied(scene: LoadedScene, inputs: Sequence[Parameter], values: Sequence[float]) -> LoadedScene:
    """The scene with other values, modelled and integrated as it was; SceneError if it is none."""
    texts = [f"{x / p.factor!r} {p.unit}" for p, x in zip(inputs, values, strict=True)]
    other = parse(scene.merged or scene.text, scene.path.name, _settings(inputs, texts))
    return replace(other, plan=msgspec.structs.replace(other.plan, **{x: getattr(scene.plan, x) for x in KEPT}))


def simulator(
    begun: Beginning, inputs: Sequence[Parameter], channels: list[Channel], rows_hz: float, say: Callable[[str], None]
) -> Simulate:
    """Curves of the channels for values of the inputs; HeavyliftError names the values that make no run."""
    hz = begun.scene.plan.samples_hz
    rate = min(max(SAMPLES[0], rows_hz, hz), max(SAMPLES[1], hz))

    def simulate(values: Floats) -> list[Curve]:
        given = ", ".join(f"{p.name} {x / p.factor:.6g} {p.unit}".strip() for p, x in zip(inputs, values, strict=True))
        say(given)
        try:
            other = varied(begun.scene, inputs, values.tolist())
            plan = msgspec.structs.replace(other.plan, samples_hz=rate, tolerance=min(other.plan.tolerance, TIGHT))
            with tempfile.TemporaryDirectory(prefix="heavylift-", ignore_cleanup_errors=True) as folder:
                made = FilePath(folder) / "run.mcap"
                run(replace(other, plan=plan), made, in_process=True, commands=begun.commands)
                return curves_of(Recording(made), channels)
        except HeavyliftError as error:
            raise RecordingError(f"with {given} there is no run: {error}") from None

    return simulate


def spread(simulate: Simulate, values: Floats, sigma: Floats, own: Sequence[Curve]) -> list[Floats]:
    """Standard uncertainty of each curve, at the times of the run's own, from that of the inputs."""
    squares = [np.zeros(len(T)) for T, _ in own]
    for step in np.diag(sigma):
        pairs = zip(simulate(values + step), simulate(values - step), strict=True)
        for square, (T, _), (up, down) in zip(squares, own, pairs, strict=True):
            square += (0.5 * (np.interp(T, *up) - np.interp(T, *down))) ** 2
    return [np.sqrt(square) for square in squares]


def scene_text(
    scene: LoadedScene, inputs: Sequence[Parameter], estimates: Mapping[str, tuple[str, str]], source: str
) -> str:
    """The text of a scene with estimates, (value, uncertainty) by name, from the log `source`.

    What was laid over the scene for its run, by `extends` or `--set`, is written out.
    """
    name, out, yaml = scene.path.name, io.StringIO(), YAML()
    yaml.preserve_quotes, yaml.width = True, 10_000  # lines stay as long as they are
    yaml.indent(mapping=2, sequence=4, offset=2)
    fitted, wanted = [p for p in inputs if p.name in estimates], read(scene.merged or scene.text, name)
    for setting in _settings(fitted, [estimates[p.name][0] for p in fitted]):
        override(wanted, setting)
    data = _laid(yaml.load(scene.text), wanted.data)
    for part in dict.fromkeys(p.path[0] for p in fitted):
        lines = [f"  {p.name}: {' +- '.join(estimates[p.name])}" for p in fitted if p.path[0] == part]
        data.yaml_set_comment_before_after_key(part, before="\n".join([f"from {source}, 95 %:", *lines]))
    yaml.dump(data, out)
    if ordered(read(out.getvalue(), name).data) != ordered(wanted.data):
        raise SceneError(f"{name}: cannot be written with its comments; set the estimates with --set")
    parse(out.getvalue(), name)
    return out.getvalue()


def _parameter(scene: LoadedScene, source: Source, name: str) -> Parameter:
    at: Any = scene.scene
    kind: Any = None
    path: Path = ()
    whole = ""
    for word in name.split("."):
        key: str | int = word
        below: dict[Any, tuple[Any, Any]]  # value and annotation of all that is here
        if isinstance(at, BaseModel):
            fields = type(at).model_fields.items()
            below = {f.alias or each: (getattr(at, each), (f.annotation, *f.metadata)) for each, f in fields}
            key = written(word)
        elif isinstance(at, dict):
            below = {each: (value, kind) for each, value in at.items()}
        elif isinstance(at, list | tuple):
            below = {i: (value, kind) for i, value in enumerate(at)}
            key = AXES.get(word, int(word) if word.isdecimal() else word)
            if not isinstance(source.at(path), list) and (found := _dimension(kind)):
                si = next(unit for unit, factor in found.units.items() if factor == 1)
                whole = f"{'.'.join(map(str, path))}=[{', '.join(f'{x!r} {si}' for x in at)}]"
        else:
            raise SceneError(f"input {name}: '{path[-1]}' is a quantity and has no '{word}'")
        if key not in below:
            raise SceneError(f"input {name}: there is no '{word}'; {closest(word, map(str, below))}")
        at, kind = below[key]
        path = (*path, key)
    dimension = _dimension(kind)
    if dimension is None or isinstance(at, bool) or not isinstance(at, int | float | None):
        raise SceneError(f"input {name}: is no quantity; name one, such as block.mass")
    if at is None:
        raise SceneError(f"input {name}: the scene gives it no value; write one from which to begin")
    text = re.fullmatch(rf"\s*{NUMBER}\s*(.*?)\s*", str(source.at(path)))
    unit = tidy(text[1]) if text and tidy(text[1]) in dimension.units else next(iter(dimension.units))
    scale = max(abs(at), LEAST.get(dimension.name, 0.0)) or 1.0
    bounds = (at / FAR, at * FAR) if at > 0.0 and dimension.name not in SIGNED else (-inf, inf)
    if isinstance(dimension, Limited):
        bounds = (dimension.number(dimension.lowest), dimension.number(dimension.highest))
        scale = 0.2 * (bounds[1] - bounds[0])
    return Parameter(name, float(at), scale, bounds, unit, dimension.units, path, whole)


def _dimension(kind: Any) -> Dimension | None:
    """The dimension that an annotation of a key tells, however deep."""
    if isinstance(kind, Quantity):
        return kind.dimension
    parts = kind if isinstance(kind, tuple) else get_args(kind)
    return next((found for part in parts if (found := _dimension(part))), None)


def _settings(inputs: Sequence[Parameter], values: Sequence[str]) -> list[str]:
    """What `--set` takes to give inputs these values."""
    first = dict.fromkeys(p.whole for p in inputs if p.whole)
    return [*first, *(f"{'.'.join(map(str, p.path))}={text}" for p, text in zip(inputs, values, strict=True))]


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
