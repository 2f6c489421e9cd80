"""`heavylift plan`: speeds, ramps and overlaps of a lift as quick as its verdict stays green, in its own text."""

from __future__ import annotations

import difflib
from pathlib import Path

import pytest
from heavylift.coordinator.ladder import play
from heavylift.coordinator.sweeps import overlaps, ramps, speeds
from heavylift.coordinator.sweeps.planning import planned
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load, parse

NEAR = "cranes.crane.hook capacity=178 t"  # H3 carries 172 t at rest


@pytest.fixture(scope="module")
def told() -> list[str]:
    return []


@pytest.fixture(scope="module")
def found(told: list[str]):
    """The lift with a hook that is nearly used up."""
    return planned(load("lift", [NEAR]), 300.0, told.append)


def test_it_is_quicker_and_green(found) -> None:
    assert not found.wrong
    assert not found.run_after.verdict.red
    assert found.gain == pytest.approx(29.3, abs=0.5)  # of 57 s


def test_where_a_run_was_red_it_went_back_half_way(found, told: list[str]) -> None:
    runs = [line for line in told if line.startswith("run ")]
    assert len(runs) == 4
    assert "red: the hook crane.H3 carried 180.1 t of 178 t" in runs[1]
    assert all("green" in run for i, run in enumerate(runs) if i != 1)
    rows = {name: (before, after, why) for name, before, after, why in found.rows}
    assert rows["take up slack"][2] == "crane.H1 can 3 m/min with a load"
    assert rows["lift off"][2] == "the hook crane.H3 carried 180.1 t of 178 t"
    assert rows["up"][:2] == pytest.approx((21.0, 10.4), abs=0.01)
    assert rows["sideways"][:2] == pytest.approx((12.65, 12.65), abs=0.01)
    assert rows["sideways"][2] == "'up' is to begin and to end before it"


def test_the_scene_is_written_with_its_comments_and_its_setting(found) -> None:
    lines = difflib.ndiff(load("lift").text.splitlines(), found.after.text.splitlines())
    new = [line[2:].strip() for line in lines if line.startswith("+ ")]
    assert new == [
        "crane: {hook capacity: 178 t, type: goliath-900, at: 40 m}     # its trolleys begin above the lugs",
        "all hooks: hoist 3 m/min until all slings taut",
        "all hooks: hoist 1.65 m/min until lifted",
        "when: after 10.4 s",
    ]


def test_what_is_written_runs_so(found) -> None:
    run = play(parse(found.after.text, "lift.yaml").plan)
    assert run.digest == found.run_after.digest


def test_what_cannot_be_planned_is_said(tmp_path: Path) -> None:
    assert "red at the start, red: " in planned(load("lift", ["end=50 s"]), 60.0).wrong
    assert planned(load("lift"), 1e-9).wrong.startswith("the scene as it is written makes no run: cut after")
    slow = load("lift", ["actions[0].all hooks=hoist 3 m/min until all slings taut", "actions=[]"])
    assert planned(slow, 60.0).wrong.startswith("no quicker timing was found that is green: it is as quick as")
    (tmp_path / "mine.yaml").write_text("extends: lift\nname: mine\n")
    with pytest.raises(SceneError, match="has no action list of its own; plan the scene that it extends"):
        planned(load(tmp_path / "mine.yaml"), 60.0)


def test_steps_are_those_of_the_list() -> None:
    """A hook that meets its load has no more speed than with one; hooks of one action keep their ratio."""
    scene = load("turnover")
    found = [(scene.plan.actions[s.action].stage, len(s.paths), s.most, s.why) for s in speeds(scene)]
    assert ("take up slack", 1, 10.0, "east.H1 can 3 m/min with a load") in found
    assert ("slacken B", 1, pytest.approx(100 / 3), "west.H3 can 10 m/min") in found
    assert ("hoist", 2, pytest.approx(10 / 3), "west.H1 can 10 m/min") in found
    assert {scene.plan.actions[s.action].stage for s in ramps(scene)} == {"travel", "re-rig, pass beneath"}
    lasts = [60.0] * len(scene.plan.actions)
    pairs = [scene.plan.actions[s.action].stage for s in overlaps(scene, lasts)]
    assert pairs == ["travel", "re-rig, pass beneath", "re-rig, hooks down"]


@pytest.mark.large
def test_the_turnover_is_a_tenth_shorter() -> None:
    scene = load("turnover")
    found = planned(scene, 3600.0)
    assert not found.wrong
    assert not found.run_after.verdict.red
    assert found.gain > 0.1 * found.run_before.end_ns * 1e-9
    kept = [line for line in scene.text.splitlines() if "#" in line]
    assert [line for line in found.after.text.splitlines() if "#" in line] == kept
