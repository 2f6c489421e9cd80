"""Interface of a kind of force: the methods that every entry of the force table has, with defaults for simple forces.

A kind states where it acts, which numbers it keeps in P and its output at one instant. Its code is traced once per
shape and shared by all forces of that shape. Discrete states (hooked, taut, closed, stick) are numbers in P, frozen
during a step; *guards* are scalars that are positive while these states hold. When a guard becomes negative, `switch`
changes the state at the located event. So no clamp ever acts inside a step, and the integrators keep their order. Each
law also gives the power that it turns into heat or takes from a motor, which the energy balance integrates.
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
    """A quantity of a force that is sampled: topic ("" if not recorded), name, unit, group of columns."""

    topic: str
    name: str
    unit: str
    column: str = "shown"


@dataclass(frozen=True)
class Setting:
    """Properties of a scene and a simulation on which a force law may depend."""

    graph: Graph
    poses: Poses
    gravity: float  # [m/s2]
    clamped: bool  # one-sided laws stay one-sided beyond an event, in the part of a step that is discarded
    at_rest: bool  # only equilibria are sought
    calm: frozenset[str]  # names of ropes without events


@dataclass(frozen=True)
class LawOutput:
    """Output of a force law at one instant: wrenches, effort, energies, guards and sampled values.

    Over all laws, kinetic + potential + stored energy - work + heat stays constant.
    """

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
    """Base class of the force laws, one for each kind of force."""

    kind = "force"  # key of its numbers in the parameter block P
    works = False  # whether it does external work
    timed = False  # whether it depends on time
    initial = True  # whether its guards set the discrete states of the initial pose without events

    def check(self, f: F) -> None:
        """Raise KernelError if the description of force f is invalid."""
        return  # of most kinds, all can

    def within(self, f: F, setting: Setting) -> ForceLaw[F]:
        """Return the force law of f, adapted to the properties of a scene and a simulation."""
        return self

    def signal(self, f: F) -> InputSignal | None:
        """Return the force's signal, which commands or time histories change; None if the force has none."""
        signal: InputSignal | None = getattr(f, "signal", None)
        return signal

    def shape(self, f: F) -> Hashable:
        """Return all properties of force f on which the code of the law branches; forces of equal shape share code."""
        return None

    @abstractmethod
    def numbers(self, f: F, poses: Poses) -> list[float]:
        """Return the parameters of force f in the parameter block P, including its discrete states."""

    @abstractmethod
    def answer(self, f: F, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        """Return the output of the force law at one instant: wrenches, heat, guards.

        `p`: its numbers; `ends`: the bodies (21,) at its ends (see `attachment`); `signal`: value and rate; `joint`: q
        and v; `t`: time [s] if the law is timed. Only those properties of f may be used that `shape` includes.
        """

    def angles(self, f: F) -> int:
        """Return how many of the law's angles are counted over full turns; `answer` receives them as `counted`."""
        return 0

    def turns(self, f: F, poses: Poses) -> tuple[str, str, Array] | None:
        """Return the bodies and world axis of the rotation that the law counts; None if initial turns do not count."""
        raise KernelError(
            f"{type(f).__name__.lower()} '{f.name}': its law counts angles but has no method 'turns'; define one"
        )

    def guards(self, f: F) -> tuple[str, ...]:
        """Return the names of the force law's guards (event functions), in the order of `LawOutput.guards`."""
        return ()

    def switch(self, f: F, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        """Change the law's discrete states in p after a guard became negative; return `what` and `value` of the change.

        Coordinates and velocities do not change; released elastic energy becomes heat of the law.
        """
        raise KernelError(
            f"{type(f).__name__.lower()} '{f.name}': its law has guards but no method 'switch'; define one"
        )

    def shows(self, f: F) -> list[SampledQuantity]:
        """Return the quantities of the force law that are sampled, in the order of `LawOutput.shown`."""
        return []

    def demand(self, f: F, field_: str, good: bool, message: str) -> None:
        """Raise KernelError with a message about a field of force f unless the condition `good` is true."""
        if not good:
            raise KernelError(f"{item_word(f)} '{f.name}': {field_} {message}")


class LawBreakdown(KernelError):
    """Raised for a force law that has left its domain of validity: name and reason; the simulation adds the time."""

    def __init__(self, who: str, why: str) -> None:
        super().__init__(f"{who}: {why}")
        self.who, self.why = who, why

    def at(self, t: float) -> KernelError:
        """Return this error as a KernelError with its time [s]."""
        return KernelError(f"{self.who} at {t:.3f} s: {self.why}")


def attachment(body: Array, p_BX: Array, label: str = "X") -> tuple[Array, Array, Array]:
    """Return, for a point X fixed on a body, its position relative to the tree's reference point, its position in the
    world, and its velocity.

    body: (21,) R_WB row-major, the tree's point o, r from o to the body's origin, twist V; label: name of the point in
    print.
    """
    R, o, r, V = np.reshape(body[:9], (3, 3)), body[9:12], body[12:15], body[15:21]
    x = named(f"r{label}", r + R @ p_BX)
    return x, named(f"p{label}", x + o), named(f"v{label}", V[3:] + cross(V[:3], x))


def wrench(x: Array, force: Array, moment: Array | None = None) -> Array:
    """Return the wrench (6,) about the tree's reference point of a force that acts at x relative to this point."""
    turning = cross(x, force)
    return join(turning if moment is None else turning + moment, force)
