"""`heavylift plan`: speeds, ramps and overlaps of a lift as quick as its verdict stays green, in its own text."""

from __future__ import annotations

import difflib
from pathlib import Path

import pytest
from heavylift.coordinator.record import play
from heavylift.coordinator.sweeps import CREEP, overlaps, ramps, speeds
from heavylift.coordinator.sweeps.planning import planned
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load, parse
from heavylift.nodes.scene.text import library
from lifting import bare

SLOW = ["actions[2].all hooks=hoist 0.6 m/min by 1 m", "end=140 s"]
NEAR = ["cranes.crane.hook capacity=171.9 t", *SLOW]  # H3 carries 171.6 t at rest


@pytest.fixture(scope="module")
def told() -> list[str]:
    return []


@pytest.fixture(scope="module")
def found(told: list[str]):
    """The lift with a hook that is nearly used up."""
    return planned(bare("lift", NEAR), 300.0, told.append)


def test_the_planned_timing_of_a_lift_is_shorter_and_its_verdict_is_not_red(found) -> None:
    assert not found.wrong
    assert not found.run_after.verdict.red
    assert found.gain == pytest.approx(87.0, abs=0.5)  # of 137 s


def test_the_timing_planner_halves_a_change_that_makes_the_verdict_red(found, told: list[str]) -> None:
    runs = [line for line in told if line.startswith("run ")]
    assert len(runs) == 5
    assert all("worst: hook load of crane.H3 was 172." in run for run in runs[1:3])
    assert " 0 red, 0 undecided" in runs[3]
    rows = {name: (before, after, why) for name, before, after, why in found.rows}
    for stage in ("take up slack", "lift off"):  # with creep speed already
        assert rows[stage][0] == rows[stage][1]
        assert rows[stage][2] == ""
    assert rows["up"][:2] == pytest.approx((100.2, 13.0), abs=0.01)
    assert rows["up"][2] == "hook load of crane.H3 was 172.0 t, 100.08 %; 171.9 t is allowed (the scene)"
    assert rows["sideways"][:2] == pytest.approx((12.65, 12.65), abs=0.01)


def test_the_planned_scene_keeps_its_comments_and_settings(found) -> None:
    lines = difflib.ndiff(bare("lift").text.splitlines(), found.after.text.splitlines())
    new = [line[2:].strip() for line in lines if line.startswith("+ ")]
    assert new == [
        "end: 140 s",
        "crane: {hook capacity: 171.9 t, type: goliath-900, at: 40 m}     # its trolleys begin above the lugs",
        "all hooks: hoist 2.4 m/min by 1 m",
        "when: after 13.0 s",
    ]


def test_a_run_of_the_planned_scene_takes_the_predicted_time(found) -> None:
    run = play(parse(found.after.text, "lift.yaml").plan)
    assert run.digest == found.run_after.digest


def test_scenes_whose_timing_cannot_be_planned_are_reported(tmp_path: Path) -> None:
    assert "red at the start, RED: " in planned(load("lift", ["end=50 s"]), 60.0).wrong
    assert planned(load("lift"), 1e-9).wrong.startswith("the scene as it is written cannot be run: cut after")
    slow = load("lift", ["actions[0].all hooks=hoist 3 m/min until all slings taut", "actions=[]", "end=60 s"])
    assert planned(slow, 60.0).wrong.startswith("no quicker timing was found that is green: it is as quick as")
    (tmp_path / "mine.yaml").write_text("extends: lift\nname: mine\n")
    with pytest.raises(SceneError, match="has no action list of its own; plan the scene that it extends"):
        planned(load(tmp_path / "mine.yaml"), 60.0)


def test_the_timing_planner_proposes_higher_speeds_swing_free_ramps_and_overlapping_moves() -> None:
    """Hooks of one action keep their ratio."""
    scene = load("turnover")
    found = [(scene.plan.actions[s.action].stage, len(s.paths), s.most, s.why) for s in speeds(scene)]
    assert ("slacken B", 1, pytest.approx(100 / 3), "west.H3 can 10 m/min") in found
    assert ("hoist", 2, pytest.approx(10 / 3), "west.H1 can 10 m/min") in found
    assert {scene.plan.actions[s.action].stage for s in ramps(scene)} == {"travel", "re-rig, pass beneath"}
    lasts = [60.0] * len(scene.plan.actions)
    pairs = [scene.plan.actions[s.action].stage for s in overlaps(scene, lasts)]
    assert pairs == ["travel", "re-rig, pass beneath", "re-rig, hooks down"]


@pytest.mark.parametrize("crane", sorted(x for x in library() if x.startswith("goliath")))
def test_the_timing_planner_keeps_creep_speed_at_lift_off_and_set_down(crane: str) -> None:
    """Whether an order waits for that or goes a way; what is written faster stays so."""
    up = ["hoist 0.05 m/min until all slings taut", "hoist 0.05 m/min by 0.2 m", "hoist 0.05 m/min by 0.3 m"]
    orders = [*up, "lower 0.05 m/min by 0.6 m", "lower 0.05 m/min by 0.2 m"]
    listed = f"actions=[{', '.join(f'{{all hooks: {x}}}' for x in orders)}]"
    scene = load("lift", [f"cranes.crane={{type: {crane}, at: 40 m, hook spacing: 6 m}}", "end=1 h", listed])
    loaded = scene.scene.machines["crane"].hooks["crane.H1"].loaded_speed * 60.0
    most: dict[int, float] = {}
    for step in speeds(scene):
        most.setdefault(step.action, step.most * 0.05)
    assert [most[i] for i in (0, 1, 3)] == pytest.approx([CREEP * loaded] * 3)
    assert most[2] > loaded * (1.0 - 1e-9)
    fast = load("lift", ["actions[1].all hooks=hoist 1 m/min until lifted"])
    assert not [step for step in speeds(fast) if step.action == 1]


@pytest.mark.large
def test_the_planned_timing_of_the_scene_turnover_is_a_tenth_shorter() -> None:
    scene = load("turnover")
    found = planned(scene, 3600.0)
    assert not found.wrong
    assert not found.run_after.verdict.red
    assert found.gain > 0.1 * found.run_before.end_ns * 1e-9
    kept = [line for line in scene.text.splitlines() if "#" in line]
    assert [line for line in found.after.text.splitlines() if "#" in line] == kept
