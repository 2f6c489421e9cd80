"""Messages for viewers in the standard foxglove protobuf schemas: frames, boxes, ropes, log.

Frames are written with each sample, unrounded. Ropes are only a picture: they are rounded to a millimetre and written
again only when they have moved, since their ends follow from the frames.
"""

from collections.abc import Sequence
from typing import Literal

import msgspec
import numpy as np
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.timestamp_pb2 import Timestamp  # type: ignore[import-untyped]
from numpy.typing import NDArray

from .schema import Template, stamp

__all__ = ["DrawnBox", "FrameTransforms", "Log", "Rig", "RopeLine", "SceneUpdate"]

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]
Colour = tuple[float, float, float, float]
Quaternion = tuple[float, float, float, float]
WORLD = "world"
CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
STEEL = (0.16, 0.18, 0.21, 1.0)
ROPE_WIDTH = 2.0  # [pixel]
MILLIMETRE = 2.0**10  # parts of a metre in which ropes are drawn
STILL = 0.02  # [m], and about [rad]: a body that has moved less leaves its ropes where they are


class DrawnBox(msgspec.Struct, frozen=True):
    """A shape drawn on a body: a box, a ball, or a cylinder along z.

    Centre, edge lengths [m] and quaternion x y z w in the body's frame, RGBA from 0 to 1; "world" is the ground.
    """

    body: str
    centre: Vector
    size: Vector
    colour: Colour = (0.55, 0.60, 0.66, 1.0)
    turn: Quaternion = (0.0, 0.0, 0.0, 1.0)
    kind: Literal["box", "ball", "cylinder"] = "box"


class RopeLine(msgspec.Struct, frozen=True):
    """A straight part of a rope between two points given in the frames of their bodies [m]; "world" is the ground."""

    rope: str
    a_body: str
    a: Vector
    b_body: str
    b: Vector


class Rig(msgspec.Struct, frozen=True):
    """A set of rope lines to draw, valid from the simulation time `t_ns` [ns] on."""

    t_ns: int
    lines: list[RopeLine]


def boxes_message(boxes: Sequence[DrawnBox]) -> bytes:
    """Return a SceneUpdate at time 0 with one entity per body, attached to the frame of the body."""
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


def boxes_of(data: bytes) -> list[DrawnBox]:
    """Return the shapes in a SceneUpdate that `boxes_message` has made."""
    out: list[DrawnBox] = []
    kinds: dict[str, Literal["box", "ball", "cylinder"]] = {"cubes": "box", "spheres": "ball", "cylinders": "cylinder"}
    for entity in SceneUpdate.FromString(data).entities:
        for field, kind in kinds.items():
            for shape in getattr(entity, field):
                p, s, c, q = shape.pose.position, shape.size, shape.color, shape.pose.orientation
                turn = (q.x, q.y, q.z, q.w)
                out.append(
                    DrawnBox(entity.frame_id, (p.x, p.y, p.z), (s.x, s.y, s.z), (c.r, c.g, c.b, c.a), turn, kind)
                )
    return out


def log_message(t_ns: int, level: str, name: str, message: str, number: int = 0) -> bytes:
    """Return a foxglove.Log message; `level`: debug, info, warning, error or fatal.

    `number`: number of a note, stored in the field `line`.
    """
    log = Log(timestamp=stamp(t_ns), level=Log.Level.Value(level.upper()), name=name, message=message, line=number)
    return bytes(log.SerializeToString())


def frames_template(bodies: Sequence[str]) -> Template:
    """Return the template of FrameTransforms from the world to all bodies: x y z qx qy qz qw, body after body."""

    def build(time: Timestamp, numbers: list[float]) -> FrameTransforms:
        out = FrameTransforms()
        for i, body in enumerate(bodies):
            one = out.transforms.add(timestamp=time, parent_frame_id=WORLD, child_frame_id=body)
            p, q = one.translation, one.rotation
            p.x, p.y, p.z, q.x, q.y, q.z, q.w = numbers[7 * i : 7 * i + 7]
        return out

    return Template(build, 7 * len(bodies), len(bodies))


def ropes_template(lines: int) -> Template:
    """Return the template of a SceneUpdate of the entity "ropes" with two points per line, x y z in the world."""

    def build(time: Timestamp, numbers: list[float]) -> SceneUpdate:
        out = SceneUpdate()
        entity = out.entities.add(timestamp=time, frame_id=WORLD, id="ropes")
        line = entity.lines.add(type=LinePrimitive.LINE_LIST, thickness=ROPE_WIDTH, scale_invariant=True)
        line.color.r, line.color.g, line.color.b, line.color.a = STEEL
        line.pose.orientation.w = 1.0
        for i in range(0, len(numbers), 3):
            line.points.add(x=numbers[i], y=numbers[i + 1], z=numbers[i + 2])
        return out

    return Template(build, 6 * lines, 1)


def turned(q: Floats, points: Floats) -> Floats:
    """Return points (..., 3) rotated by unit quaternions q (..., 4) = (x, y, z, w).

    With u = (x, y, z), the result is p + 2 u x (u x p + w p).
    """
    u, w = q[..., :3], q[..., 3:]
    out: Floats = points + 2.0 * _cross(u, _cross(u, points) + w * points)
    return out


def _cross(a: Floats, b: Floats) -> Floats:
    """Return cross products (..., 3), five times as fast as NumPy's function."""
    (x, y, z), (u, v, w) = ([c[..., i] for i in range(3)] for c in (a, b))
    out: Floats = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0], out[..., 1], out[..., 2] = y * w - z * v, z * u - x * w, x * v - y * u
    return out


def corners(box: DrawnBox) -> Floats:
    """Return the corners (8, 3) [m] of a shape, or of the bounding box of a ball or cylinder, in its body's frame."""
    return np.array(box.centre) + turned(np.array(box.turn), CORNERS * np.array(box.size))


class Ropes:
    """Rope lines whose ends move with their bodies, and their drawing messages."""

    def __init__(self, lines: Sequence[RopeLine], bodies: Sequence[str]) -> None:
        rank = {WORLD: len(bodies), **{body: i for i, body in enumerate(bodies)}}
        ends = [end for line in lines for end in ((line.a_body, line.a), (line.b_body, line.b))]
        self._points = np.array([point for _, point in ends], np.float64).reshape(-1, 3)
        self._body = np.array([rank[body] for body, _ in ends], np.intp)
        self._ground = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        self._template = ropes_template(len(lines))
        self._drawn = np.full((len(bodies), 7), np.inf)

    def moved(self, poses: NDArray[np.float64]) -> bool:
        """Return whether a body has moved since the rope lines were last drawn; if so, store the new poses."""
        moved = bool(np.abs(poses - self._drawn).max(initial=0.0) >= STILL)
        if moved:
            self._drawn = poses
        return moved

    def messages(self, times: Sequence[int], poses: NDArray[np.float64]) -> NDArray[np.uint8]:
        """Return SceneUpdate messages (n, bytes) of the rope lines at these times [ns].

        poses (n, bodies, 7): [m, quaternion x y z w].
        """
        ground = np.broadcast_to(self._ground, (len(poses), 1, 7))
        pose = np.concatenate([poses, ground], axis=1)[:, self._body]
        places = pose[:, :, :3] + turned(pose[:, :, 3:], self._points)
        ends = np.rint(places * MILLIMETRE) / MILLIMETRE
        return self._template.encode(times, ends.reshape(len(poses), -1))
