"""What viewers draw, in the standard foxglove protobuf schemas: frames, boxes, ropes, log.

Poses and ropes are written with each sample, so their messages are made from templates: the protobuf
library encodes the message once with marker numbers, the places of the markers are found, and each further
message is a copy with new numbers and a new time stamp.  The one difference to the library: a number that
is exactly 0 is written out instead of left away, which decodes to the same message.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from typing import Any, Literal

import msgspec
import numpy as np
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.timestamp_pb2 import Timestamp  # type: ignore[import-untyped]
from numpy.typing import NDArray

__all__ = ["Box", "FrameTransforms", "Log", "Rig", "RopeLine", "SceneUpdate"]

Vector = tuple[float, float, float]
Colour = tuple[float, float, float, float]
Quaternion = tuple[float, float, float, float]
WORLD = "world"
STEEL = (0.16, 0.18, 0.21, 1.0)
ROPE_WIDTH = 2.0  # [pixel]


class Box(msgspec.Struct, frozen=True):
    """A shape fixed on a body: a box, the ball in it or the cylinder along its z; centre, edges [m], turn (quaternion
    x y z w) in the body's frame, colour red green blue alpha from 0 to 1; "world" is the ground.
    """

    body: str
    centre: Vector
    size: Vector
    colour: Colour = (0.55, 0.60, 0.66, 1.0)
    turn: Quaternion = (0.0, 0.0, 0.0, 1.0)
    kind: Literal["box", "ball", "cylinder"] = "box"


class RopeLine(msgspec.Struct, frozen=True):
    """A straight part of a rope between two points, each in its body's frame [m]; "world" is the ground."""

    rope: str
    a_body: str
    a: Vector
    b_body: str
    b: Vector


class Rig(msgspec.Struct, frozen=True):
    """The rope lines that hang from this simulation time on."""

    t_ns: int
    lines: list[RopeLine]


def stamp(t_ns: int) -> Any:
    """Simulation time [ns] as a protobuf Timestamp."""
    return Timestamp(seconds=t_ns // 1_000_000_000, nanos=t_ns % 1_000_000_000)


def boxes_message(boxes: Sequence[Box]) -> bytes:
    """One SceneUpdate at time 0 with an entity per body, locked to that body's frame."""
    update = SceneUpdate()
    for body in dict.fromkeys(box.body for box in boxes):
        entity = update.entities.add(frame_id=body, id=body, frame_locked=True)
        shapes = {"box": entity.cubes, "ball": entity.spheres, "cylinder": entity.cylinders}
        for box in boxes:
            if box.body == body:
                shape = shapes[box.kind].add(color=Color(**dict(zip("rgba", box.colour, strict=True))))
                if box.kind == "cylinder":
                    shape.bottom_scale = shape.top_scale = 1.0
                for target, values in ((shape.pose.position, box.centre), (shape.size, box.size)):
                    target.x, target.y, target.z = values
                q = shape.pose.orientation
                q.x, q.y, q.z, q.w = box.turn
    return bytes(update.SerializeToString())


def boxes_of(data: bytes) -> list[Box]:
    """The shapes of such a SceneUpdate."""
    out: list[Box] = []
    kinds: dict[str, Literal["box", "ball", "cylinder"]] = {"cubes": "box", "spheres": "ball", "cylinders": "cylinder"}
    for entity in SceneUpdate.FromString(data).entities:
        for field, kind in kinds.items():
            for shape in getattr(entity, field):
                p, s, c, q = shape.pose.position, shape.size, shape.color, shape.pose.orientation
                turn = (q.x, q.y, q.z, q.w)
                out.append(Box(entity.frame_id, (p.x, p.y, p.z), (s.x, s.y, s.z), (c.r, c.g, c.b, c.a), turn, kind))
    return out


def log_message(t_ns: int, level: str, name: str, message: str) -> bytes:
    """A foxglove.Log; level is one of debug, info, warning, error, fatal."""
    log = Log(timestamp=stamp(t_ns), level=Log.Level.Value(level.upper()), name=name, message=message)
    return bytes(log.SerializeToString())


class Template:
    """A protobuf message in which only its numbers and its time stamps change.

    `build(timestamp, numbers)` makes the message with the library; `stamps` says how often it uses the time,
    each time as field 1 followed by a field 2.
    """

    def __init__(self, build: Callable[[Any, list[float]], Any], numbers: int, stamps: int) -> None:
        self._build, self._stamps = build, stamps
        self._markers = [struct.pack("<HIH", 0xA7F5, i, 0x7E5A) for i in range(numbers)]  # finite doubles
        self._forms: dict[int, tuple[NDArray[np.uint8], NDArray[np.intp], NDArray[np.intp]]] = {}

    def encode(self, t_ns: int, numbers: NDArray[np.float64]) -> bytes:
        """The message at this simulation time with these numbers (C-contiguous float64)."""
        time = bytes(stamp(t_ns).SerializeToString())
        form = self._forms.get(len(time))
        if form is None:
            form = self._forms[len(time)] = self._form(t_ns, time)
        image, number_places, stamp_places = form
        out = image.copy()
        out[number_places] = numbers.view(np.uint8)
        out[stamp_places] = np.frombuffer(time, np.uint8)
        return out.tobytes()

    def _form(self, t_ns: int, time: bytes) -> tuple[NDArray[np.uint8], NDArray[np.intp], NDArray[np.intp]]:
        values = [struct.unpack("<d", marker)[0] for marker in self._markers]
        image = self._build(stamp(t_ns), values).SerializeToString()
        starts = np.array([image.index(marker) for marker in self._markers], np.intp)
        field = b"\x0a" + bytes([len(time)]) + time + b"\x12"
        stamps = [i + 2 for i in range(len(image)) if image.startswith(field, i)]
        assert len(stamps) == self._stamps, "a name looks like a time stamp"
        number_places = (starts[:, None] + np.arange(8)).ravel()
        stamp_places = np.array(stamps, np.intp)[:, None] + np.arange(len(time))
        return np.frombuffer(image, np.uint8), number_places, stamp_places


def frames_template(bodies: Sequence[str]) -> Template:
    """FrameTransforms of all bodies from the world; numbers are x y z qx qy qz qw, body after body."""

    def build(time: Any, numbers: list[float]) -> Any:
        out = FrameTransforms()
        for i, body in enumerate(bodies):
            one = out.transforms.add(timestamp=time, parent_frame_id=WORLD, child_frame_id=body)
            p, q = one.translation, one.rotation
            p.x, p.y, p.z, q.x, q.y, q.z, q.w = numbers[7 * i : 7 * i + 7]
        return out

    return Template(build, 7 * len(bodies), len(bodies))


def ropes_template(lines: int) -> Template:
    """A SceneUpdate of the entity "ropes", two points per line; numbers are x y z in the world."""

    def build(time: Any, numbers: list[float]) -> Any:
        out = SceneUpdate()
        entity = out.entities.add(timestamp=time, frame_id=WORLD, id="ropes")
        line = entity.lines.add(type=LinePrimitive.LINE_LIST, thickness=ROPE_WIDTH, scale_invariant=True)
        line.color.r, line.color.g, line.color.b, line.color.a = STEEL
        line.pose.orientation.w = 1.0
        for i in range(0, len(numbers), 3):
            line.points.add(x=numbers[i], y=numbers[i + 1], z=numbers[i + 2])
        return out

    return Template(build, 6 * lines, 1)


def _rotation() -> NDArray[np.float64]:
    """R_ij = sum of T_ijkl q_k q_l: the rotation matrix (w^2 - u.u) 1 + 2 u u^T + 2 w [u]x of q = (u, w)."""
    T = np.zeros((3, 3, 4, 4))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        T[i, i] = np.diag((-1.0, -1.0, -1.0, 1.0))
        T[i, :, i, :3] += 2.0 * np.eye(3)
        T[i, k, 3, j], T[i, j, 3, k] = 2.0, -2.0
    return T


class Ropes:
    """The ropes of a scene as lines that follow their bodies."""

    def __init__(self, lines: Sequence[RopeLine], bodies: Sequence[str]) -> None:
        rank = {WORLD: len(bodies), **{body: i for i, body in enumerate(bodies)}}
        ends = [end for line in lines for end in ((line.a_body, line.a), (line.b_body, line.b))]
        points = np.array([point for _, point in ends], np.float64).reshape(-1, 3)
        self._turn = np.einsum("ijkl,nj->nikl", _rotation(), points).reshape(-1, 3, 16)
        self._body = np.array([rank[body] for body, _ in ends], np.intp)
        self._pose = np.zeros((len(bodies) + 1, 7))
        self._pose[-1, 6] = 1.0
        self._template = ropes_template(len(lines))

    def message(self, t_ns: int, poses: NDArray[np.float64]) -> bytes:
        """The SceneUpdate at this time; poses (bodies, 7) [m, quaternion x y z w]."""
        self._pose[:-1] = poses
        pose = self._pose[self._body]
        q = pose[:, 3:]
        turned = self._turn @ (q[:, :, None] * q[:, None, :]).reshape(-1, 16, 1)
        return self._template.encode(t_ns, (pose[:, :3] + turned[:, :, 0]).ravel())
