"""The next active set of contacts and rigid ropes at an event: solved for impulses first, then for forces.

All contacts at that instant are solved together (Newton's restitution per contact, so that three equal balls in a row
part as -1/3, 2/3, 2/3; a gap between them, however small, makes two impacts and 0, 0, 1). If restitution would raise
the energy, as Newton's law can with friction (Kane 1984), the impact is inelastic. Rebounds slower than `CAPTURE` are
set to zero: the infinitely many remaining bounces of a Zeno sequence are lower than a nanometre. If no force fulfils
the laws (Painleve 1895), the run ends with an error that names the contact.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import fsum
from typing import TYPE_CHECKING, Any

import numpy as np
from heavylift.kernel.constraints.complementarity import MU, MU_SHARED, solve
from heavylift.kernel.constraints.contact.contact_points import RESTING
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.evaluation import evaluate
from heavylift.kernel.model.switching import StateChange

from .condensed import Condensed, part
from .coulomb import ContactProblem, FrictionSolution, mobile, settle
from .unilateral import Unilateral, check_start, first_guard, ropes_of, slots_of, touch

if TYPE_CHECKING:
    from heavylift.kernel.model.program import Program

CAPTURE = 1e-4  # [m/s] slowest rebound
LIGHT = 1e-7  # part of the largest normal force below which a contact only touches
SMALL = 1e-9  # relative size of work that is round-off

Survey = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Act:
    """Callbacks by which the impact solver reads the state of a simulation and applies impulses to it."""

    survey: Callable[[], Survey]  # Delassus matrix, speeds and free accelerations of the rows
    slack: Callable[[], np.ndarray]  # slack of rigid ropes [m]
    kick: Callable[[np.ndarray], None]  # applies impulses
    close: Callable[[], None]  # projects positions and speeds onto the constraints


@dataclass(frozen=True)
class ImpactResult:
    """Result of an impact: events, heat and work by name [J], impulses by name [N s]."""

    events: list[StateChange]
    accounts: dict[tuple[str, str], float]
    impulse: dict[str, float]


class ContactSets:
    """Solver that determines at events which contacts push, stick and slide, and which rigid ropes are taut.

    It stores the result in the parameter block P.
    """

    def __init__(self, program: "Program", P: np.ndarray) -> None:
        self._program, self._P, self._at = program, P, program.parameters.at
        self._loops = list(range(len(program.constraints.of)))
        self._touches = first_guard(program, "touch")
        self._ropes, self._slots = ropes_of(program, self._numbers), slots_of(program, self._numbers)
        self._all: list[Unilateral] = [*self._ropes, *self._slots]

    def _numbers(self, kind: str, name: str) -> np.ndarray:
        return self._P[self._at[kind, name]]

    def _on(self) -> list[Unilateral]:
        return [x for x in self._all if x.on]

    def check_start(self, y: np.ndarray) -> None:
        """Raise KernelError if shapes overlap at the start."""
        ends = evaluate(self._program, 0.0, y, self._P, forces=False).ends
        check_start(self._program.contacts.sites, self._numbers, ends)

    def resolve(self, fallen: list[int], t: float, local: float, y: np.ndarray, act: Act) -> ImpactResult:
        """Return the impulses and new states of contacts and rigid ropes at t [s], after the guards `fallen` became
        negative; raises KernelError if there is no solution."""
        closed, slid, taut = self._closed(), self._sliding(), [r.on for r in self._ropes]
        scene = evaluate(self._program, local, y, self._P, forces=False)
        fell = {i - self._touches for i in fallen if self._program.guards[i][0] == "touch"}
        # contacts that have left a face free their slot before new ones take it
        touch(self._program.contacts.sites, self._slots, self._numbers, scene.ends, fell)
        for r, slack in zip(self._ropes, act.slack() if self._ropes else (), strict=True):
            r.take(float(slack))
        out = self._impact(t, act, {r.name: float(scene.length_of(r)[1]) for r in self._program.system.rigid_ropes})
        # speeds and gaps of round-off are removed between impact and force, or they would count as sliding
        self._rest(act)
        self._force(t, act, [x for x in self._all if x.guard in fallen])
        for r, was in zip(self._ropes, taut, strict=True):
            if r.on != was:
                out.events.append(StateChange(r.name, "taut" if r.on else "slack", out.impulse.get(r.name, 0.0)))
        now, slides = self._closed(), self._sliding()
        for name in dict.fromkeys(x.name for x in self._slots):
            if (name in now) != (name in closed):
                out.events.append(StateChange(name, "closed" if name in now else "open", 0.0))
            elif name in now and (name in slides) != (name in slid):
                out.events.append(StateChange(name, "slip" if name in slides else "stick", 0.0))
        return out

    def _closed(self) -> set[str]:
        return {x.name for x in self._slots if x.on}

    def _sliding(self) -> set[str]:
        return {x.name for x in self._slots if x.on and x.slips}

    def _impact(self, t: float, act: Act, reeling: dict[str, float]) -> ImpactResult:
        """Apply impulses of approaching contacts, release those that separate; `reeling`: rates of ropes' lengths."""
        on = self._on()
        # rows are those of all constraints; those of closed contacts in threes, normal first
        A, speed, _ = act.survey()
        rows = _rows(on)
        u = part(speed, rows)
        out = ImpactResult([], {}, {})
        # a joint that was locked in motion makes the impulses, even where no contact approaches
        jerked = bool(np.abs(speed[self._loops]).max(initial=0.0) > RESTING)  # by a lock
        if u[::3].min(initial=0.0) < -RESTING or jerked:
            problem = Condensed(A, speed, rows, self._loops)
            # Newton: the speed of separation is the restitution times that of approach
            bounce = np.array([x.restitution for x in on]) * np.maximum(-u[::3], 0.0)
            bounce[bounce < CAPTURE] = 0.0
            # Newton's law with friction can create energy (Kane 1984): then the impact is taken as inelastic
            p = self._impulses(problem, on, bounce, t)
            if bounce.any() and _work(problem, u, p) > SMALL * fsum(np.abs(p * u).tolist()):
                p = self._impulses(problem, on, 0.0 * bounce, t)
            # rebounds slower than CAPTURE would go on for ever (Zeno): they are stopped in the same impulse
            slow = {i for i, w in enumerate(problem.after(p)[::3]) if RESTING < w < CAPTURE and on[i].label != "rope"}
            p = p + self._held(problem, on, p, slow)
            after = problem.after(p)
            act.kick(problem.impulses(p, len(speed)))
            for name in dict.fromkeys(x.name for x in on):
                own = [i for i, x in enumerate(on) if x.name == name]
                parts = [3 * i + k for i in own for k in range(3)]
                push = out.impulse[name] = sum(float(p[3 * i]) for i in own)
                # work of an impulse is its product with the mean of the speeds before and after
                out.accounts["heat", name] = -sum(float(p[k] * 0.5 * (u[k] + after[k])) for k in parts)
                if name in reeling:
                    out.accounts["work", name] = -push * reeling[name]
                    continue
                if push > 0.0 and min(u[3 * i] for i in own) < -RESTING:
                    out.events.append(StateChange(name, "impact", push))
                slow |= {i for i in own if on[i].restitution > 0.0 > u[3 * i] + RESTING and not bounce[i]}
                if slow & set(own):
                    out.events.append(StateChange(name, "captured", push))
            u = after
        for x, speed_n in zip(on, u[::3], strict=True):
            if speed_n > RESTING:
                x.let_go()
        return out

    def _rest(self, act: Act) -> None:
        """Remove gaps of about a nanometre and negligible speeds left by impulses, so that sliding begins from rest."""
        _, speed, _ = act.survey()
        for x in self._slots:
            if x.on and _moves(speed, x):
                x.slide()
        act.close()
        for x in self._slots:
            if x.on:
                x.grip()

    def _impulses(self, problem: Condensed, on: list[Unilateral], bounce: np.ndarray, t: float) -> np.ndarray:
        b = problem.b.copy()
        b[::3] -= bounce
        return self._settled(ContactProblem(problem.A, b, _friction(on), np.zeros((len(on), 2))), on, t).x

    def _held(self, problem: Condensed, on: list[Unilateral], x: np.ndarray, slow: set[int]) -> np.ndarray:
        """Return further impulses that end the motion of `slow` contacts, while contacts with impulses x still push and
        stick."""
        extra = np.zeros(len(x))
        if slow:
            after = problem.after(x)
            rows = []
            for i, s in enumerate(on):
                sticks = s.mu > 0.0 and float(_length(*after[3 * i + 1 : 3 * i + 3])) < CAPTURE
                if i in slow or x[3 * i] > 0.0:
                    rows += [3 * i, 3 * i + 1, 3 * i + 2] if sticks else [3 * i]
            free = np.full(len(rows), np.inf)
            extra[rows] = solve(problem.A[np.ix_(rows, rows)], after[rows], -free, free).x
        return extra

    def _force(self, t: float, act: Act, spent: list[Unilateral]) -> None:
        """Determine the states of closed contacts from the accelerations.

        Forces that are not unique may differ from those of the evaluation, in which those of `spent` have vanished:
        such a contact or rope is released if the others hold without it.
        """
        on = self._on()
        if not on:
            return
        A, speed, free = act.survey()
        others = [x for x in on if x not in spent]
        f = self._forces(A, speed, free, others, t) if len(others) < len(on) else None
        if f is not None and _holds(A, free, on, others, f, self._loops):
            for x in on:
                if x not in others:
                    x.let_go()
            on = others
        else:
            f = self._forces(A, speed, free, on, t)
        loose = mobile(Condensed(A, free, _rows(on), self._loops).A, f)
        for i, x in enumerate(on):
            if f.push[i] and f.x[3 * i] > LIGHT * f.x[::3].max():
                moves = _moves(speed, x)
                x.keep(bool(f.stick[i]), moves, moves or bool(loose[i]), f.share[i], f.u[i], f.prior[3 * i : 3 * i + 3])
            else:
                x.let_go()

    def _forces(
        self, A: np.ndarray, speed: np.ndarray, free: np.ndarray, on: list[Unilateral], t: float
    ) -> FrictionSolution:
        rows = _rows(on)
        v = part(speed, rows).reshape(-1, 3)[:, 1:]
        size = _length(v[:, 0], v[:, 1])
        moving = np.where(size[:, None] > RESTING, v / np.maximum(size, RESTING)[:, None], 0.0)
        problem = Condensed(A, free, rows, self._loops)
        # forces that are not unique are shared by compliance, with a mean part so that stiff rows take some, too
        size = np.diag(A) + MU_SHARED / MU * float(np.diag(A).sum()) / len(A)
        return self._settled(ContactProblem(problem.A, problem.b, _friction(on), moving, part(size, rows)), on, t)

    def _settled(self, c: ContactProblem, on: list[Unilateral], t: float) -> FrictionSolution:
        for i, x in enumerate(on):
            # no mobility and an approach: driven bodies would have to yield
            if not c.A[3 * i, 3 * i] > 0.0 and not c.b[3 * i] > 0.0:
                raise KernelError(
                    f"{x.label} '{x.name}' at {t:.6f} s: drives or locks hold everything that it could "
                    "move; stop the drive earlier, make it a servo, or free a joint"
                )
        f = settle(c)
        if not f.found:
            names = ", ".join(dict.fromkeys(f"{x.label} '{x.name}'" for x in on))
            raise KernelError(
                f"{names} at {t:.6f} s: no forces satisfy contact and friction (Painleve's paradox); "
                "reduce mu, or replace the contact by a support with stiffness"
            )
        return f


def _holds(
    A: np.ndarray,
    free: np.ndarray,
    on: list[Unilateral],
    others: list[Unilateral],
    f: FrictionSolution,
    loops: list[int],
) -> bool:
    """Return whether the contacts without forces stay open under the forces f of the `others`."""
    problem, x = Condensed(A, free, _rows(on), loops), np.zeros(3 * len(on))
    for i, s in enumerate(others):
        k = on.index(s)
        x[3 * k : 3 * k + 3] = f.x[3 * i : 3 * i + 3]
    # small against the free accelerations: only touching
    return bool(problem.after(x)[::3].min() > -LIGHT * np.abs(free).max())


def _length(x: Any, y: Any) -> Any:
    """Return the length of one or many vectors (x, y)."""
    return np.sqrt(x * x + y * y)


def _moves(speed: np.ndarray, x: Unilateral) -> bool:
    """Return whether a contact has friction and slides at an event."""
    return bool(x.rows[1] >= 0 and _length(*speed[x.rows[1:]]) > RESTING)


def _rows(on: list[Unilateral]) -> list[int]:
    return [k for x in on for k in x.rows]


def _friction(on: list[Unilateral]) -> np.ndarray:
    return np.array([x.mu for x in on])


def _work(problem: Condensed, u: np.ndarray, x: np.ndarray) -> float:
    """Return the kinetic energy that impulses x add [J]."""
    # kinetic energy gained: sum of impulse times mean speed
    return float(sum(p * 0.5 * (before + after) for p, before, after in zip(x, u, problem.after(x), strict=True)))
