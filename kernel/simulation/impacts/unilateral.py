"""What pushes or pulls one way only, as an event sees it: slots of contacts, and rigid ropes.

Both are three rows, normal first, with -1 for a tangent that does not exist, so that the solver treats a rope as a
contact without friction whose gap is its slack.  Their states are numbers of P, written here and nowhere else.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.constraints.contact.contact_points import DEPTH, Site, SlotAt
from heavylift.kernel.constraints.contact.pairs import HELD
from heavylift.kernel.constraints.rigid_ropes import TOUCHING, RigidAt

if TYPE_CHECKING:
    from heavylift.kernel.model.program import Program

KINDS = ("touch", "press", "grip", "leave")  # guards of contacts
BEGIN = 1e-7  # [m/s] back against a slip that begins

Numbers = Callable[[str, str], np.ndarray]


@dataclass(frozen=True)
class Unilateral(ABC):
    """`numbers` of P; `rows` among all, normal first; `guard` that falls with its force."""

    name: str
    numbers: Numbers
    rows: list[int]
    guard: int

    label = ""

    @property
    def mu(self) -> float:
        """Coulomb's coefficient."""
        return 0.0

    @property
    def restitution(self) -> float:
        """Newton's coefficient."""
        return 0.0

    @property
    @abstractmethod
    def on(self) -> bool:
        """Whether it may push."""

    @abstractmethod
    def let_go(self) -> None:
        """From here on it does not push."""

    @abstractmethod
    def keep(self, stick: bool, moves: bool, slips: bool, share: np.ndarray, u: np.ndarray, prior: np.ndarray) -> None:
        """It pushes: sticking, or at the limit of friction along u (2,), moving already or not, free to slip away or
        held by others; `share` of friction (2,); `prior` (3,) force that it has."""


@dataclass(frozen=True)
class Slot(Unilateral):
    """One place where two bodies touch; `name`: of its contact, `key`: its own."""

    site: Site
    key: str

    label = "contact"

    @property
    def mu(self) -> float:
        return self.site.contact.mu

    @property
    def restitution(self) -> float:
        return self.site.contact.restitution

    @property
    def state(self) -> np.ndarray:
        """What P holds of it."""
        return self.numbers("slot", self.key)

    @property
    def on(self) -> bool:
        return bool(self.state[SlotAt.ON] > 0.0)

    @property
    def slips(self) -> bool:
        return bool(self.state[SlotAt.SLIPS] > 0.0)

    def take(self, candidate: int, held: list[float]) -> None:
        """From here on it is the place of a candidate."""
        self.state[:HELD] = held
        self.state[SlotAt.ON], self.state[SlotAt.CANDIDATE] = 1.0, candidate
        self.numbers("held", self.name)[candidate] = 1.0

    def grip(self) -> None:
        """Stick, until the solver says more."""
        self.state[SlotAt.STICK], self.state[SlotAt.SOFT], self.state[SlotAt.U] = 1.0, 1.0, 0.0
        self.state[SlotAt.PRIOR] = 0.0

    def slide(self) -> None:
        """Along the speed that it has, until the solver says more."""
        self.state[SlotAt.STICK] = 0.0

    def let_go(self) -> None:
        self.numbers("held", self.name)[int(self.state[SlotAt.CANDIDATE])] = 0.0
        self.state[SlotAt.ON], self.state[SlotAt.CANDIDATE], self.state[SlotAt.SLIPS] = 0.0, -1.0, 0.0
        self.state[SlotAt.PRIOR] = 0.0

    def keep(self, stick: bool, moves: bool, slips: bool, share: np.ndarray, u: np.ndarray, prior: np.ndarray) -> None:
        h = self.state
        h[SlotAt.SLIPS] = float(slips)
        h[SlotAt.STICK] = float(stick or self.mu == 0.0)
        h[SlotAt.BACK] = DEPTH if moves else BEGIN
        h[SlotAt.SOFT], h[SlotAt.U] = 1.0 / share**2, 0.0 if stick else u
        h[SlotAt.PRIOR] = prior


@dataclass(frozen=True)
class UnilateralRope(Unilateral):
    """A rigid rope."""

    label = "rope"

    @property
    def _state(self) -> np.ndarray:
        return self.numbers("rigid", self.name)

    @property
    def on(self) -> bool:
        return bool(self._state[RigidAt.TAUT] > 0.0)

    def take(self, slack: float) -> None:
        """Taut from here on, if it is hooked and `slack` [m] is used up."""
        if self._state[RigidAt.HOOKED] > 0.0 and slack < TOUCHING:
            self._state[RigidAt.TAUT] = 1.0

    def let_go(self) -> None:
        self._state[RigidAt.TAUT] = 0.0

    def keep(self, stick: bool, moves: bool, slips: bool, share: np.ndarray, u: np.ndarray, prior: np.ndarray) -> None:
        """It is taut already."""


def ropes_of(program: Program, numbers: Numbers) -> list[UnilateralRope]:
    """All rigid ropes, in order."""
    row = len(program.constraints.of)
    guard = first_guard(program, "rigid")
    return [
        UnilateralRope(r.name, numbers, [row + i, -1, -1], guard + i) for i, r in enumerate(program.system.rigid_ropes)
    ]


def slots_of(program: Program, numbers: Numbers) -> list[Slot]:
    """All slots of contacts, in order."""
    out: list[Slot] = []
    row, press = len(program.constraints) - len(program.contacts.held), first_guard(program, "press")
    for s in program.contacts.sites:
        for k in range(s.pair.slots):
            rows = [*range(row, row + s.per_slot), *[-1] * (3 - s.per_slot)]
            out.append(Slot(s.contact.name, numbers, rows, press, s, f"{s.contact.name}/{k}"))
            row, press = row + s.per_slot, press + len(KINDS[1:])
    return out


def first_guard(program: Program, kind: str) -> int:
    """Number of the first guard of a kind, -1 if there is none."""
    return next((i for i, (what, _) in enumerate(program.guards) if what == kind), -1)
