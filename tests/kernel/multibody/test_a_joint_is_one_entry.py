"""The recipe for a joint: a name and one entry of the table; the kernel moves a gimbal as MuJoCo moves three hinges."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, get_args

import mujoco
import pytest
from heavylift.kernel.description import (
    AXIS,
    JOINTS,
    SECOND,
    THIRD,
    JointMotion,
    JointType,
    System,
    field_types,
    mechanics,
)
from heavylift.kernel.model import Program
from random_trees import GRAVITY, random_state
from test_every_joint_agrees_with_others import INTO_MUJOCO, SAME, SOLID, accelerations, joint, mujoco_model, relative

GIMBAL = JointType(
    {"roll": 0.0, "pitch": 0.0, "yaw": 0.0},
    ("rate1", "rate2", "rate3"),
    (JointMotion(True, AXIS, 0), JointMotion(True, SECOND, 1), JointMotion(True, THIRD, 2)),
)


@pytest.fixture(autouse=True)
def _gimbal(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    names = (*get_args(mechanics.JointKind), "gimbal")
    monkeypatch.setattr(mechanics, "JointKind", Literal[names])
    monkeypatch.setitem(JOINTS, "gimbal", GIMBAL)  # type: ignore[misc]
    monkeypatch.setitem(INTO_MUJOCO, "gimbal", lambda axes: [("hinge", axis) for axis in axes])
    field_types._hints.cache_clear()
    yield
    field_types._hints.cache_clear()


@pytest.mark.parametrize("seed", range(3))
def test_a_newly_added_joint_type_has_the_accelerations_of_mujoco(seed: int) -> None:
    assert JOINTS["gimbal"].n_v == 3
    program = Program(System((SOLID,), (joint("gimbal"),), gravity=GRAVITY))
    model = mujoco_model(program.graph)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = q, v = random_state(program.graph, seed)
    mujoco.mj_forward(model, data)
    assert relative(accelerations(program, q, v), data.qacc) < SAME
