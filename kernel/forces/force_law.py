"""What the kernel asks of a kind of force: the columns of the force table, with the defaults of a plain force.

A kind says where it acts, which numbers it keeps in P and what it answers at one instant.  Its text is traced once per
shape and shared by all forces of that shape.  Discrete states are numbers in P: frozen during a step, changed by
`switch` at the located event when one of its guards falls below zero (see `forces.laws`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from heavylift.kernel.algebra.spatial import cross, join
from heavylift.kernel.description.forces import Signal
from heavylift.kernel.errors import KernelError

if TYPE_CHECKING:
    from heavylift.kernel.multibody.graph import Graph

__all__ = ["Answer", "Ended", "ForceLaw", "Poses", "Shown", "wrench"]

Poses = Callable[[str], tuple[Any, Any]]  # body -> R_WB (3, 3), p_WB (3,) at the start
Shown = tuple[str, str, str]  # topic, name, unit of a recorded quantity


@dataclass(frozen=True)
class Answer:
    """What a force does at one instant; the balance kinetic + potential + stored - work + heat stays constant."""

    wrenches: list[Any] = field(default_factory=list)  # (6,) on each end's body about its tree's point
    effort: Any = 0.0  # along its joint [N or N m]
    heat: Any = 0.0  # [W]
    work: Any = 0.0  # [W] that it brings in
    stored: Any = 0.0  # [J]
    guards: list[Any] = field(default_factory=list)
    shown: list[Any] = field(default_factory=list)
    turned: list[Any] = field(default_factory=list)  # its angles, with their rates (`multibody.continuous_angles`)
    turning: list[Any] = field(default_factory=list)


class ForceLaw(ABC):
    """One row of the force table; `works`: it brings work in from outside; `timed`: it looks at the clock."""

    works = False
    timed = False

    def check(self, f: Any) -> None:
        """Raises KernelError for a description that cannot be."""
        return  # of most kinds, all can

    def between(self, f: Any, graph: Graph, poses: Poses) -> ForceLaw:
        """The law for a force between bodies whose joints are known."""
        return self

    def signal(self, f: Any) -> Signal | None:
        """What commands or histories change."""
        return None

    def shape(self, f: Any) -> Hashable:
        """Everything that its text branches on."""
        return None

    @abstractmethod
    def numbers(self, f: Any, poses: Poses) -> list[float]:
        """Its numbers in P, discrete states included."""

    @abstractmethod
    def answer(self, f: Any, p: Any, ends: list[Any], signal: Any, joint: Any, t: Any) -> Answer:
        """The law, of its numbers p, its ends' bodies (21,) (see `laws.attachment`), signal (value, rate), joint
        (q, v), time t [s] of the run if it is timed; from f it may take what `shape` tells."""

    def angles(self, f: Any) -> int:
        """How many angles it counts over their turns; `answer` is then given their integrals as `counted`, too."""
        return 0

    def turns(self, f: Any, poses: Poses) -> tuple[str, str, Any] | None:
        """Which body turns against which in its angles, and about which axis in the world, if before the start, too."""
        raise KernelError(f"{type(f).__name__.lower()} '{f.name}': its law has angles and no 'turns'; give it one")

    def guards(self, f: Any) -> int:
        """How many guards it has."""
        return 0

    def switch(self, f: Any, p: np.ndarray, guard: int, shown: np.ndarray) -> tuple[str, float]:
        """Change its discrete states in p after a guard has fallen; what happened, with a value."""
        raise KernelError(f"{type(f).__name__.lower()} '{f.name}': its law has guards and no 'switch'; give it one")

    def shows(self, f: Any) -> list[Shown]:
        """What samples show of it, in the order of `Answer.shown`."""
        return []

    def demand(self, f: Any, field_: str, good: bool, told: str) -> None:
        """Raises KernelError about a field."""
        if not good:
            raise KernelError(f"{type(f).__name__.lower()} '{f.name}': {field_} {told}")


class Ended(KernelError):
    """A law that has come to where it means nothing: who, and why; the time is added by the simulation."""

    def __init__(self, who: str, why: str) -> None:
        super().__init__(f"{who}: {why}")
        self.who, self.why = who, why

    def at(self, t: float) -> KernelError:
        """The sentence with its time [s]."""
        return KernelError(f"{self.who} at {t:.3f} s: {self.why}")


def wrench(x: Any, force: Any, moment: Any = None) -> Any:
    """(6,) wrench about the tree's point of a force at x from it."""
    turning = cross(x, force)
    return join(turning if moment is None else turning + moment, force)
