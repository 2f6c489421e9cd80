"""A boom that bends is drawn, and held against others, where the kernel has it: probes on it tell."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.ladder import at_level
from heavylift.coordinator.record import Played, boxes, play
from heavylift.coordinator.verdict.moving import moving
from heavylift.nodes.plan import Fidelity, Plan, Shapes
from heavylift.nodes.scene import load
from numpy.typing import NDArray

TYPE = (Path(__file__).parents[2] / "data" / "bending-boom.yaml").read_text()
LENGTH, DEEP = 40.0, 1.5  # of the boom [m]
PLACES = (0.0, 40.0 / 6.0, 20.0, 33.0, 40.0)
SCENE = """
heavylift: 1
name: boom
end: 60 s
cranes: {crane: {type: boom.yaml}}
block:
  mass: 30 t
  size: [4 m, 4 m, 2 m]
  at: [20 m, 0 m, 1.5 m]
  lugs: {P: [-1 m, 0 m, 1.2 m], Q: [1 m, 0 m, 1.2 m]}
  supports: {height: 0.5 m, at: [[-1 m, -1 m], [1 m, -1 m], [-1 m, 1 m], [1 m, 1 m]]}
rigging: {legs: {on: crane main, to: [P, Q], length: 4 m}}
actions:
  - all hooks: hoist 3 m/min until all slings taut
  - all hooks: hoist 1 m/min until lifted
  - all hooks: hoist 6 m/min by 2 m
  - crane: slew 3 deg/s by 20 deg
"""


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Plan:
    folder = tmp_path_factory.mktemp("boom")
    bodies = "".join(f"  probe-{i}: {{mass: 1 kg, box: [1 cm, 1 cm, 1 cm]}}\n" for i in range(len(PLACES)))
    joints = "".join(
        f"  seat-{i}: {{type: fixed, parent: boom, child: probe-{i}, at: [{x!r} m, 0 m, 0 m]}}\n"
        for i, x in enumerate(PLACES)
    )
    text = TYPE.replace("bodies:\n", f"bodies:\n{bodies}").replace("joints:\n", f"joints:\n{joints}")
    (folder / "boom.yaml").write_text(text)
    (folder / "scene.yaml").write_text(SCENE)
    return load(folder / "scene.yaml").plan


@pytest.fixture(scope="module", params=["rigid", "elastic"])
def level(request: pytest.FixtureRequest) -> str:
    found: str = request.param
    return found


@pytest.fixture(scope="module")
def run(plan: Plan, level: str) -> Played:
    return play(at_level(plan, Fidelity(girder=level)))


def probe(run: Played, i: int) -> NDArray[np.float64]:
    return run.past.part(0, len(run.t)).poses[f"crane.probe-{i}"][:, :3]


def test_a_boom_bends_only_on_elastic_model_levels(run: Played, level: str) -> None:
    foot, tip = probe(run, 0), probe(run, len(PLACES) - 1)
    shorter = np.abs(np.linalg.norm(tip - foot, axis=1) - LENGTH)
    pose = run.past.part(0, len(run.t)).poses
    straight = pose["crane.boom"][:, :3] + 2.0 * (probe(run, 2) - foot)
    sags = np.linalg.norm(tip - straight, axis=1).max()
    assert bool(sags > 0.02) is (level == "elastic")
    assert shorter.max() < 0.05


def test_the_drawn_parts_of_a_bent_boom_contain_its_axis(run: Played, plan: Plan, level: str) -> None:
    shapes = Shapes(at_level(plan, Fidelity(girder=level)))
    parts = [x for x in moving(shapes, run.past.part(0, len(run.t))) if x.shape.thing == "crane.boom"]
    assert sum(part.half[0] for part in parts) == pytest.approx(LENGTH / 2.0)
    for i, x in enumerate(PLACES):
        misses = []
        for part in parts:
            R, half = part.axes_of(part.turn)
            lateral = np.einsum("nij,ni->nj", np.broadcast_to(R, (len(run.t), 3, 3)), probe(run, i) - part.centre)
            along, across = np.abs(lateral[:, 0]) - half[:, 0], np.linalg.norm(lateral[:, 1:], axis=1)
            misses.append(np.hypot(np.maximum(along, 0.0), across))
        assert np.min(misses, axis=0).max() < 0.01, x
    assert not any("crane.boom" in message for message in shapes.shapeless)


def test_the_drawing_and_the_clearance_check_of_a_boom_use_the_same_bent_shape(plan: Plan) -> None:
    drawn = [(box.body, box.size) for box in boxes(plan) if box.body.startswith("crane.boom")]
    assert [body for body, _ in drawn] == ["crane.boom", *(f"crane.boom~{i}" for i in range(2, 7))]
    assert {size for _, size in drawn} == {(LENGTH / 6.0, DEEP, DEEP)}


def test_the_hook_rope_is_drawn_from_the_deflected_tip_of_a_bent_boom(run: Played, plan: Plan, level: str) -> None:
    history = run.past.part(0, len(run.t))
    ropes = [x for x in moving(Shapes(plan), history) if getattr(x.shape, "rope", "") == "crane.main"]
    tops = [frame.place(p) for frame, p in (rope.on[0] for rope in ropes)]
    assert np.abs((tops[0] + tops[1]) / 2.0 - probe(run, len(PLACES) - 1)).max() < 0.01
