"""Static checks along the action list: single hooks moving, tilt, landing, early ends, stages of zero length."""

import lifting
import pytest
from heavylift.coordinator.participants import paused
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.description import clock
from heavylift.nodes.scene import check, load, parse
from heavylift.nodes.scenes import bundled
from lifting import unstated

FRICTION = 2e-3  # relative: how a run and the path have dragged pads and slings before the block hung
LIFTED = """\
  - stage: take up slack
    all hooks: hoist 0.3 m/min until all slings taut
  - stage: lift off
    all hooks: hoist 0.3 m/min until lifted
  - stage: up
    all hooks: hoist 3 m/min by 1 m
"""


def lift(orders: str, end: str = "900 s"):
    """The bundled lift up to its third stage, then other orders."""
    text = unstated(bundled()["lift"].read_text(encoding="utf-8")).replace("end: 60 s", f"end: {end}")
    return parse(text[: text.index("actions:")] + "actions:\n" + LIFTED + orders)


def test_loads_along_an_equilibrium_path_with_one_moving_hook_agree_with_the_kernel():
    scene = lift("  - stage: alone\n    crane H3: hoist 0.3 m/min by 0.5 m\n  - stage: still\n    wait: 300 s\n")
    simulation = paused(scene, at=600.0)
    rests = equilibrium(simulation).tensions
    end = scene.statics.states[-1]
    assert {name: end.tensions[name] for name in rests} == pytest.approx(rests, rel=FRICTION)
    (before,) = [
        a for a, b in zip(scene.statics.states, scene.statics.states[1:], strict=False) if b.action == a.action + 1 == 4
    ]
    R = end.poses["block"][1]
    assert before.poses["block"][1][2][2] > R[2][2], "the block leans"
    assert R[2][1] > 0.03, "its side at H3 is higher: 0.5 m over 12 m"


def test_a_block_that_is_set_down_lands_where_the_equilibrium_path_predicts():
    scene = lift("  - stage: down\n    all hooks: lower 3 m/min until landed and all slings slack\n", "900 s")
    message = [x.event for x in scene.statics.states if x.action == 4 and x.event]
    assert "closed" in message[0]
    assert "slack" in message[-1]
    last = scene.statics.states[-1]
    assert last.grounded
    assert sum(last.supports.values()) == pytest.approx(300e3 * 9.80665, rel=1e-6)


def test_an_end_time_stated_before_the_end_of_the_action_list_gives_a_red_finding():
    (cut,) = [f for f in load("lift", ["end=20 s"]).findings if f.quantity == "cut"]
    assert cut.state == "red"
    assert cut.sentence.startswith(
        "the scene ends at 20 s before its action list is done: still waiting for moves done"
    )
    assert cut.stage == "lift off"
    assert not [f for f in load("lift").findings if f.quantity == "cut"], "its last wait goes on until the end"


def test_a_stage_that_waits_for_a_condition_that_already_holds_gives_a_red_finding():
    scene = lift("  - stage: again\n    all hooks: hoist 0.3 m/min until lifted\n")
    (message,) = [f for f in scene.findings if f.quantity == "stage"]
    assert (message.word, message.subject) == ("red", "again")
    assert message.sentence == "the stage 'again' ends at once: 'lifted' holds already as it begins"
    assert "red: the stage 'again' ends at once" in str(check(scene))


def test_a_lift_that_loses_its_equilibrium_is_reported_as_unchecked_from_that_stage():
    scene = lift("  - stage: higher\n    all hooks: hoist 3 m/min by 1 m\n  - stage: let go\n    crane H1: unhook\n")
    (message,) = [f for f in scene.checks if f.quantity == "unfollowed"]
    assert message.word == "not checked"
    assert message.sentence.startswith(f"the lift is not checked at rest from {clock(message.t or 0.0, 1)} on: at ")
    assert "finds no rest" in message.sentence
    assert "the lift is not checked at rest from " in str(check(scene))


def test_a_mechanism_without_equilibrium_is_reported_with_the_reason():
    message = str(check(load("ramp")))
    assert "No rest is known: body 'crate' finds no rest: joint 'float' still accelerates by 2.36" in message


def test_a_scene_with_another_block_mass_gets_an_equilibrium_path_of_its_own():
    assert load("lift").statics == load("lift").statics
    heavier = load("lift", ["block.mass=310 t"]).statics
    assert heavier != load("lift").statics
    assert heavier.states[-1].tensions["crane.H3"] > load("lift").statics.states[-1].tensions["crane.H3"]


def test_a_block_with_eccentric_mass_starts_tilted_in_equilibrium_on_its_pads():
    text = unstated(bundled()["lift"].read_text(encoding="utf-8")).replace(
        "  supports:", "  com: [1 m, 0.5 m, 0 m]\n  supports:"
    )
    pose = lifting.pose(parse(text).plan, "block")
    assert pose[2] == pytest.approx(5.995, abs=1e-5), "on pads that give way by 5 mm"
    assert pose[4] == pytest.approx(5e-3 / 64.0 / 2.0, rel=1e-3), "about y, by 5 mm times u / (8 m)^2, half of it in q"
    assert pose[3] == pytest.approx(-5e-3 * 0.5 / 36.0 / 2.0, rel=1e-3)
