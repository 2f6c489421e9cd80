"""Frames, boxes and ropes: the fast encoding equals the protobuf library's, ropes end where bodies are."""

from __future__ import annotations

import numpy as np
import pytest
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.timestamp_pb2 import Timestamp  # type: ignore[import-untyped]
from heavylift.recordings.drawing import Box, RopeLine, Ropes, boxes_message, frames_template
from heavylift.recordings.samples import samples_head
from heavylift.recordings.schema import Samples
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation  # type: ignore[import-untyped]

TIMES = [0, 1, 127, 1_000_000_000, 128_000_000_000, 4_000_000_000_001, 2**62]


def library_frames(t_ns: int, bodies: list[str], poses: NDArray[np.float64]) -> FrameTransforms:
    out = FrameTransforms()
    time = Timestamp(seconds=t_ns // 10**9, nanos=t_ns % 10**9)
    for body, pose in zip(bodies, poses, strict=True):
        one = out.transforms.add(timestamp=time, parent_frame_id="world", child_frame_id=body)
        one.translation.x, one.translation.y, one.translation.z = pose[:3]
        one.rotation.x, one.rotation.y, one.rotation.z, one.rotation.w = pose[3:]
    return out


@pytest.mark.parametrize("t_ns", TIMES)
def test_frames_equal_the_library_byte_for_byte(t_ns: int) -> None:
    bodies = [f"west.body{i}" for i in range(19)]
    poses = np.random.default_rng(3).normal(size=(19, 7))
    template = frames_template(bodies)
    template.encode(t_ns // 2, poses.ravel())
    assert template.encode(t_ns, poses.ravel()) == library_frames(t_ns, bodies, poses).SerializeToString()


def test_a_zero_decodes_to_the_same_frames() -> None:
    poses = np.array([[0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 1.0]])
    data = frames_template(["block"]).encode(7, poses.ravel())
    assert FrameTransforms.FromString(data) == library_frames(7, ["block"], poses)


@pytest.mark.parametrize("count", [1, 2, 15, 16, 61, 3000])
def test_samples_equal_the_library_byte_for_byte(count: int) -> None:
    row = np.random.default_rng(count).normal(size=count)
    assert samples_head(count) + row.tobytes() == Samples(value=row).SerializeToString()


def test_a_rope_runs_from_its_point_on_one_body_to_its_point_on_the_other() -> None:
    poses = np.random.default_rng(5).normal(size=(2, 7))
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1)[:, None]
    ropes = Ropes(
        [RopeLine("r", "crane", (1, 2, 3), "hook", (0, 0, 1)), RopeLine("s", "world", (4, 5, 6), "hook", (0, 1, 0))],
        ["crane", "hook"],
    )
    entity = SceneUpdate.FromString(ropes.message(10**9, poses)).entities[0]
    ends = np.array([(p.x, p.y, p.z) for p in entity.lines[0].points])
    crane, hook = (Rotation.from_quat(pose[3:]) for pose in poses)
    expected = [
        poses[0, :3] + crane.apply([1, 2, 3]),
        poses[1, :3] + hook.apply([0, 0, 1]),
        [4, 5, 6],
        poses[1, :3] + hook.apply([0, 1, 0]),
    ]
    np.testing.assert_allclose(ends, expected, rtol=0, atol=1e-14)
    assert (entity.id, entity.frame_id) == ("ropes", "world")


def test_boxes_are_locked_to_their_bodies() -> None:
    boxes = [
        Box("block", (0, 0, 5), (54, 28, 10)),
        Box("block", (0, 0, 1), (1, 1, 1)),
        Box("hook", (0, 0, 0), (2, 2, 2)),
    ]
    block, hook = SceneUpdate.FromString(boxes_message(boxes)).entities
    assert (block.frame_id, block.frame_locked, len(block.cubes)) == ("block", True, 2)
    assert (hook.frame_id, hook.cubes[0].size.x) == ("hook", 2.0)
