"""Frames, boxes and ropes: the fast encoding equals the protobuf library's, ropes end where bodies are."""

from __future__ import annotations

import numpy as np
import pytest
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.message_factory import GetMessageClass  # type: ignore[import-untyped]
from google.protobuf.timestamp_pb2 import Timestamp  # type: ignore[import-untyped]
from heavylift.recordings.format import (
    DrawnBox,
    RopeLine,
    Ropes,
    SampleChannel,
    boxes_message,
    frames_template,
    sample_fields,
    samples_descriptor,
    samples_template,
)
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation  # type: ignore[import-untyped]

HALF_A_MILLIMETRE = 0.5e-3  # ropes are a picture
TIMES = [0, 1, 127, 1_000_000_000, 128_000_000_000, 4_000_000_000_001, 2**62]


def library_frames(t_ns: int, bodies: list[str], poses: NDArray[np.float64]) -> FrameTransforms:
    out = FrameTransforms()
    time = Timestamp(seconds=t_ns // 10**9, nanos=t_ns % 10**9)
    for body, pose in zip(bodies, poses, strict=True):
        one = out.transforms.add(timestamp=time, parent_frame_id="world", child_frame_id=body)
        one.translation.x, one.translation.y, one.translation.z = pose[:3]
        one.rotation.x, one.rotation.y, one.rotation.z, one.rotation.w = pose[3:]
    return out


def test_recorded_frames_of_bodies_are_decoded_equally_by_the_protobuf_library() -> None:
    bodies = [f"west.body{i}" for i in range(19)]
    poses = np.random.default_rng(3).normal(size=(len(TIMES), 19, 7))
    template = frames_template(bodies)
    messages = template.encode(TIMES, poses)
    for data, t_ns, pose in zip(messages, TIMES, poses, strict=True):
        assert FrameTransforms.FromString(data.tobytes()) == library_frames(t_ns, bodies, pose)
    whole, fourth = template.decode(messages, slice(None), slice(21, 28))
    assert np.array_equal(whole, poses.reshape(len(TIMES), -1))
    assert np.array_equal(fourth, poses[:, 3])


def test_poses_with_zero_coordinates_are_encoded_as_by_the_protobuf_library() -> None:
    poses = np.array([[0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 1.0]])
    (data,) = frames_template(["block"]).encode([7], poses)
    assert FrameTransforms.FromString(data.tobytes()) == library_frames(7, ["block"], poses)


def test_invalid_recorded_frames_are_refused() -> None:
    message = library_frames(7, ["hook"], np.zeros((1, 7))).SerializeToString()
    with pytest.raises(ValueError, match="not of the form of its channel"):
        frames_template(["block"]).decode(np.frombuffer(message, np.uint8)[None])


@pytest.mark.parametrize("counts", [[1], [2, 15], [16, 61, 3000], [1] * 20])
def test_recorded_samples_equal_those_of_the_protobuf_library_byte_by_byte(counts: list[int]) -> None:
    fields = sample_fields([SampleChannel(f"rope/{i}", ["x"] * n, "N", 0, n) for i, n in enumerate(counts)])
    rows = np.random.default_rng(5).normal(size=(3, sum(counts)))
    Samples = GetMessageClass(samples_descriptor([field.field for field in fields]))
    for row, data in zip(rows, samples_template(fields).encode([0] * len(rows), rows), strict=True):
        parts = np.split(row, np.cumsum(counts)[:-1])
        message = Samples(**{field.field: part for field, part in zip(fields, parts, strict=True)})
        assert data.tobytes() == message.SerializeToString()


def test_any_signal_name_becomes_a_valid_message_field() -> None:
    topics = ["rope/peak_time", "rope/peak/time", "2nd law", "größe"]
    fields = sample_fields([SampleChannel(topic, ["x"], "1", 0, 1) for topic in topics])
    assert [field.field for field in fields] == ["rope_peak_time", "rope_peak_time_2", "x2nd_law", "gr__e"]
    samples_descriptor([field.field for field in fields])


def test_a_rope_is_drawn_between_its_attachment_points_on_two_bodies() -> None:
    poses = np.random.default_rng(5).normal(size=(2, 7))
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1)[:, None]
    ropes = Ropes(
        [RopeLine("r", "crane", (1, 2, 3), "hook", (0, 0, 1)), RopeLine("s", "world", (4, 5, 6), "hook", (0, 1, 0))],
        ["crane", "hook"],
    )
    (message,) = ropes.messages([10**9], poses[None])
    entity = SceneUpdate.FromString(message.tobytes()).entities[0]
    ends = np.array([(p.x, p.y, p.z) for p in entity.lines[0].points])
    crane, hook = (Rotation.from_quat(pose[3:]) for pose in poses)
    expected = [
        poses[0, :3] + crane.apply([1, 2, 3]),
        poses[1, :3] + hook.apply([0, 0, 1]),
        [4, 5, 6],
        poses[1, :3] + hook.apply([0, 1, 0]),
    ]
    np.testing.assert_allclose(ends, expected, rtol=0, atol=HALF_A_MILLIMETRE)
    assert (entity.id, entity.frame_id) == ("ropes", "world")


def test_drawn_boxes_move_with_the_frames_of_their_bodies() -> None:
    boxes = [
        DrawnBox("block", (0, 0, 5), (54, 28, 10)),
        DrawnBox("block", (0, 0, 1), (1, 1, 1)),
        DrawnBox("hook", (0, 0, 0), (2, 2, 2)),
    ]
    block, hook = SceneUpdate.FromString(boxes_message(boxes)).entities
    assert (block.frame_id, block.frame_locked, len(block.cubes)) == ("block", True, 2)
    assert (hook.frame_id, hook.cubes[0].size.x) == ("hook", 2.0)
