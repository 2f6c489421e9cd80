"""The keys of `mechanism: forces:` in a scene file, and what they become in the kernel's force table.

A history is a list of [time, value], linear between; the value is a factor of what the force does, or the wind's speed.
The laws themselves and their conventions: `heavylift.kernel.description.forces`.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal, cast

from heavylift.kernel.description import forces as f
from heavylift.kernel.description.points import Point
from heavylift.kernel.trust import named
from heavylift.nodes.scene.keys.base import Base, Direction, End, Quaternion, Station, quaternion_matrix, unit
from heavylift.nodes.scene.text import units as u
from pydantic import Field

Row6 = tuple[u.Number, u.Number, u.Number, u.Number, u.Number, u.Number]
Matrix6 = tuple[Row6, Row6, Row6, Row6, Row6, Row6]
History = list[tuple[u.Instant, u.Number]]
Keys = tuple[str | int, ...]


class _Force(Base):
    @property
    def bodies(self) -> Iterator[tuple[Keys, str]]:
        """The bodies that it names, with the keys that do so."""
        for key in ("body", "start", "end", "ends"):
            match getattr(self, key, None):
                case str(body):
                    yield (key,), body
                case End(body=body):
                    yield (key, "body"), body
                case [*ends]:
                    yield from (((key, i, "body"), end.body) for i, end in enumerate(ends))

    @abstractmethod
    def built(self, name: str, folder: Path) -> f.Force:
        """The kernel's description; `folder`: where files stand that it names."""


class Load(_Force):
    """A force and a moment at a point of a body, fixed in world or body axes, times `factor` or a `history`."""

    type: Literal["load"]
    body: str
    at: Station = (0.0, 0.0, 0.0)
    force: tuple[u.Push, u.Push, u.Push] = (0.0, 0.0, 0.0)
    moment: tuple[u.Twist, u.Twist, u.Twist] = (0.0, 0.0, 0.0)
    axes: Literal["world", "body"] = "world"
    factor: u.Number = 1.0
    history: History = Field(default_factory=list)

    def built(self, name: str, folder: Path) -> f.Force:
        at = Point(self.body, self.at)
        return f.Load(name, at, self.force, self.moment, self.axes, _signal(self.factor, self.history))


class Wind(_Force):
    """Drag of a wind on an area at a point of a body, or on the `sides` of a box; `gusts` are its speed over time."""

    type: Literal["wind"]
    body: str
    at: Station = (0.0, 0.0, 0.0)
    area: u.Area = 0.0
    sides: tuple[u.Area, u.Area, u.Area] = (0.0, 0.0, 0.0)  # seen along the body's axes
    drag: u.Ratio
    direction: Direction
    speed: u.Velocity = 0.0
    gusts: list[tuple[u.Instant, u.Velocity]] = Field(default_factory=list)
    density: u.Density = 1.225

    def built(self, name: str, folder: Path) -> f.Force:
        at, signal = Point(self.body, self.at), _signal(self.speed, self.gusts)
        return f.Wind(name, at, self.area, self.drag, unit(self.direction), signal, self.density, self.sides)


class Spring(_Force):
    """A spring and damper between two points that pulls and pushes."""

    type: Literal["spring"]
    start: End
    end: End
    rest: u.Gap
    stiffness: u.Stiffness = 0.0
    damping: u.Damping = 0.0

    def built(self, name: str, folder: Path) -> f.Force:
        return f.Spring(name, _point(self.start), _point(self.end), self.rest, self.stiffness, self.damping)


class Torsion(_Force):
    """A torsional spring and damper between two bodies about `axis` in the frame of `start`."""

    type: Literal["torsion"]
    start: str
    end: str
    axis: Direction
    stiffness: u.TurnStiffness = 0.0
    damping: u.TurnDamping = 0.0
    rest: u.Angle = 0.0

    def built(self, name: str, folder: Path) -> f.Force:
        return f.Torsion(name, self.start, self.end, unit(self.axis), self.stiffness, self.damping, self.rest)


class Bushing(_Force):
    """A spring and damper in all six directions between two frames; K and D are whole matrices in SI units."""

    type: Literal["bushing"]
    start: End
    end: End
    start_attitude: Quaternion = (0.0, 0.0, 0.0, 1.0)
    end_attitude: Quaternion = (0.0, 0.0, 0.0, 1.0)
    stiffness: tuple[u.Stiffness, u.Stiffness, u.Stiffness] = (0.0, 0.0, 0.0)
    turning_stiffness: tuple[u.TurnStiffness, u.TurnStiffness, u.TurnStiffness] = (0.0, 0.0, 0.0)
    damping: tuple[u.Damping, u.Damping, u.Damping] = (0.0, 0.0, 0.0)
    turning_damping: tuple[u.TurnDamping, u.TurnDamping, u.TurnDamping] = (0.0, 0.0, 0.0)
    K: Matrix6 | None = None
    D: Matrix6 | None = None

    def built(self, name: str, folder: Path) -> f.Force:
        K = self.K or _diagonal((*self.stiffness, *self.turning_stiffness))
        D = self.D or _diagonal((*self.damping, *self.turning_damping))
        turns = quaternion_matrix(self.start_attitude), quaternion_matrix(self.end_attitude)
        return f.Bushing(name, _point(self.start), _point(self.end), K, D, *turns)


class Characteristic(_Force):
    """An actuator law as data: a `curve` of [position or speed, effort] of a joint, times `factor` or a `history`."""

    type: Literal["characteristic"]
    joint: str
    coordinate: str = ""
    over: Literal["position", "speed"]
    curve: list[tuple[u.Reach, u.Thrust]] = Field(min_length=1)
    factor: u.Number = 1.0
    history: History = Field(default_factory=list)

    def built(self, name: str, folder: Path) -> f.Force:
        x, effort = tuple(a for a, _ in self.curve), tuple(b for _, b in self.curve)
        signal = _signal(self.factor, self.history)
        return f.Characteristic(name, self.joint, self.over, x, effort, signal, self.coordinate)


class Law(_Force):
    """A law of the user's own: "package.module:function", or "file.py:function" beside the scene's file."""

    type: Literal["law"]
    function: str
    joint: str = ""
    coordinate: str = ""
    ends: list[End] = Field(default_factory=list)
    parameters: list[u.Number] = Field(default_factory=list)
    factor: u.Number = 1.0
    history: History = Field(default_factory=list)
    guards: str = ""
    modes: int = Field(default=0, ge=0)

    def built(self, name: str, folder: Path) -> f.Force:
        function, guards = (_beside(x, folder) for x in (self.function, self.guards))
        ends, signal = tuple(map(_point, self.ends)), _signal(self.factor, self.history)
        named(x for x in (function, guards) if x)
        along = self.joint, ends, tuple(self.parameters)
        return f.UserLaw(name, function, *along, signal, guards, self.modes, self.coordinate)


Force = Annotated[Load | Wind | Spring | Torsion | Bushing | Characteristic | Law, Field(discriminator="type")]


def _point(end: End) -> Point:
    return Point(end.body, end.at)


def _signal(value: float, history: list[tuple[float, float]]) -> f.Signal:
    return f.Signal(value, tuple(t for t, _ in history), tuple(x for _, x in history))


def _diagonal(values: tuple[float, ...]) -> Matrix6:
    return cast(Matrix6, tuple(tuple(x if i == j else 0.0 for j in range(6)) for i, x in enumerate(values)))


def _beside(function: str, folder: Path) -> str:
    """A function of a file, the file found from the scene's folder."""
    module, colon, name = function.rpartition(":")
    return f"{(folder / module).resolve()}{colon}{name}" if module.endswith(".py") else function
