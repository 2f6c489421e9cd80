"""How far a number of a scene may go before the verdict turns red.

Upwards from where it is green: twice as far at each step until something is red or refused, then by halves until the
last green and the first red value are near.  Between them lies the limit; what lies beyond is looked at in a few
places, for a scene that is green again there has no single limit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import isfinite

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.inputs import inputs

from .axes import RANGE, Axis, Variant, axes_of
from .variant import Row, Task, played

__all__ = ["Limited", "limits_of"]

NEAR = 0.005  # of the way from the start: how near the last green and the first red value shall be
STEPS, BEYOND = 8, 3  # doublings without an end of the range; values that are looked at beyond the limit


@dataclass(frozen=True)
class Limited:
    """What was found of a number: its path and unit, all values that were run with their rows, the last green and the
    first red value, what is wrong with the question ("" if nothing)."""

    path: str
    unit: str
    runs: dict[float, Row] = field(default_factory=dict)
    green: float | None = None
    red: float | None = None
    wrong: str = ""

    @property
    def why(self) -> str:
        """What is beyond its limit at the first red value."""
        if self.red is None:
            return ""
        row = self.runs[self.red]
        text = str(row.get("verdict") or row["sentence"])
        return next((line for line in text.splitlines() if line), row["status"])

    def __str__(self) -> str:
        if self.wrong:
            return f"{self.path}: {self.wrong}"
        most = self.runs[self.green or 0.0] if self.green in self.runs else {}
        used = most.get("use", float("nan"))
        told = f", where {most['limit']} is used to {used:.1%} in '{most['limit stage']}'" if isfinite(used) else ""
        return f"{self.path}: green up to {self._text(self.green)}{told}; red at {self._text(self.red)}: {self.why}"

    def _text(self, value: float | None) -> str:
        return f"{value:.5g} {self.unit}".strip()


def limits_of(
    scene: LoadedScene, asked: str, limit_s: float = 60.0, watch: Callable[[float, Row], None] = lambda x, row: None
) -> Limited:
    """The largest green value of `PATH`, or of `PATH=LOW..HIGH UNIT`; raises SceneError for what is no number."""
    axis, start, end = _range(scene, asked)
    task, runs = Task.of(scene, limit_s, "none", True), dict[float, Row]()

    def green(x: float) -> bool:
        if x not in runs:
            settings = tuple(axis.setting(f"{x!r} {axis.unit}".strip()))
            runs[x] = played(task, Variant(len(runs), settings, (x,)))
            watch(x, runs[x])
        if runs[x]["status"] in ("cut", "lost"):
            raise SceneError(f"--of '{asked}': at {x:g} {axis.unit}: {runs[x]['sentence']}")
        return bool(runs[x]["status"] == "done")

    found = Limited(axis.path, axis.unit, runs)
    if not green(start):
        return _with(found, red=start, wrong=f"red at the start, {start:g} {axis.unit}: {_with(found, red=start).why}")
    low, step = start, (end - start) / 2**STEPS
    high = low
    while high < end and green(high):
        low, high, step = high, min(end, high + step), 2.0 * step
    if green(high):
        return _with(
            found, green=high, wrong=f"nothing turns red up to {high:g} {axis.unit}; give a range that leads on"
        )
    bracket = NEAR * (high - start)
    while high - low > bracket:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if green(middle) else (low, middle)
    beyond = [high + (end - high) * (i + 1) / BEYOND for i in range(BEYOND)] if end > high else []
    again = next((x for x in beyond if green(x)), None)
    told = "" if again is None else f"red at {high:.5g} {axis.unit}, but green again at {again:.5g}: no single limit"
    return _with(found, green=low, red=high, wrong=told)


def _with(found: Limited, green: float | None = None, red: float | None = None, wrong: str = "") -> Limited:
    return Limited(found.path, found.unit, found.runs, green, red, wrong)


def _range(scene: LoadedScene, asked: str) -> tuple[Axis, float, float]:
    """The axis, where the search begins and where it ends at the latest, in its unit."""
    path, equals, values = (part.strip() for part in asked.partition("="))
    if equals:
        if RANGE.fullmatch(values) is None:
            raise SceneError(f"--of '{asked}': write PATH, or PATH=LOW..HIGH UNIT such as 'block.mass=300..900 t'")
        (axis,) = axes_of(scene, [asked], sampling=True)[:1]
        return axis, axis.low, axis.high
    try:
        one = inputs(scene, [path])[0]
    except SceneError as error:
        told = f"{error}; of a word of an order say between which values, 'stage up/all hooks/hoist=1..20 m/min'"
        raise SceneError(f"--of '{asked}': {told}") from None
    start, far = one.value / one.factor, one.scale / one.factor
    end = min(start + 10.0 * far, one.bounds[1] / one.factor)
    return Axis(path, unit=one.unit, first=one.whole), start, end
