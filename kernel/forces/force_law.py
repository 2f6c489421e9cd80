"""What the kernel asks of a kind of force: the columns of the force table, with the defaults of a plain force.

A kind says where it acts, which numbers it keeps in P and what it answers at one instant.  Its text is traced once per
shape and shared by all forces of that shape.  Discrete states (hooked, taut, closed, stick) are numbers in P, frozen
during a step; *guards* are scalars that are positive while they hold, and `switch` changes them at the located event
when one falls below zero.  So no clamp ever acts inside a step, and the integrators keep their order.
Each law also gives the power that it turns into heat or takes from a motor: the energy balance integrates those.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from heavylift.kernel.algebra.spatial import cross, join
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, named
from heavylift.kernel.description.field_types import item_word
from heavylift.kernel.description.forces import InputSignal
from heavylift.kernel.description.mechanics import Law
from heavylift.kernel.errors import KernelError
from heavylift.kernel.multibody.graph import Graph

F = TypeVar("F", bound=Law)
BODY = 21  # numbers that describe a body to a law: R, o, r, V, see `attachment`
Poses = Callable[[str], tuple[Array, Array]]  # body -> R_WB (3, 3), p_WB (3,) at the start


class SampledQuantity(NamedTuple):
    """A sampled quantity: topic ("" if not recorded), name, unit, column group."""

    topic: str
    name: str
    unit: str
    column: str = "shown"


@dataclass(frozen=True)
class Setting:
    """What a law may ask of its scene.

    `clamped`: the part of a step that lies behind an event, and is thrown away, sees the one-sided law; `at_rest`: only
    rests are looked for; `calm`: ropes without events.
    """

    graph: Graph
    poses: Poses
    gravity: float  # [m/s2]
    clamped: bool
    at_rest: bool
    calm: frozenset[str]


@dataclass(frozen=True)
class LawOutput:
    """Output of a force at an instant; kinetic + potential + stored - work + heat stays constant."""

    wrenches: list[Array] = field(default_factory=list)  # (6,) on each end's body about its tree's point
    effort: Scalar = 0.0  # along its joint [N or N m]
    heat: Scalar = 0.0  # [W]
    work: Scalar = 0.0  # [W] that it brings in
    stored: Scalar = 0.0  # [J]
    guards: list[Scalar] = field(default_factory=list)
    shown: list[Scalar] = field(default_factory=list)
    turned: list[Scalar] = field(default_factory=list)  # its angles, with their rates (`multibody.continuous_angles`)
    turning: list[Scalar] = field(default_factory=list)


class ForceLaw(ABC, Generic[F]):
    """A row of the force table; `kind`: of its numbers in P; `works`: it does external work; `timed`: it depends on
    time; `initial`: its guards set the states of the initial pose without events."""

    kind = "force"
    works = False
    timed = False
    initial = True

    def check(self, f: F) -> None:
        """Raises KernelError for a description that cannot be."""
        return  # of most kinds, all can

    def within(self, f: F, setting: Setting) -> ForceLaw[F]:
        """The law of a force that is part of a scene."""
        return self

    def signal(self, f: F) -> InputSignal | None:
        """What commands or histories change."""
        signal: InputSignal | None = getattr(f, "signal", None)
        return signal

    def shape(self, f: F) -> Hashable:
        """All properties that its code branches on."""
        return None

    @abstractmethod
    def numbers(self, f: F, poses: Poses) -> list[float]:
        """Its numbers in P, discrete states included."""

    @abstractmethod
    def answer(self, f: F, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        """The law as a function of its numbers p, bodies (21,) at its ends (see `attachment`), signal (value, rate),
        joint (q, v), and time t [s] if timed; of f only what `shape` includes."""

    def angles(self, f: F) -> int:
        """Number of angles counted over turns; `answer` then receives their integrals as `counted`."""
        return 0

    def turns(self, f: F, poses: Poses) -> tuple[str, str, Array] | None:
        """The bodies of its angles and their world axis, if counted before the start as well."""
        raise KernelError(f"{type(f).__name__.lower()} '{f.name}': its law has angles and no 'turns'; give it one")

    def guards(self, f: F) -> tuple[str, ...]:
        """Names of its guards, in the order of `LawOutput.guards`."""
        return ()

    def switch(self, f: F, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        """Change discrete states in p after a guard has fallen; returns the event with a value. Coordinates and
        velocities stay; released elastic energy becomes its heat."""
        raise KernelError(f"{type(f).__name__.lower()} '{f.name}': its law has guards and no 'switch'; give it one")

    def shows(self, f: F) -> list[SampledQuantity]:
        """Its sampled quantities, in the order of `LawOutput.shown`."""
        return []

    def demand(self, f: F, field_: str, good: bool, message: str) -> None:
        """Raises KernelError about a field."""
        if not good:
            raise KernelError(f"{item_word(f)} '{f.name}': {field_} {message}")


class LawBreakdown(KernelError):
    """A law outside its domain: name and reason; the simulation adds the time."""

    def __init__(self, who: str, why: str) -> None:
        super().__init__(f"{who}: {why}")
        self.who, self.why = who, why

    def at(self, t: float) -> KernelError:
        """The sentence with its time [s]."""
        return KernelError(f"{self.who} at {t:.3f} s: {self.why}")


def attachment(body: Array, p_BX: Array, label: str = "X") -> tuple[Array, Array, Array]:
    """Place from the tree's point, place in the world, velocity of a body-fixed point X.

    body: (21,) R_WB row-major, the tree's point o, r from o to the body's origin, twist V; label: its name in print.
    """
    R, o, r, V = np.reshape(body[:9], (3, 3)), body[9:12], body[12:15], body[15:21]
    x = named(f"r{label}", r + R @ p_BX)
    return x, named(f"p{label}", x + o), named(f"v{label}", V[3:] + cross(V[:3], x))


def wrench(x: Array, force: Array, moment: Array | None = None) -> Array:
    """Wrench (6,) about the tree's point of a force at x from it."""
    turning = cross(x, force)
    return join(turning if moment is None else turning + moment, force)
