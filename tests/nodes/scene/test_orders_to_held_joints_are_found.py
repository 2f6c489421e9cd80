"""An order to a joint locked by the model level is refused before the run with the key that locks it."""

import re

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load

LIKEWISE = "; likewise crane.lower-slide"
UNLESS = ", or leave the order out"
SPATIAL = f"of 'fidelity'; write 'motion: spatial' there{UNLESS}"
WITHOUT = "'locked' of 'fidelity'; write there a list without it and without"


def refused(scene, *settings):
    """Sentences of the faults, each with the line that it stands at."""
    with pytest.raises(SceneError) as refusal:
        load(scene, settings)
    return re.findall(r"^([\w.-]+:\d+):\d+: error: (.*)", str(refusal.value), re.M)


def test_a_traverse_order_is_refused_if_the_model_level_allows_only_motion_along_the_rails():
    assert refused("lift", "fidelity.motion=along") == [
        (
            "lift.yaml:55",
            f"actions[3].trolleys: crane.upper-slide cannot move: it is held by 'motion: along' {SPATIAL}{LIKEWISE}",
        )
    ]


def test_a_travel_order_is_refused_if_the_model_level_allows_only_motion_across_the_rails():
    message = refused("lift", "fidelity.motion=across", "actions.3={crane: travel 10 m/min by 2 m}")
    assert message == [
        ("--set:1", f"actions[3].crane: crane.gantry cannot move: it is held by 'motion: across' {SPATIAL}")
    ]


def test_an_order_to_a_locked_joint_is_refused_with_the_key_that_lists_locked_joints():
    assert refused("lift", "fidelity.locked=[trolleys]") == [
        (
            "lift.yaml:55",
            f"actions[3].trolleys: crane.upper-slide cannot move: it is held by {WITHOUT} 'trolleys'{UNLESS}{LIKEWISE}",
        )
    ]


def test_a_turn_is_refused_if_the_model_level_locks_a_trolley_that_carries_the_load():
    (_, message), *_ = refused("turnover", "fidelity.locked=[west.upper-slide]")
    assert message == f"actions[5].block: west.upper-slide cannot move: it is held by {WITHOUT} 'trolleys'{UNLESS}"


def test_a_model_level_may_lock_joints_that_receive_no_orders():
    assert load("lift", ["fidelity.motion=across"]).plan.fidelity.locked[-1] == "crane.gantry"
    assert load("lift", ["fidelity.locked=[trolleys]", "actions=[{wait: 10 s}]"]).plan
