"""Unilateral constraints at an event: contact slots (touching points) and rigid ropes.

Slots and ropes have three rows each, normal first, with -1 for a missing tangent: for the solver a rope is a contact
without friction whose gap is the slack. The states are numbers of P, which only this module writes.

The module also assigns touching candidates to slots, and frees the slots of places that have left their face. A
candidate touches if its witness is at most `TOUCH` at an event; if slots are short, the fastest candidates get them.
New contacts stick until the solver decides.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.algebra.spatial import exact
from heavylift.kernel.compiler.symbol import Array
from heavylift.kernel.constraints.contact.contact_points import DEPTH, LEAVE, RESTING, Site, SlotAt
from heavylift.kernel.constraints.contact.frames import ContactFrame
from heavylift.kernel.constraints.contact.pairs import HELD
from heavylift.kernel.constraints.row_structure import TOUCHING, RigidAt
from heavylift.kernel.errors import KernelError

if TYPE_CHECKING:
    from heavylift.kernel.model.program import Program

KINDS = ("touch", "press", "grip", "leave")  # guards of contacts
BEGIN = 1e-7  # [m/s] back against a slip that begins

Numbers = Callable[[str, str], np.ndarray]


@dataclass(frozen=True)
class Unilateral(ABC):
    """A unilateral constraint: a contact slot (place for a touching point) or a rigid rope."""

    name: str
    numbers: Numbers  # its parameters
    rows: list[int]  # row numbers, normal first
    guard: int  # number of the guard of its force

    label = ""

    @property
    def mu(self) -> float:
        """Coulomb's coefficient of friction of the constraint."""
        return 0.0

    @property
    def restitution(self) -> float:
        """Newton's coefficient of restitution of the constraint."""
        return 0.0

    @property
    @abstractmethod
    def on(self) -> bool:
        """Whether the constraint is active: the contact may push, or the rope may pull."""

    @abstractmethod
    def let_go(self) -> None:
        """Set the constraint inactive: the contact is open, or the rope slack."""

    @abstractmethod
    def keep(self, stick: bool, moves: bool, slips: bool, share: np.ndarray, u: np.ndarray, prior: np.ndarray) -> None:
        """Keep the constraint active, sticking or at the friction limit along u (2,).

        `slips`: whether it slides; `share`: shares of friction (2,); `prior`: reference force (3,).
        """


@dataclass(frozen=True)
class Slot(Unilateral):
    """A contact slot, which holds the state of one point where two bodies touch."""

    site: Site
    key: str  # name of the slot; `name` is that of the contact

    label = "contact"

    @property
    def mu(self) -> float:
        return self.site.contact.mu

    @property
    def restitution(self) -> float:
        return self.site.contact.restitution

    @property
    def state(self) -> np.ndarray:
        """The parameters of the contact slot, as a view of the parameter block P."""
        return self.numbers("slot", self.key)

    @property
    def on(self) -> bool:
        return bool(self.state[SlotAt.ON] > 0.0)

    @property
    def slips(self) -> bool:
        return bool(self.state[SlotAt.SLIPS] > 0.0)

    def take(self, candidate: int, held: list[float]) -> None:
        """Assign the touching point `candidate` to this slot; `held`: the numbers of its contact frame."""
        self.state[:HELD] = held
        self.state[SlotAt.ON], self.state[SlotAt.CANDIDATE] = 1.0, candidate
        self.numbers("held", self.name)[candidate] = 1.0

    def grip(self) -> None:
        """Mark the contact slot as sticking until the solver decides."""
        self.state[SlotAt.STICK], self.state[SlotAt.SOFT], self.state[SlotAt.U] = 1.0, 1.0, 0.0
        self.state[SlotAt.PRIOR] = 0.0

    def slide(self) -> None:
        """Mark the contact slot as sliding along its velocity until the solver decides."""
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
    """A rigid rope as a unilateral constraint."""

    label = "rope"

    @property
    def _state(self) -> np.ndarray:
        return self.numbers("rigid", self.name)

    @property
    def on(self) -> bool:
        return bool(self._state[RigidAt.TAUT] > 0.0)

    def take(self, slack: float) -> None:
        """Mark the rigid rope as taut if it is hooked and no `slack` [m] is left."""
        if self._state[RigidAt.HOOKED] > 0.0 and slack < TOUCHING:
            self._state[RigidAt.TAUT] = 1.0

    def let_go(self) -> None:
        self._state[RigidAt.TAUT] = 0.0

    def keep(self, stick: bool, moves: bool, slips: bool, share: np.ndarray, u: np.ndarray, prior: np.ndarray) -> None:
        """Do nothing: a rigid rope has no friction, so a taut rope has no further state."""


def ropes_of(program: "Program", numbers: Numbers) -> list[UnilateralRope]:
    """Return all rigid ropes as unilateral constraints, in their order."""
    row = len(program.constraints.of)
    guard = first_guard(program, "rigid")
    return [
        UnilateralRope(r.name, numbers, [row + i, -1, -1], guard + i) for i, r in enumerate(program.system.rigid_ropes)
    ]


def slots_of(program: "Program", numbers: Numbers) -> list[Slot]:
    """Return all contact slots in their order."""
    out: list[Slot] = []
    row, press = len(program.constraints) - len(program.contacts.held), first_guard(program, "press")
    for s in program.contacts.sites:
        for k in range(s.pair.slots):
            rows = [*range(row, row + s.per_slot), *[-1] * (3 - s.per_slot)]
            out.append(Slot(s.contact.name, numbers, rows, press, s, f"{s.contact.name}/{k}"))
            row, press = row + s.per_slot, press + len(KINDS[1:])
    return out


def first_guard(program: "Program", kind: str) -> int:
    """Return the index of the first guard (event function) of a kind in a program; -1 if there is none."""
    return next((i for i, (what, _) in enumerate(program.guards) if what == kind), -1)


TOUCH = 1e-8  # [m] gap of what touches in the same instant
SAME = 1e-7  # [m] and [rad] between candidates that are one place
INSIDE = 1e-6  # [m] by which shapes may overlap at the start

Ends = dict[int, Array]  # numbers of the bodies


def check_start(sites: list[Site], numbers: Numbers, ends: Ends) -> None:
    """Raise KernelError if shapes with contact overlap at the start."""
    for s in sites:
        deep = min(gap for gap, _ in s.pair.watch(*_shapes(s, numbers, ends)))
        if deep < -INSIDE:
            raise KernelError(
                f"contact '{s.contact.name}' at 0.000 s: '{s.contact.a.body}' lies {-deep * 1e3:.3g} "
                f"mm inside '{s.contact.b.body}'; move them apart"
            )


def touch(sites: list[Site], slots: list[Slot], numbers: Numbers, ends: Ends, fell: set[int]) -> None:
    """Occupy a contact slot for each point where shapes touch now; free the slots of points that have left their face.

    The fastest points come first. All contacts stick at first. `fell`: candidates, counted through all sites, whose
    guards report a touch. At the end of an edge, round-off may make another candidate touch here than the one of the
    guard.
    """
    first = 0
    for s in sites:
        shapes, own = _shapes(s, numbers, ends), [x for x in slots if x.site is s]
        places: list[tuple[ContactFrame, Slot]] = []
        for x in own:
            if x.on and _within(f := _frame(s, x.state, ends), x.state):
                places.append((f, x))
            elif x.on:
                x.let_go()
        held = numbers("held", s.contact.name)
        found = enumerate(s.pair.watch(*shapes))
        nearing = sorted((rate, i) for i, (gap, rate) in found if gap <= TOUCH or first + i in fell)
        first += s.pair.candidates
        for rate, i in nearing:
            h = [float(x) for x in s.pair.hold(i, *shapes)]
            f = _frame(s, np.array(h), ends)
            if held[i] > 0.0 or not _within(f, np.array(h)) or not _adds(f, places):
                continue
            spare = next((x for x in own if not x.on), None)
            if spare is None and rate < -RESTING and (spare := _second(places)):
                spare.let_go()
                places = [(g, x) for g, x in places if x is not spare]
            if spare:
                spare.take(i, h)
                places.append((f, spare))
    for x in slots:
        if x.on:
            x.grip()


def _shapes(s: Site, numbers: Numbers, ends: Ends) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    p = numbers("shapes", s.contact.name)
    A, B = (exact(ends[i]) for i in s.bodies)
    return exact(p[: s.first]), exact(p[s.first :]), A, B


def _frame(s: Site, h: np.ndarray, ends: Ends) -> ContactFrame:
    A, B = (exact(ends[i]) for i in s.bodies)
    return s.pair.frame(exact(h[:HELD]), A, B)


def _within(f: ContactFrame, h: np.ndarray) -> bool:
    """Return whether a slot's place lies on its face or edges."""
    return bool((np.abs(f.along) <= h[HELD - 2 : HELD] + LEAVE).all())


def _adds(f: ContactFrame, places: list[tuple[ContactFrame, Slot]]) -> bool:
    """Return whether a candidate constrains a new direction. At a corner on an edge, many candidates lie at one place,
    and two of them constrain it fully."""
    here = [g for g, _ in places if _near(f, g)]
    return len(here) < 2 and all(np.abs(f.F[0] - g.F[0]).max() > SAME for g in here)


def _second(places: list[tuple[ContactFrame, Slot]]) -> Slot | None:
    """Return a reassignable slot, one that constrains a second direction at some place; None if there is none."""
    found = (x for k, (f, x) in enumerate(places) if any(_near(f, g) for g, _ in places[:k]))
    return next(found, None)


def _near(f: ContactFrame, g: ContactFrame) -> bool:
    return bool(np.abs(f.x - g.x).max() < SAME)
