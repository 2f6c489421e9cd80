"""A turn on a crane of parts: its trolleys and winches follow, and the centre of mass stays where it is."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.coordinator.ladder import play
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


def test_what_hangs_on_trolleys_turns_about_its_centre_of_mass() -> None:
    run = play(parse(SCENE, "tilting.yaml").plan)
    pose, stages = run.past.part(0, len(run.t)).poses["block"], {name: t for t, _, name in run.conduct.stages}
    before, after = pose[np.searchsorted(run.t, stages["turn"])], pose[run.t > stages["still"]].mean(axis=0)
    turned = [2.0 * np.degrees(np.arctan2(row[3], row[6])) for row in (before, after)]
    assert abs(turned[1] - turned[0]) == pytest.approx(15.0, abs=0.5)
    assert np.abs(after[:3] - before[:3]).max() < 0.1, "of 2 m that the lugs move"


def test_hooks_that_nothing_moves_across_cannot_follow_a_turn() -> None:
    with pytest.raises(SceneError, match=r"'block' cannot turn[^$]*it can: level"):
        load("jib", ["actions=[{jib main: 'hoist 1 m/min until lifted'}, {block: turn 20 deg/min to 15 deg}]"])
