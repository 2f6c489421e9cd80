"""Inputs of a scene: quantities by the path that `--set` accepts, with `x`, `y`, `z` for the coordinates of a place.

    uncertain_inputs(scene)                  those with an uncertainty: value, kind and spread of each
    uncertain_inputs(scene, ["block.mass +- 3 %"])           with further stated uncertainties
    inputs(scene, ["block.com.x"])           inputs by name
    varied(scene, inputs, values)            the scene with other values

The scale of an input is its typical variation: its magnitude; for a coordinate at least a metre; for a value between
two ends a fifth of their distance.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from fractions import Fraction
from math import floor, inf, log10, sqrt
from typing import Any

import msgspec
from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.keys.base import written
from heavylift.nodes.scene.keys.quantities import below, quantity
from heavylift.nodes.scene.keys.validate import listed, uncertainties
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.overlay import made, next_key, parts
from heavylift.nodes.scene.text.source import Path, SourceText, read
from heavylift.nodes.scene.text.spelling import spread_of, unit_in
from heavylift.nodes.scene.text.uncertainty import Kind, Stated, standard
from heavylift.nodes.scene.text.units import Limited, Quantity
from heavylift.recordings.format.spellings import BEAMS
from pydantic import BaseModel

from .instances import OWN
from .loaded_scene import LoadedScene
from .loading import parse

AXES = {"x": 0, "y": 1, "z": 2}
LEAST = {"length": 1.0}  # scale [SI] of quantities whose own size says little of their uncertainty
SIGNED = ("length", "angle")
FAR = 20.0  # times more or less: a log cannot tell of an input that leads there
DIGITS = 6  # of a value without uncertainty
KEPT = ("fidelity", "method", "tolerance", "step", "driven", "end")  # of a plan, whatever an input is
USUAL = (  # inputs that a yard knows with an uncertainty, and that a lift depends on
    *("block.mass", "block.com", "rig.sling.EA", f"rig.{BEAMS}.*.sling", "cranes.*.fall EA", "cranes.*.rope damping"),
    *("cranes.*.girder stiffness", "cranes.*.sheave efficiency", "mechanism.bodies.*.mass", "mechanism.bodies.*.com"),
    *("mechanism.ropes.*.EA", "mechanism.ropes.*.length", "mechanism.ropes.*.damping", "mechanism.*.stiffness"),
    *("mechanism.ropes.*.over.*.efficiency", "mechanism.forces.*.speed"),
)


@dataclass(frozen=True)
class Input:
    """An input of a scene: its name, value, typical variation (`scale`) and bounds in SI units, its unit, and its path.

    `whole`: a setting that must be applied first because it writes the whole list, with default values, to which the
    input belongs."""

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
        """The size of the input's unit in SI units."""
        return float(self.units[self.unit])

    def rounded(self, value: float, sigma: float) -> tuple[str, str]:
        """Return the value and its expanded uncertainty (two standard uncertainties) as rounded text.

        Both are rounded to the second significant digit of the uncertainty."""
        half = 2.0 * sigma / self.factor
        places = 1 - floor(log10(half)) if half > 0.0 else DIGITS
        texts = (f"{round(x, places):.{max(0, places)}f} {self.unit}" for x in (value / self.factor, half))
        first, second = (text.strip() for text in texts)
        return first, second


@dataclass(frozen=True)
class UncertainInput(Input):
    """An input with its standard uncertainty in SI units and the `kind` of its distribution: normal or uniform."""

    kind: Kind = "normal"
    sd: float = 0.0

    @property
    def half(self) -> float:
        """Half-width of the uncertainty in SI units: of the 95 % interval or, for a uniform input, of its range."""
        return (sqrt(3.0) if self.kind == "uniform" else 2.0) * self.sd

    @property
    def spread(self) -> str:
        """Name of the input and half-width of its uncertainty, in per cent of the value or in its unit."""
        if self.value and not {"m", "deg", ""} & set(self.units):
            return f"{self.name} {100.0 * self.half / abs(self.value):.2g} %"
        return f"{self.name} {self.half / self.factor:.2g} {self.unit}".strip()

    def __str__(self) -> str:
        value, half = self.rounded(self.value, self.half / 2.0)
        return f"{self.name} {value} +- {half}{', any as likely' * (self.kind == 'uniform')}"


def inputs(scene: LoadedScene, names: Sequence[str]) -> list[Input]:
    """Return the inputs with these names; raises SceneError if an input does not exist or is not a quantity."""
    source, _ = _source(scene)
    found = [_input(scene, source, name)[0] for name in names]
    if twice := next((p for i, p in enumerate(found) if p.path in [q.path for q in found[:i]]), None):
        raise SceneError(f"input {twice.name}: it is given twice; give it once")
    return found


def uncertain_inputs(scene: LoadedScene, given: Sequence[str] = ()) -> list[UncertainInput]:
    """Return the uncertain inputs of a scene, and of texts such as `block.mass +- 3 %`; raises SceneError."""
    source, stated = _source(scene)
    found = {x.path: x for name in scene.scene.lifts for x in _of_lift(scene, name)}
    found |= {path: _uncertain(*_input(scene, source, _name(scene, path)), each) for path, each in stated.items()}
    named: list[Path] = []
    for text in given:
        form = spread_of(text)
        if form is None:
            raise SceneError(f"input {text}: write its uncertainty after it, such as 'block.mass +- 3 %'")
        one, kind = _input(scene, source, form[0])
        if one.path in named:
            raise SceneError(f"input {one.name}: it is given twice; give it once")
        named.append(one.path)
        found[one.path] = _uncertain(one, kind, Stated(f"{one.value / one.factor!r} {one.unit}", *form[1:]))
    return list(found.values())


def _of_lift(scene: LoadedScene, name: str) -> Iterator[UncertainInput]:
    """Yield the uncertain inputs of one of several lifts."""
    lifts: Any = read(scene.merged, scene.path.name).data["lifts"]
    own, base = lifts[name], f"lifts.{name}."
    text = json.dumps({key: value for key, value in own.items() if key not in OWN})
    for x in uncertain_inputs(parse(text, str(scene.path), followed=False)):
        yield replace(x, name=f"{base}{x.name}", path=("lifts", name, *x.path), whole=x.whole and f"{base}{x.whole}")


def stated(scene: LoadedScene, one: Input, value: str, half: str) -> str:
    """Return a value with its 95 % uncertainty as text; the uncertainty is omitted if the scene would reject it."""
    _, kind = _input(scene, _source(scene)[0], one.name)
    try:
        standard(Stated(value, "+-", half), kind)
    except ValueError:
        return value
    return f"{value} +- {half}"


def varied(scene: LoadedScene, changed: Sequence[Input], values: Sequence[float]) -> LoadedScene:
    """Return the scene with other input values, but the same model level and time steps; raises SceneError."""
    texts = [f"{x / p.factor!r} {p.unit}" for p, x in zip(changed, values, strict=True)]
    other = parse(scene.merged or scene.text, scene.path.name, settings(changed, texts), followed=False)
    kept = {x: getattr(scene.plan, x) for x in KEPT}
    return replace(other, plan=msgspec.structs.replace(other.plan, **kept), chosen=True)


def settings(changed: Sequence[Input], values: Sequence[str]) -> list[str]:
    """Return the settings, in the form of `--set`, that give these values to the inputs."""
    first = dict.fromkeys(p.whole for p in changed if p.whole)
    return [*first, *(f"{'.'.join(map(str, p.path))}={text}" for p, text in zip(changed, values, strict=True))]


def _source(scene: LoadedScene) -> tuple[SourceText, dict[Path, Stated]]:
    """Return the data of the scene with nominal values, and the uncertainties stated in it, by path."""
    source = read(scene.merged or scene.text, scene.path.name)
    return source, uncertainties(source)


def _name(scene: LoadedScene, path: Path) -> str:
    """Return a path in the form in which users write it, with x, y and z for coordinates."""
    at: object = scene.scene
    kind: object = None
    words = []
    for part in path:
        place = isinstance(at, tuple) and len(at) == len(AXES)
        at, kind = below(at, kind)[part]
        words.append([*AXES][part] if place and isinstance(part, int) else str(part))
    return ".".join([*words, *(["x"] if isinstance(at, tuple) else [])])


def _uncertain(one: Input, kind: Quantity, stated: Stated) -> UncertainInput:
    try:
        sd = standard(stated, kind)
    except ValueError as error:
        raise SceneError(f"input {one.name}: {error}") from None
    return UncertainInput(**vars(one), kind=stated.kind, sd=sd)


def _input(scene: LoadedScene, source: SourceText, name: str) -> tuple[Input, Quantity]:
    at: object = scene.scene
    kind: object = None
    path: Path = ()
    whole = ""
    words = parts(name)
    while words:
        inside = below(at, kind)
        word = next_key(words, inside if isinstance(at, dict) else ())
        key: str | int = word
        if isinstance(at, BaseModel):
            key = written(word)
        elif isinstance(at, list | tuple):
            key = AXES.get(word, int(word) if word.isdecimal() else word)
            if not isinstance(source.at(path), list) and (usual := listed(at, kind)):
                whole = f"{'.'.join(map(str, path))}=[{', '.join(map(str, usual))}]"
        elif not inside and not isinstance(at, dict):
            raise SceneError(
                f"input {name}: '{path[-1]}' is a single quantity without a part '{word}'; leave '{word}' out"
            )
        if key not in inside:
            raise SceneError(f"input {name}: there is no '{word}'; {closest(word, map(str, inside))}")
        at, kind = inside[key]
        path = (*path, key)
    found = quantity(kind)
    if at is None:
        raise SceneError(f"input {name}: the scene gives this input no value; write a nominal value")
    if found is None or isinstance(at, bool) or not isinstance(at, int | float):
        raise SceneError(f"input {name}: this is not a quantity; name a quantity, such as block.mass")
    dimension = found.dimension
    source = made(source) if path[:1] == ("machines",) else source
    unit = unit_in(str(source.at(path)), dimension.units)
    scale = max(abs(at), LEAST.get(dimension.name, 0.0)) or 1.0
    bounds = (at / FAR, at * FAR) if at > 0.0 and dimension.name not in SIGNED else (-inf, inf)
    if isinstance(dimension, Limited):
        bounds = (dimension.number(dimension.lowest), dimension.number(dimension.highest))
        scale = 0.2 * (bounds[1] - bounds[0])
    return Input(name, float(at), scale, bounds, unit, dimension.units, path, whole), found


def unstated(scene: LoadedScene, known: Sequence[Input]) -> list[str]:
    """Return the names of inputs that usually are uncertain but have no stated uncertainty in this scene."""
    paths = {part for each in known for part in (each.path, each.path[:-1])}
    found = []

    def look(at: object, kind: object, path: Path) -> None:
        name = ".".join(map(str, path))
        usual = any(fnmatchcase(name, pattern) for pattern in USUAL)
        if usual and quantity(kind) and path not in paths:
            found.append(name)
        for key, (value, inner) in below(at, kind).items() if not usual else ():
            look(value, inner, (*path, key))

    look(scene.scene, None, ())
    return found
