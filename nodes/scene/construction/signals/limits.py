"""The whole table of limits of a scene, with the signals that it limits itself."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from heavylift.nodes.plan import plan
from heavylift.nodes.plan.limit import Limit
from heavylift.nodes.scene.construction.limiting import rated_limits, scene_limits
from heavylift.nodes.scene.construction.yard import Yard
from heavylift.nodes.scene.language.phrases import CrossTest, Test
from heavylift.nodes.scene.language.quantities import QUANTITIES
from heavylift.nodes.scene.text.source import Path

from .conditions import Conditions

UNITS = {"length": "m", "angle": "rad", "force": "N", "mass": "kg", "ratio": "", "speed": "m/s"}  # by dimension
UNJUDGED = ("angle", "length")  # signals that are not known of a path or a recording


def build_limits(yard: Yard, mechanisms: Sequence[plan.Mechanism]) -> tuple[Limit, ...]:
    """All rows, those of what holds a load first."""
    rows = rated_limits(yard, mechanisms)
    return (*rows, *_signals(yard, mechanisms), *scene_limits(yard, mechanisms))


def _signals(yard: Yard, mechanisms: Sequence[plan.Mechanism]) -> Iterator[Limit]:
    """Signals that the scene itself limits, as conditions that hold as long as all is well."""
    conditions = Conditions(yard, mechanisms)
    for i, phrase in enumerate(yard.scene.limits.signals):
        path: Path = ("limits", "signals", i)
        for test in phrase:
            unit = _unit(test)
            if not isinstance(test, CrossTest) or unit is None:
                told = "a limit is one of places, ropes, hooks or the wind, such as 'gap west east >= 3 m'"
                yard.source.fault(path, told)
            elif found := conditions.signal(path, test):
                subject = re.split(r"\s*[<>]=", test.text)[0]
                yield Limit(
                    subject=subject, quantity="signal", unit=unit, value=test.value, least=test.rising,
                    signal=found[1], source="the scene", where=yard.source.where(path),
                )  # fmt: skip


def _unit(test: Test) -> str | None:
    """The unit of what a test compares, of SI; None if it cannot be judged."""
    if not isinstance(test, CrossTest) or test.quantity in UNJUDGED:
        return None
    return "" if test.share else UNITS.get(QUANTITIES[test.quantity].dimension.name)
