"""A turn on a crane made of parts: trolleys and winches follow, and the centre of mass stays in place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.record import play
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load, parse

SCENE = """
heavylift: 1
name: tilting
block:
  mass: 160 t
  size: [10 m, 20 m, 6 m]
  at: [0 m, 45 m, 4 m]
  lugs: {F1: [-3 m, 8 m, 3.2 m], F2: [3 m, 8 m, 3.2 m], R1: [-2 m, -8 m, 3.2 m], R2: [2 m, -8 m, 3.2 m]}
  supports: {height: 1 m, at: [[-4 m, -8 m], [4 m, -8 m], [-4 m, 8 m], [4 m, 8 m]]}
cranes:
  crane: {type: twin-hook-600, upper: 53 m, lower: 37 m}
rigging:
  front: {on: [crane H1, crane H2], to: [F1, F2], length: 6 m, sling: {EA: 250 MN, breaking: 4 MN}}
  rear: {on: crane H3, to: [R1, R2], length: 8 m, sling: {EA: 250 MN, breaking: 4 MN}}
actions:
  - all hooks: hoist 0.5 m/min until all slings taut
  - all hooks: hoist 0.5 m/min until lifted
  - all hooks: hoist 3 m/min by 5 m
  - block: level 0.5 m/min within 0.1 deg with crane H3
  - stage: turn
    block: turn 20 deg/min to 15 deg
  - stage: still
    wait: 60 s
"""
BAR = """
frame type: 1
name: bar
eye: {body: bar, apart: 2 m}
slings: [{body: bar, at: [-2 m, 0 m, -1 m]}, {body: bar, at: [2 m, 0 m, -1 m]}]
bodies: {bar: {mass: 6 t, com: [0 m, 0 m, -0.5 m], box: [5 m, 0.5 m, 1 m]}}
"""
FRAMES = """
heavylift: 1
name: frames
block:
  mass: 160 t
  size: [16 m, 20 m, 6 m]
  at: [40 m, 75 m, 4 m]
  lugs:
    F1: [-7 m, 8 m, 3.2 m]
    F2: [-5 m, 8 m, 3.2 m]
    F3: [5 m, 8 m, 3.2 m]
    F4: [7 m, 8 m, 3.2 m]
    R1: [-2 m, -8 m, 3.2 m]
    R2: [2 m, -8 m, 3.2 m]
  supports: {height: 1 m, at: [[-7 m, -8 m], [7 m, -8 m], [-7 m, 8 m], [7 m, 8 m]]}
cranes: {crane: {type: CRANE, at: 40 m}}
rig:
  slack: 0.1 m
  loaders:
    left: {type: BEAM, hook: crane H1, sling: 10 m, lugs: [F1, F2]}
    right: {type: BEAM, hook: crane H2, sling: 10 m, lugs: [F3, F4]}
    rear: {type: BEAM, hook: crane H3, sling: 10 m, lugs: [R1, R2]}
actions:
  - all hooks: hoist 0.5 m/min until all slings taut
  - all hooks: hoist 0.5 m/min until lifted
  - all hooks: hoist 3 m/min by 5 m
  - stage: turn
    block: turn 20 deg/min to 10 deg
  - stage: still
    wait: 60 s
"""
OTHER = """  other:
    mass: 1 t
    size: [2 m, 2 m, 2 m]
    at: [30 m, 45 m, 1 m]
    lugs: {L: [0 m, 0 m, 1 m]}
    supports: {height: 0 m, at: [[-1 m, -1 m], [1 m, -1 m], [0 m, 1 m]]}
"""


def several(text: str) -> str:
    """The block as one of several, of another name."""
    head, _, rest = text.partition("block:\n")
    own, _, after = rest.partition("cranes:")
    inner = "".join(f"  {line}\n" for line in own.splitlines())
    return f"{head}blocks:\n  tank:\n{inner}cranes:{after}".replace("  - block: ", "  - tank: ").replace(
        "    block: turn", "    tank: turn"
    )


def test_any_of_several_blocks_in_a_scene_can_be_turned_over() -> None:
    one, two = (play(parse(text, "tilting.yaml").plan) for text in (SCENE, several(SCENE)))
    a, b = one.past.part(0, len(one.t)), two.past.part(0, len(two.t))
    assert np.abs(a.poses["block"] - b.poses["tank"]).max() < 1e-4, "to the tolerance, in another order of names"
    both = list(zip(one.conduct.stages, two.conduct.stages, strict=True))
    assert all(p[2] == q[2] for p, q in both)
    assert [p[0] for p, _ in both] == pytest.approx([q[0] for _, q in both], abs=1e-2)


def test_a_turned_block_can_be_set_down_on_its_other_face() -> None:
    block, tank = (parse(text, "tilting.yaml").plan.machines for text in (SCENE, several(SCENE)))
    sets = [next(m for m in machines if m.cargo) for machines in (block, tank)]
    assert [[s.height for s in m.system.supports] for m in sets] == [[1.0] * 8] * 2
    assert [*sets[1].cargo[0].faces.values()] == ["lower"] * 4 + ["upper"] * 4


def test_an_action_list_that_turns_a_second_block_is_refused() -> None:
    message = "'tank' is turned before, and one list can turn only one block: leave 'other' as it is"
    with pytest.raises(SceneError, match=message):
        parse(several(SCENE).replace("  tank:\n", f"{OTHER}  tank:\n", 1) + "  - other: turn 20 deg/min to 15 deg\n")


@pytest.mark.parametrize("beam", ["block-loader", "bar.yaml"])
@pytest.mark.parametrize("crane", ["goliath-900", "twin-hook-600, upper: 83 m, lower: 67 m"])
def test_a_block_on_frames_of_any_type_turns(crane: str, beam: str, tmp_path: Path) -> None:
    """On two trolleys of any crane, below hinged beams or plain bars of a user's own."""
    (tmp_path / "bar.yaml").write_text(BAR)
    (tmp_path / "scene.yaml").write_text(FRAMES.replace("BEAM", beam).replace("CRANE", crane))
    scene = load(tmp_path / "scene.yaml")
    rests = [state for state in scene.statics.states if state.stage in ("turn", "still")]
    (p, _), (q, _) = rests[0].poses["block"], rests[-1].poses["block"]
    assert rests[-1].references["turn"] - rests[0].references["turn"] > np.radians(9.0)
    assert np.abs(np.array(p) - np.array(q)).max() < 0.1


def test_a_block_on_trolleys_turns_about_its_centre_of_mass() -> None:
    run = play(parse(SCENE, "tilting.yaml").plan)
    pose, stages = run.past.part(0, len(run.t)).poses["block"], {name: t for t, _, name in run.conduct.stages}
    before, after = pose[np.searchsorted(run.t, stages["turn"])], pose[run.t > stages["still"]].mean(axis=0)
    turned = [2.0 * np.degrees(np.arctan2(row[3], row[6])) for row in (before, after)]
    assert abs(turned[1] - turned[0]) == pytest.approx(15.0, abs=0.5)
    assert np.abs(after[:3] - before[:3]).max() < 0.1, "of 2 m that the lugs move"


def test_a_turn_with_hooks_that_have_no_trolley_is_refused() -> None:
    with pytest.raises(SceneError, match=r"'block' cannot turn[^$]*it can: level"):
        load("jib", ["actions=[{jib main: 'hoist 1 m/min until lifted'}, {block: turn 20 deg/min to 15 deg}]"])
