"""Variations of a sweep: `--vary PATH=VALUES`, and the resulting variants.

    block.mass=200..400 t by 25 t                      a range in steps; without `by` the whole range, for --sample
    hoist speed=1..3 m/min by 1 m/min                  of all orders, in proportion
    stage up/all hooks={hoist 1 m/min by 1 m, hoist 3 m/min by 1 m}     one of several texts

Paths are those of `--set`. Steps are counted in decimals, so that 0..1 m by 0.1 m has eleven values. A sample is drawn
by quantiles: ranges are uniform, discrete values equally likely, and an uncertain input of the scene has its stated
distribution.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from functools import cached_property
from itertools import product
from math import sqrt

import numpy as np
from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.inputs import Input, UncertainInput, inputs, settings, uncertain_inputs
from heavylift.nodes.scene.keys.validate import override, validate
from heavylift.nodes.scene.text.extending import alike
from heavylift.nodes.scene.text.faults import raise_faults
from heavylift.nodes.scene.text.overlay import path_in
from heavylift.nodes.scene.text.source import read
from heavylift.nodes.scene.text.spelling import number_and_unit, range_of
from heavylift.nodes.scene.text.tables import tabled
from numpy.typing import NDArray

from .motions import MotionGroup, motion_of

MOST = 1_000_000  # variants of a study


@dataclass(frozen=True)
class Axis:
    """A quantity that a study varies, at `path` of the scene.

    Its values are `texts`, a range from `low` to `high` in `unit`, the distribution of an `uncertain` input, or those
    of a group of moves, `motion`. `first`: a setting that is applied before that of the axis.
    """

    path: str
    texts: tuple[str, ...] = ()
    low: float = 0.0
    high: float = 0.0
    unit: str = ""
    uncertain: UncertainInput | None = None
    first: str = ""
    motion: MotionGroup | None = None

    @cached_property
    def numbers(self) -> list[float] | None:
        """The values of the axis as numbers, if all have a common unit; otherwise None."""
        found = [number_and_unit(text) for text in self.texts]
        return [float(x) for x, _ in found] if all(x for x, _ in found) and len({u for _, u in found}) == 1 else None

    @property
    def label(self) -> str:
        """Path and unit of the axis, for figures and column headers."""
        unit = self.uncertain.unit if self.uncertain else self.unit
        return f"{self.path} [{unit}]" if unit else self.path

    def quantile(self, p: float) -> tuple[str, float]:
        """Return the value at quantile `p` of the axis, as text for a setting and as a number for figures."""
        if self.uncertain is not None:
            one = self.uncertain
            x = (one.value + _standard(one, p) * one.sd) / one.factor
            x = min(max(x, one.bounds[0] / one.factor), one.bounds[1] / one.factor)
            return f"{x!r} {one.unit}".strip(), x
        if self.texts:
            i = min(int(p * len(self.texts)), len(self.texts) - 1)
            return self.texts[i], self.value(i)
        x = self.low + p * (self.high - self.low)
        return f"{x!r} {self.unit}".strip(), x

    def value(self, i: int) -> float:
        """Return the number by which the text with index `i` is plotted: its numerical value, or else the index."""
        return self.numbers[i] if self.numbers else float(i)

    def setting(self, text: str) -> list[str]:
        """Return the `--set` options that set the quantity of this axis to a value."""
        if self.uncertain is not None:
            return settings([self.uncertain], [text])
        if self.motion is not None:
            return self.motion.setting(text)
        return [*([self.first] if self.first else []), f"{self.path}={text}"]


@dataclass(frozen=True)
class Variant:
    """One run of a study: number, settings, and values by axis."""

    number: int
    settings: tuple[str, ...]
    values: tuple[float, ...]


def axes_of(scene: LoadedScene, vary: Sequence[str], sampling: bool) -> list[Axis]:
    """Return the axes that `vary` requests, and for a sample also those of the scene's uncertain inputs; raises
    SceneError."""
    axes = [_axis(scene, text, sampling) for text in vary]
    given = {_place(scene, axis.path) for axis in axes}
    if len(given) < len(axes):
        raise SceneError("--vary: a path is varied twice; give all its values in one --vary")
    if sampling:
        axes += [
            Axis(one.name, unit=one.unit, uncertain=one) for one in uncertain_inputs(scene) if one.path not in given
        ]
    for axis in axes:
        _check(scene, axis)
    if not axes:
        message = "the scene states no uncertain input, such as 'mass: 480 t +- 3 %', and there is no --vary"
        raise SceneError(
            f"--sample: {message}" if sampling else "nothing is varied; say --vary 'block.mass=200..400 t by 25 t'"
        )
    return axes


def grid(axes: Sequence[Axis]) -> list[Variant]:
    """Return all combinations of the values of all axes; the last axis changes fastest."""
    count = 1
    for axis in axes:
        count *= len(axis.texts)
    if count > MOST:
        raise SceneError(f"--vary: {count} variants; a study has at most {MOST}")
    places = product(*(range(len(axis.texts)) for axis in axes))
    return [
        Variant(
            number,
            tuple(x for axis, i in zip(axes, point, strict=True) for x in axis.setting(axis.texts[i])),
            tuple(axis.value(i) for axis, i in zip(axes, point, strict=True)),
        )
        for number, point in enumerate(places)
    ]


def sampled(axes: Sequence[Axis], quantiles: NDArray[np.float64]) -> list[Variant]:
    """Return the variants at the given quantiles (n, axes)."""
    found = []
    for number, point in enumerate(quantiles):
        drawn = [axis.quantile(float(p)) for axis, p in zip(axes, point, strict=True)]
        answer = tuple(x for axis, (text, _) in zip(axes, drawn, strict=True) for x in axis.setting(text))
        found.append(Variant(number, answer, tuple(x for _, x in drawn)))
    return found


def _axis(scene: LoadedScene, text: str, sampling: bool) -> Axis:
    path, equals, values = (part.strip() for part in text.partition("="))
    if not (equals and path and values):
        raise SceneError(f"--vary '{text}': write PATH=VALUES, such as 'block.mass=200..400 t by 25 t'")
    motion = motion_of(scene, path)
    first = "" if motion else _first(scene, path)
    if values.startswith("{") and values.endswith("}"):
        texts = tuple(dict.fromkeys(part for each in _parts(values[1:-1]) if (part := each.strip())))
        if not texts:
            raise SceneError(f"--vary '{text}': the braces are empty; write values, such as {{1, 2}}")
        return Axis(path, texts, unit=_unit(texts), first=first, motion=motion)
    found = range_of(values)
    if found is None:
        return Axis(path, (values,), unit=_unit([values]), first=first, motion=motion)
    unit = found.unit
    for other in (found.unit_low, found.unit_step):
        if other and other != unit:
            raise SceneError(f"--vary '{text}': use a single unit, {unit or 'none'} or {other}")
    try:
        low, high = Decimal(found.low), Decimal(found.high)
        step = Decimal(found.step) if found.step else None
    except InvalidOperation:
        raise SceneError(f"--vary '{text}': the ends of the range must be numbers") from None
    if low >= high or (step is not None and step <= 0):
        raise SceneError(f"--vary '{text}': the range is empty; give a higher end and a positive step")
    if step is None and not sampling:
        _check(scene, Axis(path, (), float(low), float(high), unit, first=first, motion=motion))
        raise SceneError(f"--vary '{text}': give the step size, 'by ...', or the number of draws, --sample 1000")
    if step is None:
        return Axis(path, (), float(low), float(high), unit, first=first, motion=motion)
    count = int((high - low) / step) + 1
    if count > MOST:
        raise SceneError(f"--vary '{text}': {count} values; a study has at most {MOST} variants")
    return Axis(
        path,
        tuple(f"{(low + i * step).normalize():f} {unit}".strip() for i in range(count)),
        unit=unit,
        first=first,
        motion=motion,
    )


def _unit(texts: Sequence[str]) -> str:
    """Return the common unit of all numbers; "" if there is none."""
    units = {number_and_unit(text)[1] for text in texts}
    return units.pop() if len(units) == 1 else ""


def _check(scene: LoadedScene, axis: Axis) -> None:
    """Check that the first and last value of an axis can be set in the scene; raises SceneError if neither can."""
    for p in (0.0, 1.0):
        source = read(scene.merged or scene.text, scene.path.name, scene.path.parent)
        for setting in axis.setting(axis.quantile(p)[0]):
            override(source, setting)
        alike(source)
        tabled(source)
        validate(source)
        if not source.faults:
            return
    raise_faults(source, source.faults)


def _parts(text: str) -> list[str]:
    """Split a text at commas outside of brackets."""
    return re.split(r",(?![^\[]*\])", text)


def _first(scene: LoadedScene, path: str) -> str:
    """Return the setting that must precede one number of a vector that the scene leaves at its default; else ""."""
    try:
        found: Input = inputs(scene, [path])[0]
    except SceneError:
        return ""
    return found.whole


def _place(scene: LoadedScene, path: str) -> tuple[str | int, ...]:
    return path_in(read(scene.merged or scene.text, scene.path.name), path)


def _standard(one: UncertainInput, p: float) -> float:
    """Return the quantile of an input's distribution, scaled to mean 0 and standard deviation 1."""
    from scipy.special import ndtri

    return sqrt(12.0) * (p - 0.5) if one.kind == "uniform" else float(ndtri(min(max(p, 1e-12), 1.0 - 1e-12)))
