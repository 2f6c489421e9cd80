"""A verb that moves a drive is one row of the table used by grammar, targets, hints, conditions and run."""

from __future__ import annotations

import re
from math import degrees
from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.plan import MOTIONS, VERBS, Verb, actions
from heavylift.nodes.scene import parse
from heavylift.nodes.scene.language import phrases
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
  - turntable: swivel 3 deg/s by 30 deg
  - when: swivel done
    turntable: swivel 3 deg/s to 10 deg
"""
THERE_s, BACK_s = 30 / 3 + 3 / 2, 20 / 3 + 3 / 2  # trapezoids: way / speed + speed / ramp


@pytest.fixture
def swivel(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(VERBS, "swivel", Verb("swivel", ("drive",), "move", units="turning"))
    monkeypatch.setattr(actions, "MOTIONS", (*MOTIONS, "swivel"))


def test_every_verb_of_orders_is_in_the_documented_grammar() -> None:
    assert [name for name in VERBS if not re.search(rf'"{name}"', phrases.__doc__ or "")] == []


def test_a_recorded_plan_that_contains_an_unknown_verb_is_refused() -> None:
    order = {"type": "move", "verb": "fly", "model": "m", "actuator": "a", "speed": 1.0, "accel": 1.0}
    with pytest.raises(msgspec.ValidationError, match="'fly' is not a motion of a drive or winch"):
        msgspec.convert(order, actions.Move)


@pytest.mark.usefixtures("swivel")
def test_a_newly_added_verb_of_orders_is_parsed_and_executed_and_can_be_waited_for(tmp_path: Path) -> None:
    scene = parse(SCENE)
    moves = [action.orders[0] for action in scene.plan.actions]
    assert [move.verb for move in moves if isinstance(move, actions.Move)] == ["swivel", "swivel"]
    run(scene, tmp_path / "jib.mcap", in_process=True)
    angle = Recording(tmp_path / "jib.mcap")["joint/position/pivot.angle"]
    assert angle.t[-1] == pytest.approx(THERE_s + BACK_s, abs=1e-8)
    assert degrees(angle.values[-1, 0]) == pytest.approx(10.0)


@pytest.mark.usefixtures("swivel")
@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("swivel 3 m/min by 30 deg", "'3 m/min' is not a valid angular rate"),
        ("swvel 3 deg/s by 30 deg", "did you mean 'swivel'"),
        ("hoist 3 m/min by 1 m", "it can: slew, luff, drive, stop, hold, swivel"),
    ],
)
def test_mistakes_in_an_order_with_a_newly_added_verb_are_reported_with_that_verb(written: str, told: str) -> None:
    with pytest.raises(SceneError, match=re.escape(told)):
        parse(SCENE.replace("swivel 3 deg/s by 30 deg", written))


SLIDES = (SCENE.replace("revolute", "prismatic").replace("2 deg/s2", "0.1 m/s2"), "metres, not degrees or radians")
TURNS = (SCENE, "degrees or radians, not metres")


@pytest.mark.parametrize(
    ("scene", "units", "written"),
    [
        (*TURNS, "turntable: drive 3 m/min by 2 m"),
        (*TURNS, "turntable: drive 2 deg/s until position of pivot >= 2 m"),
        (*TURNS, "turntable: drive 2 deg/s until speed of pivot >= 2 m/min"),
        (*SLIDES, "turntable: drive 2 deg/s to 10 deg"),
        (*SLIDES, "turntable: drive 3 m/min until position of pivot <= -10 deg"),
    ],
)
def test_the_value_of_an_order_has_the_unit_of_the_joint_that_it_moves(scene: str, units: str, written: str) -> None:
    orders = scene.partition("  - turntable")[0]
    with pytest.raises(SceneError, match=f"'(turntable|pivot)' (turns|slides): write {units}"):
        parse(f"{orders}  - {written}\n")


def test_the_position_zero_in_a_condition_needs_no_unit() -> None:
    assert parse(f"{SCENE.partition('  - turntable')[0]}  - turntable: drive 2 deg/s until position of pivot >= 0\n")
