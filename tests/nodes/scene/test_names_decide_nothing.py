"""The scene `turnover` gives the same lift with all machines, bodies, joints, drives, ropes and lugs renamed."""

import re
from dataclasses import replace
from typing import Any

import pytest
from heavylift import simulate
from heavylift.coordinator.record import boxes, surroundings
from heavylift.kernel.description import WORLD
from heavylift.nodes.plan import Plan
from heavylift.nodes.scene import LoadedScene, instances, load


class Renamed:
    """A plan whose names are numbers in the order of the old ones, in which a system is summed."""

    def __init__(self, plan: Plan, patch: pytest.MonkeyPatch) -> None:
        self.names: dict[str, str] = {}
        patch.setattr(instances, "_renamed", self._of)
        instances.moved(plan, "", (0.0, 0.0, 0.0))
        self.names = {name: f"n{i:04d}" for i, name in enumerate(sorted(self.names))}
        self.plan: Plan = instances.moved(plan, "", (0.0, 0.0, 0.0))
        patch.undo()

    def _of(self, value: Any, prefix: str) -> Any:
        if isinstance(value, dict):
            return {self._of(key, prefix): self._of(x, prefix) for key, x in value.items()}
        if isinstance(value, tuple):
            return tuple(self._of(x, prefix) for x in value)
        if not isinstance(value, str) or value in ("", WORLD, "all", "turn"):
            return value
        return self.names.setdefault(value, value)

    def message(self, text: str) -> str:
        """A text with the new names in place of the old ones."""
        known = sorted(self.names, key=len, reverse=True)
        found = re.compile(r"(?<![\w.~-])(" + "|".join(map(re.escape, known)) + r")(?![\w~-])")
        return found.sub(lambda m: self.names[m[0]], text)


def whole(scene: LoadedScene, plan: Plan) -> LoadedScene:
    return replace(scene, plan=plan)


@pytest.mark.parametrize("name", ["lift", "turnover"])
@pytest.mark.large(beyond=1)
def test_renaming_machines_and_blocks_does_not_change_the_results_of_a_run(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = load(name)
    new = Renamed(scene.plan, monkeypatch)
    other = whole(scene, new.plan)
    assert surroundings(new.plan) == surroundings(scene.plan)
    assert [(new.names.get(x.body, x.body), x.centre, x.size, x.colour) for x in boxes(scene.plan)] == [
        (x.body, x.centre, x.size, x.colour) for x in boxes(new.plan)
    ]
    message = [(new.message(x.limit.subject), x.limit.quantity) for x in scene.uses]
    assert [(x.limit.subject, x.limit.quantity) for x in other.uses] == message
    assert [x.value for x in other.uses if x.value is not None] == pytest.approx(
        [x.value for x in scene.uses if x.value is not None], rel=1e-9, abs=1e-9
    )
    a, b = simulate(scene), simulate(other)
    for signal in a.signals:
        one, two = a[signal], b[new.message(signal)]
        assert [new.message(column) for column in one.names] == list(two.names), signal
        assert one.values.tobytes() == two.values.tobytes(), signal
    assert [new.message(x.sentence) for x in a.verdict.findings] == [x.sentence for x in b.verdict.findings]
