"""Where `check` and a run could part: slings without slack, moves of no length, lists that never end."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import bundled, load, parse
from lifting import unstated

LIFT = unstated(bundled()["lift"].read_text())
SIDEWAYS = "    trolleys: traverse 20 m/min by 2 m\n"


@pytest.mark.parametrize("slack", ["0 m", "1 mm"])
def test_slings_without_slack_are_taut_at_the_start(slack: str) -> None:
    scene = load("lift", [f"rig.slack={slack}"])
    assert scene.findings == ()
    assert (scene.statics.cut, scene.states[-1].stage) == ("", "sideways"), "followed to the end"


def test_a_move_over_zero_distance_is_reported_as_a_stage_that_ends_at_once(tmp_path: Path) -> None:
    still = LIFT.replace(SIDEWAYS, "    trolleys: traverse 20 m/min by 0 m\n")
    result = run(parse(still), tmp_path / "run.mcap", in_process=True)
    assert result.verdict is not None
    assert [(f.quantity, f.subject) for f in result.verdict.findings] == [("stage", "sideways")]


def test_an_action_list_that_never_ends_is_reported_with_the_condition_it_waits_for() -> None:
    up = "actions:\n  - stage: up\n    all hooks: hoist 10 m/min until tension of crane.H1 >= 5 MN\n"
    off = "actions:\n  - stage: unhook\n    all hooks: unhook\n" + up.partition("\n")[2]
    found = parse(LIFT[: LIFT.index("actions:")].replace("end: 60 s\n", "") + off).findings
    (endless,) = [f.sentence for f in found if f.quantity == "cut"]
    assert endless.startswith("the action list never comes to its end: still waiting for moves done (hoist of crane.H1")
    assert "crane.H1 stopped (upper limit)" in endless
    cut = load("lift", ["end=50 s"]).findings
    assert "traverse of the upper trolley of crane, traverse of the lower trolley of crane" in cut[0].sentence
