"""A verb with its own behaviour is one module and one row: `nudge 5 deg` moves a drive and reports when it is done."""

from __future__ import annotations

import sys
from math import degrees
from pathlib import Path
from types import ModuleType

import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.plan import VERBS, Verb
from heavylift.nodes.scene import parse
from heavylift.recordings import Recording

SCENE = """\
heavylift: 1
name: jib
mechanism:
  name: jib
  bodies: {boom: {mass: 2 t, com: [3 m, 0, 0], inertia: [0, 6000 kg m2, 6000 kg m2]}}
  joints: {pivot: {type: revolute, child: boom, axis: [0, 0, 1]}}
  drives: {turntable: {joint: pivot, type: prescribed, ramp: 2 deg/s2}}
actions:
  - turntable: nudge 5 deg
  - when: moves done
    wait: 1 s
"""
MODULE = """
from math import radians

from heavylift.nodes.plan.actions import Move
from heavylift.nodes.scene.language.phrases import OrderPhrase
from heavylift.nodes.scene.text.units import ANGLE


def phrase(reader):
    return OrderPhrase("nudge", turning=True, by=reader.quantity(ANGLE))


def orders(actors, phrase, where):
    for actor in actors:
        way = {"speed": radians(1.0), "accel": actor.accel, "by": phrase.by}
        yield Move(verb="drive", model=actor.model, actuator=actor.name, where=where, **way)
"""


@pytest.fixture
def nudge(monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType("nudging")
    exec(MODULE, vars(module))
    monkeypatch.setitem(sys.modules, "nudging", module)
    monkeypatch.setitem(VERBS, "nudge", Verb("nudge", ("drive",), "own", units="turning", module="nudging"))


@pytest.mark.usefixtures("nudge")
def test_a_verb_of_orders_defined_in_one_module_is_parsed_and_executed(tmp_path: Path) -> None:
    run(parse(SCENE), tmp_path / "jib.mcap", in_process=True)
    angle = Recording(tmp_path / "jib.mcap")["joint/position/pivot.angle"]
    assert degrees(angle.values[-1, 0]) == pytest.approx(5.0)


@pytest.mark.usefixtures("nudge")
def test_a_faulty_order_whose_verb_is_defined_in_one_module_gives_the_same_errors_as_other_verbs() -> None:
    with pytest.raises(SceneError, match="'5 m' is not a valid angle"):
        parse(SCENE.replace("5 deg", "5 m"))
    with pytest.raises(SceneError, match="'pivot' to give an order to"):
        parse(SCENE.replace("turntable: nudge", "pivot: nudge"))
