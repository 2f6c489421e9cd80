"""The complete table of limits of a scene, including limits that the scene itself sets on signals."""

import re
from collections.abc import Iterator
from dataclasses import fields

from heavylift.kernel.description.signals import ScalarSignal
from heavylift.nodes.plan.limit import RatedLimit
from heavylift.nodes.scene.construction.limiting import rated_limits, scene_limits
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.language.phrases import CrossTest
from heavylift.nodes.scene.text.source import Path

from .conditions import Conditions, unit_of

SIGNAL = tuple(x.name for x in fields(ScalarSignal))


def build_limits(builder: SceneBuilder) -> tuple[RatedLimit, ...]:
    """Return all limits of the scene, those of load-carrying parts first."""
    return (*rated_limits(builder), *_signals(builder), *_interlocks(builder), *scene_limits(builder))


def _signals(builder: SceneBuilder) -> Iterator[RatedLimit]:
    """Yield the limits that the scene sets on signals, written as conditions that must hold."""
    conditions = Conditions(builder)
    for i, phrase in enumerate(builder.scene.limits.signals):
        path: Path = ("limits", "signals", i)
        for test in phrase:
            unit = unit_of(test)
            if not isinstance(test, CrossTest) or unit is None:
                message = "a limit is one of places, ropes, hooks or the wind, such as 'gap west east >= 3 m'"
                builder.source.fault(path, message)
            elif found := conditions.signal(path, test):
                subject = re.split(r"\s*[<>]=", test.text)[0]
                yield RatedLimit(
                    subject=subject, quantity="signal", unit=unit, value=test.value, least=test.rising,
                    signal=found[1], source="the scene", where=builder.source.where(path),
                )  # fmt: skip


def _interlocks(builder: SceneBuilder) -> Iterator[RatedLimit]:
    """Yield a limit for each threshold of the interlocks that stop something."""
    for x in (x for x in builder.interlocks if x.stops and x.unit is not None):
        by = "its type" if x.name.rpartition(".")[0] in builder.scene.machines else "the scene"
        for guard in x.guards:
            own = {name: getattr(guard, name) for name in SIGNAL}
            yield RatedLimit(
                subject=x.name, quantity="interlock", unit=x.unit or "", value=x.value, least=not x.rising,
                signal=ScalarSignal(**own), elements=(x.name,), source=by, where=x.where,
            )  # fmt: skip
