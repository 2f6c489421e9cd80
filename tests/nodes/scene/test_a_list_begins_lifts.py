"""The action list of a scene of several lifts begins those with `start: ordered` on conditions of others."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.record import play
from heavylift.coordinator.run import run
from heavylift.coordinator.transport import Placement
from heavylift.kernel import ModelError, SceneError
from heavylift.nodes.models import KERNEL, build
from heavylift.nodes.models.parts import Begun, Ended, Stage
from heavylift.nodes.scene import load, parse
from heavylift.recordings import Recording

SLEDGE = """\
heavylift: 1
name: sledge
samples: 2 Hz
mechanism:
  name: sledge
  bodies: {cart: {mass: 4 t}}
  joints: {rail: {type: prismatic, child: cart, axis: [1, 0, 0]}}
  drives:
    pusher: {joint: rail, type: servo, stiffness: 10 MN/m, damping: 0.4 MN s/m, ramp: 0.5 m/s2, range: [-9 m, 9 m]}
actions:
  - stage: out
    pusher: drive 1 m/s by 4 m
"""
LIFTS = """\
heavylift: 1
name: three
samples: 2 Hz
lifts:
  a: {extends: sledge.yaml}
  b: {extends: sledge.yaml, at: [0 m, 5 m], start: ordered}
  c: {extends: sledge.yaml, at: [0 m, 9 m], start: ordered}
actions:
"""
LIST = """\
  - stage: second
    when: position of a-rail >= 1.25 m
    b: begin
  - stage: third
    when: b done and after 1 s
    c: begin
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """With the scene of one lift."""
    (tmp_path / "sledge.yaml").write_text(SLEDGE)
    return tmp_path


def of(folder: Path, listed: str = LIST, old: str = "", new: str = "") -> Path:
    """The scene of three lifts with this list."""
    assert old in LIFTS + listed
    (folder / "three.yaml").write_text((LIFTS + listed).replace(old, new) if old else LIFTS + listed)
    return folder / "three.yaml"


def test_a_lift_begins_when_another_lift_reaches_a_position_or_is_done(folder: Path) -> None:
    """A way of 4 m with ramps of 2 s takes 6 s; its reference is 1.25 m after 2.25 s, which the cart follows within
    what its drive gives way; a list that has begun goes on at once."""
    events = play(load(of(folder)).plan).events
    stages = {e.value.name: e.t * 1e-9 for e in events if e.type == Stage.__name__}
    assert [*stages] == ["a: out", "second", "b: out", "third", "c: out"]
    assert stages["a: out"] == 0.0
    assert stages["second"] == stages["b: out"] == pytest.approx(2.25, abs=0.01)
    assert stages["third"] == stages["c: out"] == stages["b: out"] + 6.0
    assert events[-1].t * 1e-9 >= stages["c: out"] + 6.0


def test_a_lift_started_by_another_action_list_moves_as_if_alone_but_later(folder: Path, tmp_path: Path) -> None:
    played = play(load(of(folder)).plan)
    names = {e.type for e in played.events}
    assert not names & {Begun.__name__, Ended.__name__}, "lists talk to each other inside their node"
    scene = load(of(folder))
    found = run(scene, tmp_path / "apart.mcap", placement=Placement.spread([*build(scene.plan), KERNEL], 4))
    assert found.digest == played.digest
    a, b = (Recording(tmp_path / "apart.mcap")[f"joint/position/{x}-rail.travel"] for x in "ab")
    assert b.values[-1, 0] == pytest.approx(a.values[-1, 0], abs=1e-9) == pytest.approx(4.0, abs=1e-6)


def test_a_stated_end_time_does_not_delay_the_report_that_a_lift_is_done(folder: Path) -> None:
    played = play(load(of(folder), ["end=20 s"]).plan)
    stages = {e.value.name: e.t * 1e-9 for e in played.events if e.type == Stage.__name__}
    assert stages["third"] == stages["b: out"] + 6.0
    assert not played.unfinished


def test_a_run_that_cannot_continue_reports_what_its_action_lists_wait_for(folder: Path) -> None:
    scene = load(of(folder, old=">= 1.25 m", new=">= 5 m"))
    with pytest.raises(ModelError) as message:
        play(scene.plan)
    assert "still waiting for position of a-rail >= 5 m since 0 s, three.yaml:10:5" in str(message.value)
    assert "still waiting for the list of the whole scene to begin b since 0 s" in str(message.value)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("b: begin", "d: begin", "there is no 'd' to give an order to"),
        ("b: begin", "a: begin", "a begins by itself: write `start: ordered` there"),
        ("b: begin", "b-pusher: drive 1 m/s by 1 m", "this list begins lifts (`b: begin`)"),
        ("b: begin", "b-pusher: begin", "'b-pusher' cannot begin"),
        ("b: begin", "b: begin now", "nothing can follow 'begin': remove 'now'"),
        ("b: begin", "wait: 1 s", "nothing begins b: write an action `b: begin` in this scene"),
        ("c: begin", "b: begin", "b is begun twice"),
        ("b done", "d done", "there is no lift 'd' that could be done"),
        ("position of a-rail", "position of d-rail", "'d-rail'"),
        ("start: ordered", "start: order", "lifts.b.start"),
        ("  a: {", "  all: {", "a lift cannot be called 'all'"),
    ],
)
def test_impossible_conditions_to_begin_a_lift_are_reported_with_their_line_in_the_scene(
    folder: Path, old: str, new: str, sentence: str
) -> None:
    with pytest.raises(SceneError) as message:
        load(of(folder, old=old, new=new))
    assert sentence in str(message.value)
    assert "three.yaml:" in str(message.value).splitlines()[0]


def test_the_order_to_begin_a_lift_is_refused_in_a_scene_with_one_lift() -> None:
    with pytest.raises(SceneError, match="cannot begin"):
        parse(SLEDGE.replace("drive 1 m/s by 4 m", "begin"))
