"""`landed on`: a block is lowered until it has come to the floor, an obstacle, a deck or another block."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.kernel.description import System
from heavylift.kernel.model import points, scalar
from heavylift.nodes.scene import parse
from heavylift.nodes.statics import StaticRun, at_rest, static_run
from heavylift.recordings import Recording
from scipy.spatial.transform import Rotation

LUGS = "lugs: {A: [-2 m, 2 m, 2 m], B: [2 m, 2 m, 2 m], C: [-2 m, -2 m, 2 m], D: [2 m, -2 m, 2 m]}"
STOOLS = "supports: {height: 0.5 m, at: [[-2 m, -2 m], [2 m, -2 m], [-2 m, 2 m], [2 m, 2 m]]}"
TEXT = f"""\
heavylift: 1
name: lands
accuracy: 0.1 %
block: {{mass: 40 t, size: [6 m, 5 m, 4 m], at: [0 m, 8 m, 2.5 m], {LUGS}, {STOOLS}}}
cranes: {{hall: {{type: overhead-100, at: 0 m, trolley: 8 m}}}}
rigging: {{legs: {{on: hall main, to: [A, B, C, D], length: 6 m, sling: {{EA: 120 MN}}}}}}
obstacles: {{quay: {{box: [8 m, 8 m, 1 m], at: [0 m, 20 m, 0.5 m], meets: lower corners}}}}
actions:
  - hall: hoist 1 m/min until lifted
  - hall: hoist 4 m/min by 1 m
  - hall traversing: traverse 15 m/min ramp one swing by 12 m
  - hall: lower 0.5 m/min until landed on quay
  - wait: 1 s
"""
FLOOR = TEXT.replace("obstacles: {quay", "floor: {height: 0.2 m}\nobstacles: {quay").replace("on quay", "on floor")
BARGE = "vessels: {barge: {mass: 9000 t, size: [90 m, 9 m, 6 m], at: [0 m, 20 m, 0 m], draught: 3 m, responses: {}}}"
DECK = TEXT.replace("obstacles", f"{BARGE}\nobstacles").replace(
    "[0 m, 20 m, 0.5 m], meets", "[0 m, 0 m, 0.5 m], on: barge, meets"
)
DECK = DECK.replace("[0 m, 20 m, 0.5 m]", "[0 m, 0 m, 0.5 m]")


@pytest.mark.parametrize("text", [TEXT, DECK], ids=["quay", "deck"])
def test_a_block_is_lowered_until_it_touches_an_obstacle(text: str) -> None:
    """At rest: the winch stops a millimetre above, less what it still runs: v^2 / 2a."""
    scene = parse(text, passing=True)
    last = scene.statics.states[-1]
    assert not scene.statics.why
    over = (0.5 / 60.0) ** 2 / (2.0 * 0.05)
    assert last.poses["block"][0][2] - 2.0 - 1.0 == pytest.approx(1e-3, abs=over)


def test_a_run_can_end_with_the_block_on_the_quay(tmp_path: Path) -> None:
    """It stands there, with slings that go slack as the hook comes after."""
    text = TEXT.replace("landed on quay", "landed on quay and all slings slack")
    run(parse(text, passing=True), tmp_path / "run.mcap", in_process=True)
    block = Recording(tmp_path / "run.mcap")["pose/block"].values
    assert block[-1, 1] == pytest.approx(20.0, abs=0.1)
    assert block[-1, 2] == pytest.approx(3.0, abs=2e-3)


def test_the_floor_clearance_of_a_tilted_block_is_that_of_its_lowest_corner() -> None:
    """However the block is turned: the gap to the floor is that of the corner that comes to it first."""
    it = parse(FLOOR, passing=True, followed=False).plan.actions[3].orders[0].until.threshold
    for R in Rotation.random(5, random_state=1).as_matrix():
        p = np.array([3.0, -7.0, 5.0])
        places = [x.p if x.body == "world" else p + R @ x.p for x in points(it, System())]
        corners = [p + R @ np.multiply((3.0, 2.5, 2.0), signs) for signs in product((-1.0, 1.0), repeat=3)]
        lowest = min(z for _, _, z in corners)
        assert scalar(it, places, it.numbers, []) == pytest.approx(lowest - 0.2, abs=1e-9)


def test_a_block_can_land_on_another_one() -> None:
    """Each by its name; of several it must be said which."""
    low = f"  low: {{mass: 40 t, size: [6 m, 6 m, 1 m], at: [0 m, 20 m, 1 m], {LUGS}, {STOOLS}}}"
    blocks = TEXT.replace("block: {", "blocks:\n  own: {", 1).replace("cranes:", f"{low}\ncranes:")
    blocks = blocks.replace("at: [0 m, 20 m, 0.5 m]", "at: [0 m, 30 m, 0.5 m]")
    blocks = blocks.replace("to: [A, B, C, D]", "to: [own.A, own.B, own.C, own.D]")
    text = blocks.replace("until lifted", "until own lifted").replace("landed on quay", "own landed on low")
    crossing = parse(text, passing=True, followed=False).plan.actions[3].orders[0].until
    assert (crossing.threshold.quantity, crossing.value, crossing.rising) == ("gap", 1e-3, False)
    assert (crossing.threshold.point.body, crossing.threshold.origin.body) == ("own", "low")
    with pytest.raises(SceneError, match="which block"):
        parse(text.replace("own landed on", "landed on"), passing=True)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("landed on quai", "'block' meets no 'quai' on which it could land: did you mean 'quay'"),
        ("landed on floor", "'block' meets no 'floor' on which it could land"),
        ("landed on hall.main", "'block' meets no 'hall.main' on which it could land"),
    ],
)
def test_impossible_landings_of_blocks_in_a_scene_are_reported(words: str, told: str) -> None:
    with pytest.raises(SceneError) as error:
        parse(TEXT.replace("landed on quay", words), passing=True)
    assert told.split(":")[0] in str(error.value)
    assert "scene.yaml:12:" in str(error.value)


def test_contacts_without_load_do_not_change_the_equilibrium_of_a_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = at_rest(parse(TEXT, passing=True, followed=False).plan)
    few = StaticRun(plan)
    monkeypatch.setattr(static_run, "apart", lambda *contact: False)
    all_ = StaticRun(plan)
    assert [len(r.path.command.program.system.contacts) for r in (few, all_)] == [0, 4]
    for r in (few, all_):
        r.walk()
    assert [x.t for x in few.states] == pytest.approx([x.t for x in all_.states], abs=1e-5)
    for x, y in zip(few.states, all_.states, strict=True):
        assert (x.stage, x.event) == (y.stage, y.event)
        assert x.tensions == pytest.approx(y.tensions, rel=1e-6)
        assert x.poses["block"][0] == pytest.approx(y.poses["block"][0], abs=1e-6)


def test_the_time_at_which_a_load_lowered_too_far_touches_an_obstacle_is_reported_by_statics() -> None:
    """The quay is 1 m high, the middle 2 m above the lower face; half of the ramp's time is lost."""
    scene = parse(TEXT.replace("lower 0.5 m/min until landed on quay", "lower 0.5 m/min by 2 m"), passing=True)
    begun, speed = scene.statics.acted[-1], 0.5 / 60.0
    touches = begun.t + (begun.before.poses["block"][0][2] - 3.0) / speed + speed / (2.0 * 0.05)
    found = re.search(r"'block-quay-\d' touches at ([\d.]+) s", scene.statics.why)
    assert found
    assert float(found[1]) == pytest.approx(touches, abs=0.5)
