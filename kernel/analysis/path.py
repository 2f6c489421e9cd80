"""The equilibrium path: the rest poses of a scene as its drives, winches and other motions proceed as commanded,
without dynamics.

The path is continued in the time of the commands, not in arc length, without inertia and speeds; the curvature that
the corrector measures sets the steps. Events (guards that become negative) are located on the path and switch the laws
there. Where no equilibrium is near any more (a fold, a load let go), the scene falls to the next one: this is reported.

    start()           find the first equilibrium; returns the events on the way to it
    run(until_ns)     follow the path to the first subscribed event; returns the events, [] at `until_ns`
    command.set_...   give commands at `epoch`, as to a `Simulation`
    settle()          find the equilibrium after commands
"""

from dataclasses import dataclass
from math import ceil, nan
from types import SimpleNamespace

import numpy as np
from heavylift.kernel.algebra.elementary import power
from heavylift.kernel.description.findings import Note
from heavylift.kernel.description.profile import REST
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.references import ReferenceProfile
from heavylift.kernel.model.switching import StateChange
from heavylift.kernel.simulation.native.native_state import NEVER
from heavylift.kernel.simulation.safeguards.deflection_check import check_bending
from heavylift.kernel.simulation.simulation import FOREVER_NS, Simulation

from .corrector import BEND, Corrector
from .equilibrium import RUBS, Equilibrium, equilibrium_at, net, relaxed, release, switch
from .modes import Modes, modes_at

FIRST_NS, LONGEST_NS, SHORTEST_NS = 10**9, 600 * 10**9, 10**5  # steps of the path
LONGEST_FALL_NS = 10**10  # of commands that go on while a scene falls from a fold
SOON = 10  # times the length of a fall within which the next one is its sequel
CHORD, START, LINE, NEAR, MIDDLE = range(5)  # guesses of when an event is
# what follows a guess that leaves half of the bracket or less, or more
WELL = {CHORD: CHORD, START: CHORD, LINE: LINE, NEAR: LINE, MIDDLE: LINE}
BADLY = {CHORD: START, START: LINE, LINE: NEAR, NEAR: MIDDLE, MIDDLE: LINE}
PARTS = {START: 1e-3, NEAR: 0.9, MIDDLE: 0.5}  # of the bracket
LOCATED_NS = 1000  # an event is located to this
UNLOCATED = (*RUBS, "bending")  # kinds of guards that are looked at where a step ends
GROWTH = 1e-4  # [1/s2] eigenvalue of the tangent stiffness that is instability, not rounding
SLID = 0.03  # [m] of a pad in a step: its way is a chain of secants
FAR = 1.0  # [m, rad] of a fall that is worth a note
CHATTER = 50  # events at one instant after which the laws are settled together


@dataclass(frozen=True)
class PathPoint:
    """A point of the equilibrium path: time, coordinates (nq,), sample row, events at this time."""

    t_ns: int
    q: np.ndarray
    row: SimpleNamespace
    events: tuple[StateChange, ...]


class EquilibriumPath:
    """Moves a simulation from one static equilibrium to the next as commands take effect.

    Nothing else may advance the simulation. `heard`: names of laws whose events stop `run`; `points`: all equilibria so
    far; `notes`: messages for the user.
    """

    def __init__(self, simulation: Simulation, heard: frozenset[str] = frozenset()) -> None:
        self.command, self.heard = simulation, heard
        self.epoch = 0
        self.points: list[PathPoint] = []
        self._kept_ns = 0  # [ns] of the last of them, also if it was taken away
        self.notes: list[Note] = []
        self.unstable_since: int | None = None
        """Time from which the equilibrium is unstable [ns]."""
        self._dt, self._steps = FIRST_NS, 0
        self._fallen, self._later = -1, 0  # when it fell last, and how long it was led on meanwhile [ns]
        self._instant = 0

    # ---- life ---------------------------------------------------------------------------------------------

    def start(self) -> list[StateChange]:
        """Find the first equilibrium; return the events on the way to it. Raises KernelError if there is none."""
        self.command.start()
        self._commanded()
        self._q = self.command.state[: self.command.program.nq].copy()
        self._near = Corrector(self.command)
        return self._fall("")

    def settle(self) -> list[StateChange]:
        """Find the equilibrium after commands; return the events on the way. Raises KernelError if there is none."""
        self._commanded()
        self._near.renew(self._q)
        q = self._near.corrected(self._near.place(self._q))
        if q is None:
            return self._fall("after a command")
        happened = switch(self._near.poses, q, thresholds=True)
        self._q = q
        if happened:
            return self._settled(happened)
        self._keep([])
        return []

    def run(self, until_ns: int) -> list[StateChange]:
        """Follow the equilibrium path to the time `until_ns` or the first event of a subscribed law; return its events.

        Raises KernelError if the path ends earlier.
        """
        while self.epoch < until_ns:
            rest = self.command.references.rest(self.epoch)
            # nothing moves any more: go to the end in one step
            if rest <= 0.0:
                self._lead(until_ns)
                return []
            end = min(until_ns, self.epoch + ceil(min(rest, 1e9) * 1e9), self._break_ns())
            happened = self._step(end)
            if any(e.name in self.heard for e in happened):
                return happened
        return []

    def rest(self) -> Equilibrium:
        """Return the present equilibrium, with the simulation set to its pose."""
        self._near.poses.accelerations(self._q)
        return equilibrium_at(self.command, self._q, self._steps)

    # ---- steps --------------------------------------------------------------------------------------------

    def _break_ns(self) -> int:
        """Return the time [ns] of the next change of slope in a history of loads or wind."""
        following = self.command.references.histories.breaks(self.epoch, 0.0)
        return self.epoch + round(min(following) * 1e9) if following else FOREVER_NS

    def _step(self, end_ns: int) -> list[StateChange]:
        """Follow the path for one step, at most to `end_ns`; return the events at its end."""
        t0, q0 = self.epoch, self._q
        G0, P0 = self._near.guards(q0), self.command.P.copy()
        while True:
            t1 = min(end_ns, t0 + self._dt)
            self._lead(t1)
            q, bend = self._near.predicted(q0, P0, t1 - t0)
            if q is not None:
                break
            if t1 - t0 <= SHORTEST_NS:
                self._q = q0
                return self._beyond(end_ns)
            # bisect the step until the corrector finds an equilibrium
            self._dt = max(SHORTEST_NS, (t1 - t0) // 2)
        if t1 - t0 >= self._dt or bend > BEND:
            # curvature error falls with the cube of the step
            grown = (t1 - t0) * min(5.0, max(0.3, 0.9 * power(BEND / max(bend, 1e-12), 1.0 / 3.0)))
            self._dt = min(LONGEST_NS, max(SHORTEST_NS, int(grown)))
        kinds = [kind for kind, _ in self.command.program.guards]
        # friction and bending are looked at where a step ends: locating them would need many short steps
        G0[[kind in UNLOCATED for kind in kinds]] = nan
        if ((self._near.guards(q) < 0.0) & (G0 >= 0.0)).any():
            t1, q = self._located(t0, q0, G0, t1, q)
        self._instant = self._instant + 1 if t1 - t0 <= LOCATED_NS else 0
        self._lead(t1)
        self._q = q
        if happened := switch(self._near.poses, q, thresholds=True):
            return self._settled(happened)
        self._keep([])
        self._check_stability()
        return []

    def _beyond(self, end_ns: int) -> list[StateChange]:
        """Find the equilibrium to which the scene falls where the path ends; return the events. Commanded motions
        continue meanwhile, since they may lead to the next equilibrium: time advances until one is found."""
        t0, later = self.epoch, SHORTEST_NS
        # falls in quick succession are stick-slip: the commands are led on further before the next equilibrium is
        # sought
        if t0 < self._fallen + SOON * self._later:  # falls in a row, as of stick and slip
            later = min(LONGEST_FALL_NS, SOON * self._later)
        while True:
            self._lead(min(end_ns, t0 + later))
            # the next equilibrium may only exist after the commands have moved on
            self._fallen, self._later = self.epoch, later
            try:
                return self._fall("the equilibrium ends", since_ns=t0)
            except KernelError:
                if later > LONGEST_FALL_NS or t0 + later >= end_ns:
                    raise
                later *= 10

    def _settled(self, happened: list[StateChange]) -> list[StateChange]:
        """Find the equilibrium after laws have switched; return the net events."""
        # too many events at one instant: the laws are settled together by a fall
        for _ in range(CHATTER if self._instant < CHATTER else 0):
            self._near.renew(self._q)
            q = self._near.corrected(self._q)
            if q is None:
                break
            self._q = q
            more = switch(self._near.poses, q, thresholds=True)
            if not more:
                events = net(happened)
                self._keep(events)
                self._check_stability()
                return events
            happened += more
        return net(happened + self._fall("", happened))

    def _fall(
        self, why: str, before: list[StateChange] | None = None, since_ns: int | None = None
    ) -> list[StateChange]:
        """Fall to the equilibrium that the scene settles into; add a note if it is far away; return the events."""
        poses, start = self._near.poses, self._q
        try:
            q, self._steps, events = relaxed(poses, poses.moved(start, np.zeros(len(poses.free))))
        except KernelError as error:
            message = f"{why}; " if why else ""
            when = f"at {self.epoch * 1e-9:.3f} s, followed at rest: " if self.epoch else ""
            raise KernelError(f"{when}{message}{error}") from error
        events += switch(poses, q, thresholds=True)
        self._q = q
        self._near.renew(self._q)
        far = float(np.abs(q - start).max(initial=0.0))
        if why and far > FAR:
            message = f"{why}: the scene falls by {far:.2g} (m or rad) to its next rest"
            self.notes.append(Note(self.epoch if since_ns is None else since_ns, message))
        self._keep(net((before or []) + events))
        self._check_stability()
        return net(events)

    def _located(self, t0: int, q0: np.ndarray, G0: np.ndarray, t1: int, q1: np.ndarray) -> tuple[int, np.ndarray]:
        """Return the first time in a step at which a guard is negative, and the equilibrium there.

        The next time to try is one of these: the end of the chord across the bracket; the end of the line through the
        last two equilibria before the event (for a guard with a kink there), or a time just after the beginning if
        there are not yet two; a time just before the end, if such a line came close; the middle. Each is shifted
        slightly to the far side, so that the bracket shrinks from both ends.
        """
        G1, kind, failed = self._near.guards(q1), CHORD, set[int]()
        earlier = t0, q0, G0
        while t1 - t0 > LOCATED_NS:
            width = t1 - t0
            fell = np.flatnonzero((G1 < 0.0) & (G0 >= 0.0))
            # the line through earlier points needs two of them
            if kind == LINE and earlier[0] == t0:
                kind = MIDDLE if START in failed else START
            t, q, G = earlier if kind == LINE else (t1, q1, G1)
            part = PARTS.get(kind, 0.0)
            if kind in (CHORD, LINE):
                drop = (G0[fell] - G[fell]) / (t - t0)  # in each nanosecond
                part = float((G0[fell][drop > 0.0] / drop[drop > 0.0]).min(initial=width)) / width
            # slightly to the far side, so that the bracket shrinks from both ends
            slope, lateral = (q - q0) / (t - t0), LOCATED_NS // 2 if part < 0.5 else -LOCATED_NS // 2
            t = min(t1 - 1, max(t0 + 1, t0 + round(part * width) + lateral))
            self._lead(t)
            found = self._near.corrected(self._near.place(q0 + (t - t0) * slope))
            if found is None and kind in failed:
                if width <= SHORTEST_NS:
                    break
                # from the last equilibrium before the event, shorter steps find the way
                self._dt = max(SHORTEST_NS, width // 2)
                self._near.renew(q0)
                return t0, q0
            if found is None:
                failed, kind = {*failed, kind}, BADLY[kind]
                continue
            failed.clear()  # in a smaller bracket, each guess may succeed
            G = self._near.guards(found)
            if ((G < 0.0) & (G0 >= 0.0)).any():
                t1, q1, G1 = t, found, G
            else:
                earlier, t0, q0, G0 = (t0, q0, G0), t, found, np.where(G0 >= 0.0, G, G0)
            kind = (BADLY if 2 * (t1 - t0) > width else WELL)[kind]
        return t1, q1

    # ---- points -------------------------------------------------------------------------------------------

    def _lead(self, t_ns: int) -> None:
        """Set driven coordinates to their commanded values at a time."""
        s = self.command
        self.epoch = s.native.epoch = t_ns
        for place, a in self._driven:
            s.P[place] = a.x0 + a.move.displacement((t_ns - a.start_ns) * 1e-9)
        s.references.stand(t_ns)
        s.references.histories.write(t_ns)
        if self._clock is not None:
            s.P[self._clock] = t_ns * 1e-9

    def _commanded(self) -> None:
        """Take over the commands given at the epoch, so that `_lead` evaluates the commanded motions."""
        s, at = self.command, self.command.program.parameters.at
        s.native.set(t=0.0, t_stop=NEVER)
        s.references.write(self.epoch)
        self._driven: list[tuple[int, ReferenceProfile]] = []
        for name, a in s.references.actuators.items():
            place = at["reference", name]
            # a profile at rest whose value `_lead` sets: no speeds or accelerations in the path
            s.P[place] = [0.0, s.references.own(name, self.epoch)[0], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
            if a.move is not REST:
                self._driven.append((range(len(s.P))[place][1], a))
        self._clock = at.get(("clock", ""))

    def _keep(self, events: list[StateChange]) -> None:
        self._near.poses.count_turns(self._q)
        self._near.poses.accelerations(self._q)
        check_bending(self.command.native)
        slid = release(self.command)
        if slid > SLID:
            # friction follows secants of its path: shorter steps where pads slide far
            self._dt = max(SHORTEST_NS, int((self.epoch - self._kept_ns) * SLID / slid))
        self._kept_ns = self.epoch
        self.points.append(PathPoint(self.epoch, self._q.copy(), self.command.row(), tuple(events)))

    # ---- stability ----------------------------------------------------------------------------------------

    def stiffness(self) -> float:
        """Return the smallest eigenvalue of tangent stiffness over inertia at the present equilibrium [1/s2]."""
        return self._near.stiffness(self._q)

    def modes(self) -> Modes:
        """Return the modes of small motions about the present equilibrium."""
        return modes_at(self._near.poses, self._q)

    def _check_stability(self) -> None:
        """Add a note if the equilibrium has become unstable: an eigenvalue of the tangent stiffness passed zero."""
        # the determinant changes sign with one eigenvalue; eigenvalues are computed only then
        if self._near.poses.sign() < 0.0 and self.unstable_since is None and self.stiffness() < -GROWTH:
            self.unstable_since = self.epoch
            self.notes.append(
                Note(self.epoch, "the equilibrium is unstable: the smallest push makes the scene leave it")
            )
