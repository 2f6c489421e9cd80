"""The next set of contacts at an event: who touches, impulses first, then forces.

Everything that touches at that instant is solved together (Newton's restitution per contact, so that three equal balls
in a row part as -1/3, 2/3, 2/3; a gap between them, however small, makes two impacts and 0, 0, 1).  If restitution
would raise the energy, as Newton's law can with friction (Kane 1984), the impact is inelastic.  Rebounds slower than
`CAPTURE` end there: the infinitely many bounces that remain of a Zeno sequence are lower than a nanometre.  Where no
force fulfils the laws (Painleve 1895) the run is refused by name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import KernelError
from ..evaluation import Evaluation
from ..switching import StateEvent
from .complementarity import solve
from .condensed import Condensed, part
from .coulomb import Contacts, Friction, settle
from .pairs import HELD
from .slots import DEPTH, LEAVE, RESTING, Site, SlotAt

if TYPE_CHECKING:
    from ..rate import Program

__all__ = ["KINDS", "Act", "ContactSets"]

KINDS = ("touch", "press", "grip", "leave")  # guards of contacts
TOUCH = 1e-8  # [m] gap of what touches in the same instant
INSIDE = 1e-6  # [m] by which shapes may overlap at the start
BEGIN = 1e-7  # [m/s] back against a slip that begins
CAPTURE = 1e-4  # [m/s] slowest rebound
LIGHT = 1e-7  # part of the largest normal force below which a contact only touches
SMALL = 1e-9  # relative size of work that is round-off

Survey = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Act:
    """What the solver may do to a simulation: `survey` -> matrix, speeds, free accelerations of all rows; `kick`."""

    survey: Callable[[], Survey]
    kick: Callable[[np.ndarray], None]


@dataclass(frozen=True)
class _Slot:
    """A slot with the numbers of its rows (normal first) among all, and of the guard of its force."""

    site: Site
    name: str
    rows: list[int]
    press: int


class ContactSets:
    """Takes touching candidates into slots and decides their states in P."""

    def __init__(self, program: Program, P: np.ndarray) -> None:
        self._program, self._P, self._at = program, P, program.parameters.at
        self._slots: list[_Slot] = []
        row = len(program.constraints) - len(program.contacts.held)
        self._loops = list(range(row))
        press = next((i for i, (kind, _) in enumerate(program.guards) if kind == "press"), -1)
        for s in program.contacts.sites:
            for k in range(s.pair.slots):
                self._slots.append(_Slot(s, f"{s.contact.name}/{k}", list(range(row, row + s.per_slot)), press))
                row, press = row + s.per_slot, press + len(KINDS[1:])

    def _numbers(self, kind: str, name: str) -> np.ndarray:
        return self._P[self._at[kind, name]]

    def _on(self) -> list[_Slot]:
        return [s for s in self._slots if self._numbers("slot", s.name)[SlotAt.ON] > 0.0]

    def resolve(
        self, fallen: list[int], t: float, local: float, y: np.ndarray, act: Act
    ) -> tuple[list[StateEvent], dict[str, float]]:
        """Events, and heat per contact [J], at time t [s] of the run, where these guards have fallen.

        Raises KernelError where nothing fits.
        """
        before = self._states()
        self._take(Evaluation(self._program, local, y, self._P, local, forces=False).ends)
        events, heat = self._impact(t, act)
        self._force(t, act, [s for s in self._slots if s.press in fallen])
        after = self._states()
        for name, (closed, slides) in after.items():
            was_closed, slid = before[name]
            if closed != was_closed:
                events.append(StateEvent(name, "closed" if closed else "open", 0.0))
            elif closed and slides != slid:
                events.append(StateEvent(name, "slip" if slides else "stick", 0.0))
        return events, heat

    def check_start(self, y: np.ndarray) -> None:
        """Raises KernelError if shapes overlap at the start."""
        ends = Evaluation(self._program, 0.0, y, self._P, 0.0, forces=False).ends
        for s in self._program.contacts.sites:
            deep = min(gap for gap, _ in self._witnesses(s, ends))
            if deep < -INSIDE:
                raise KernelError(
                    f"contact '{s.contact.name}' at 0.000 s: '{s.contact.a.body}' lies {-deep * 1e3:.3g} mm inside "
                    f"of '{s.contact.b.body}'; move them apart"
                )

    def _states(self) -> dict[str, tuple[bool, bool]]:
        """Per contact whether it is closed and whether it slides."""
        out = {s.contact.name: (False, False) for s in self._program.contacts.sites}
        for s in self._on():
            name = s.site.contact.name
            slides = self._numbers("slot", s.name)[SlotAt.STICK] == 0.0 and s.site.contact.mu > 0.0
            out[name] = (True, out[name][1] or bool(slides))
        return out

    # ---- who touches ---------------------------------------------------------------------------------------

    def _shapes(self, s: Site, ends: dict[int, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        p = self._numbers("shapes", s.contact.name)
        A, B = (np.array(ends[i], float) for i in s.bodies)
        return p[: s.first], p[s.first :], A, B

    def _witnesses(self, s: Site, ends: dict[int, Any]) -> list[Any]:
        return s.pair.watch(*self._shapes(s, ends))

    def _take(self, ends: dict[int, Any]) -> None:
        """Free the slots whose place has left its face; give free ones to what touches, fastest first.  All stick."""
        for s in self._program.contacts.sites:
            shapes, own = self._shapes(s, ends), [x for x in self._slots if x.site is s]
            for x in own:
                h = self._numbers("slot", x.name)
                if h[SlotAt.ON] > 0.0 and _beyond(s, h, ends):
                    self._free(x)
            held = self._numbers("held", s.contact.name)
            nearing = sorted((rate, i) for i, (gap, rate) in enumerate(s.pair.watch(*shapes)) if gap <= TOUCH)
            for _, i in nearing:
                spare = next((x for x in own if self._numbers("slot", x.name)[SlotAt.ON] == 0.0), None)
                if held[i] > 0.0 or spare is None:
                    continue
                h = self._numbers("slot", spare.name)
                h[:HELD] = s.pair.hold(i, *shapes)
                if not _beyond(s, h, ends):
                    h[SlotAt.ON], h[SlotAt.CANDIDATE], held[i] = 1.0, i, 1.0
        for x in self._on():
            h = self._numbers("slot", x.name)
            h[SlotAt.STICK], h[SlotAt.SOFT], h[SlotAt.U] = 1.0, 1.0, 0.0

    def _free(self, x: _Slot) -> None:
        h = self._numbers("slot", x.name)
        self._numbers("held", x.site.contact.name)[int(h[SlotAt.CANDIDATE])] = 0.0
        h[SlotAt.ON], h[SlotAt.CANDIDATE] = 0.0, -1.0

    # ---- impulses, then forces -----------------------------------------------------------------------------

    def _impact(self, t: float, act: Act) -> tuple[list[StateEvent], dict[str, float]]:
        """Apply the impulses of what approaches; free what flies off."""
        on = self._on()
        A, speed, _ = act.survey()
        rows = _rows(on)
        u = part(speed, rows)
        heat: dict[str, float] = {}
        events: list[StateEvent] = []
        if on and u[::3].min() < -RESTING:
            problem = Condensed(A, speed, rows, self._loops)
            bounce = np.array([s.site.contact.restitution for s in on]) * np.maximum(-u[::3], 0.0)
            bounce[bounce < CAPTURE] = 0.0
            x = self._impulses(problem, on, bounce, t)
            if bounce.any() and _work(problem, u, x) > SMALL * float(np.abs(x * u).sum()):
                x = self._impulses(problem, on, 0.0 * bounce, t)
            slow = {i for i, w in enumerate(problem.after(x)[::3]) if RESTING < w < CAPTURE}
            x = x + self._held(problem, on, x, slow)
            after = problem.after(x)
            act.kick(problem.impulses(x, len(speed)))
            for name in dict.fromkeys(s.site.contact.name for s in on):
                own = [i for i, s in enumerate(on) if s.site.contact.name == name]
                parts = [3 * i + k for i in own for k in range(3)]
                push = sum(float(x[3 * i]) for i in own)
                heat[name] = -sum(float(x[k] * 0.5 * (u[k] + after[k])) for k in parts)
                if push > 0.0 and min(u[3 * i] for i in own) < -RESTING:
                    events.append(StateEvent(name, "impact", push))
                slow |= {i for i in own if on[i].site.contact.restitution > 0.0 > u[3 * i] + RESTING and not bounce[i]}
                if slow & set(own):
                    events.append(StateEvent(name, "captured", push))
            u = after
        for s, speed_n in zip(on, u[::3], strict=True):
            if speed_n > RESTING:
                self._free(s)
        return events, heat

    def _impulses(self, problem: Condensed, on: list[_Slot], bounce: np.ndarray, t: float) -> np.ndarray:
        b = problem.b.copy()
        b[::3] -= bounce
        return self._settled(Contacts(problem.A, b, _friction(on), np.zeros((len(on), 2))), on, t).x

    def _held(self, problem: Condensed, on: list[_Slot], x: np.ndarray, slow: set[int]) -> np.ndarray:
        """Impulses that end the motion of `slow` contacts together with those that push and stick."""
        extra = np.zeros(len(x))
        if slow:
            after = problem.after(x)
            rows = []
            for i, s in enumerate(on):
                sticks = s.site.contact.mu > 0.0 and float(np.hypot(*after[3 * i + 1 : 3 * i + 3])) < CAPTURE
                if i in slow or x[3 * i] > 0.0:
                    rows += [3 * i, 3 * i + 1, 3 * i + 2] if sticks else [3 * i]
            free = np.full(len(rows), np.inf)
            extra[rows] = solve(problem.A[np.ix_(rows, rows)], after[rows], -free, free).x
        return extra

    def _force(self, t: float, act: Act, spent: list[_Slot]) -> None:
        """States of what stays in touch, from the accelerations.

        Where forces are not unique, they may be found otherwise than in the evaluation, in which those of `spent`
        slots have vanished: such a contact is let go if the others can do without it.
        """
        on, (A, speed, free) = self._on(), act.survey()
        others = [s for s in on if s not in spent]
        f = self._forces(A, speed, free, others, t) if len(others) < len(on) else None
        if f is not None and _holds(A, free, on, others, f, self._loops):
            for s in on:
                if s not in others:
                    self._free(s)
            on = others
        else:
            f = self._forces(A, speed, free, on, t)
        for i, s in enumerate(on):
            h = self._numbers("slot", s.name)
            if f.push[i] and f.x[3 * i] > LIGHT * f.x[::3].max():
                h[SlotAt.STICK] = float(f.stick[i] or s.site.contact.mu == 0.0)
                h[SlotAt.BACK] = DEPTH if _moves(speed, s) else BEGIN
                h[SlotAt.SOFT], h[SlotAt.U] = 1.0 / f.share[i] ** 2, 0.0 if f.stick[i] else f.u[i]
            else:
                self._free(s)

    def _forces(self, A: np.ndarray, speed: np.ndarray, free: np.ndarray, on: list[_Slot], t: float) -> Friction:
        rows = _rows(on)
        v = part(speed, rows).reshape(-1, 3)[:, 1:]
        size = np.hypot(v[:, 0], v[:, 1])
        moving = np.where(size[:, None] > RESTING, v / np.maximum(size, RESTING)[:, None], 0.0)
        problem = Condensed(A, free, rows, self._loops)
        return self._settled(Contacts(problem.A, problem.b, _friction(on), moving), on, t)

    def _settled(self, c: Contacts, on: list[_Slot], t: float) -> Friction:
        f = settle(c)
        if not f.found:
            names = ", ".join(dict.fromkeys(f"'{s.site.contact.name}'" for s in on))
            raise KernelError(
                f"contact {names} at {t:.6f} s: no forces fulfil contact and friction here (Painleve's paradox); "
                "lower mu, or let a support with stiffness take its place"
            )
        return f


def _holds(
    A: np.ndarray, free: np.ndarray, on: list[_Slot], others: list[_Slot], f: Friction, loops: list[int]
) -> bool:
    """Whether what is let go does not fall back under the forces f of the others."""
    problem, x = Condensed(A, free, _rows(on), loops), np.zeros(3 * len(on))
    for i, s in enumerate(others):
        k = on.index(s)
        x[3 * k : 3 * k + 3] = f.x[3 * i : 3 * i + 3]
    return bool(problem.after(x)[::3].min() > -LIGHT * np.abs(free).max())


def _moves(speed: np.ndarray, s: _Slot) -> bool:
    """Whether a slot with friction slides at an event."""
    return len(s.rows) == 3 and float(np.hypot(*speed[s.rows[1:]])) > RESTING


def _rows(on: list[_Slot]) -> list[int]:
    """Three per slot; -1 for tangents of contacts without friction."""
    return [k for s in on for k in (s.rows if len(s.rows) == 3 else [s.rows[0], -1, -1])]


def _friction(on: list[_Slot]) -> np.ndarray:
    return np.array([s.site.contact.mu for s in on])


def _work(problem: Condensed, u: np.ndarray, x: np.ndarray) -> float:
    """Kinetic energy that impulses x bring [J]."""
    return float(sum(p * 0.5 * (before + after) for p, before, after in zip(x, u, problem.after(x), strict=True)))


def _beyond(s: Site, h: np.ndarray, ends: dict[int, Any]) -> bool:
    """Whether a slot's place lies beyond its face or edges."""
    A, B = (np.array(ends[i], float) for i in s.bodies)
    along = s.pair.frame(h[:HELD], A, B).along
    return bool((np.abs(along) > h[HELD - 2 : HELD] + LEAVE).any())
