"""One island of a scene: a simulation that runs ahead of others and can roll back, with the ropes at which it could be
split."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from heavylift.kernel.constraints.row_structure import RigidAt
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.ropes import RopeAt
from heavylift.kernel.methods.control import still_below
from heavylift.kernel.simulation.call_protocol import STOPPED
from heavylift.kernel.simulation.native.native_state import FOREVER_NS
from heavylift.kernel.simulation.native.sample_row import labels
from heavylift.kernel.simulation.simulation import Simulation
from heavylift.kernel.simulation.snapshots import Snapshot, back, copied, mark

from .components import islands_of

STATE = ("q", "v", "accounts", "turned")
KINDS = ("rope", "rigid", "support", "stop", "brake", "force", "held", "slot", "threshold")  # with discrete states
PRICE = 2e5  # attempted steps that take as long as compiling their code: 3 operations of it for each of an evaluation


class RecompileBudget:
    """Ski-rental rule for splitting an island: split once the wasted work equals the cost of compiling.

    The total cost is at most twice that of an optimal decision (Karlin et al., Algorithmica 3, 1988). Steps are
    counted, not seconds, so that all runs of a scene decide alike.
    """

    def __init__(self, price: float) -> None:
        self._price = price
        self.spent: dict[frozenset[str], float] = {}  # attempted steps in which these ropes tied nothing
        self.since = 0.0  # attempted steps at the last look
        self.seen: frozenset[str] = frozenset()  # ropes that tied nothing then

    def ends(self, attempts: float, loose: frozenset[str], share: float) -> bool:
        """Return whether splitting the island at the unhooked ropes `loose` pays if it saves this `share` of work."""
        if self.seen:
            self.spent[self.seen] = self.spent.get(self.seen, 0.0) + attempts - self.since
        self.since, self.seen = attempts, loose
        return share * self.spent.get(loose, 0.0) >= self._price

    def kept(self) -> dict[str, Any]:
        """Return the state of the splitting rule as plain data: the steps counted so far for each set of ropes."""
        return {
            "spent": [[sorted(ropes), n] for ropes, n in self.spent.items()],
            "since": self.since,
            "seen": sorted(self.seen),
        }

    def go_on(self, kept: dict[str, Any]) -> None:
        """Restore the step counts of the splitting rule from the data that `kept` returned."""
        self.spent = {frozenset(ropes): n for ropes, n in kept["spent"]}
        self.since, self.seen = kept["since"], frozenset(kept["seen"])


class Island(Simulation):
    """The simulation of one island; its sample rows at events are kept apart, to be merged into rows of the scene."""

    struck: np.ndarray  # row of the last event or command

    def __init__(self, system: System, cut_at_once: bool = False, **options: Any) -> None:
        super().__init__(system, **options)
        self.given, self.subscribed = system, frozenset(name for _, name in self.program.guards)
        self.cuts = RecompileBudget(0.0 if cut_at_once else PRICE)
        self.merged = 0, 0  # entries of log and notes that are in the common ones
        self.pace = 0.0  # steps times degrees of freedom per nanosecond, where it last ran ahead
        self.stand()

    def settle(self) -> None:
        """Recompute the island's derivative and guards after events; keep the sample row at the event in `struck`.

        The peaks of this row count for the next sample.
        """
        before = len(self.rows)
        super().settle()
        ((_, self.struck),) = self.rows[before:]
        del self.rows[before:]
        native, at = self.native, self.method.row_layout.at
        native.part("peak")[:] = self.struck[at["peak"]]
        native.part("peak_time")[:] = self.struck[at["peak_time"]] - self.epoch * 1e-9

    def stand(self) -> None:
        """Make the island's present state final, so that it cannot be rolled back to an earlier time."""
        self.marks: list[tuple[int, Snapshot]] = []  # to which it can go back, with their times [ns]
        self.span = 1  # periods of samples that it runs ahead of what is known of the others
        self.refused = False  # it cannot run ahead
        self._look()

    def _look(self) -> None:
        """Update the time of the next event or step end [ns], whether it is an event, and where the last step began."""
        self.due, self.firing = self.next_ns, self.event
        self._resting: np.ndarray | None = None
        self.began = self.present_ns

    def work(self, until_ns: int, most_ns: int) -> float:
        """Return how much work `extend` is likely to take, in steps times degrees of freedom."""
        return self.pace * (self._end(until_ns, most_ns) - self.began)

    def _end(self, until_ns: int, most_ns: int) -> int:
        return until_ns if self.refused else max(until_ns, self.due + min(self.span * self.recorder.sample_ns, most_ns))

    def extend(self, until_ns: int, most_ns: int, pause: Callable[[], None]) -> None:
        """Advance the island to a time [ns], then by up to `most_ns` more until an event or an error stops it."""
        marked, end = (self.began, mark(self)), self._end(until_ns, most_ns)
        steps = -self.native.attempts
        try:
            self.run(end, pause)
        except KernelError:  # it counts if nothing happens elsewhere before
            if self.refused:
                raise
            back(self, marked[1])
            self.refused = True
            return
        self.span *= 2
        self.marks.append(marked)
        self._look()
        steps += self.native.attempts
        self.pace = steps * self.program.nv / max(self.recorder.sample_ns, self.began - marked[0])

    def forget(self, before_ns: int) -> None:
        """Delete the saved states before a time [ns] to which the island could be rolled back."""
        if self.began <= before_ns:
            self.marks.clear()
        while len(self.marks) > 1 and self.marks[1][0] <= before_ns:
            self.marks.pop(0)

    def passed(self, t_ns: int) -> bool:
        """Return whether the island has advanced beyond a time [ns], and can be rolled back to it."""
        return bool(self.marks) and self.began > t_ns

    def rewind(self, t_ns: int) -> None:
        """Roll the island back to a time [ns] that it has already passed."""
        if self.passed(t_ns):
            self.marks = [self.marks[0], *(m for m in self.marks[1:] if m[0] <= t_ns)]
            back(self, self.marks[-1][1])
            self.run(t_ns)
            self.span = 1
            self._look()

    @property
    def earliest(self) -> int:
        """The earliest time [ns] at which the island can receive commands."""
        return self.marks[0][0] if self.marks else self.began

    @property
    def history(self) -> int:
        """The time [ns] up to which commands can no longer change the states of the island; FOREVER_NS at rest."""
        return FOREVER_NS if self.still and not self.marks else self.earliest - 1

    def shown_at(self, t_ns: int) -> np.ndarray:
        """Return the island's sample row at a time [ns]; if it has passed that time, it runs there once more."""
        if not self.passed(t_ns):
            return self.shown(t_ns)
        ahead = mark(self)
        try:
            back(self, next(m for at, m in reversed(self.marks) if at <= t_ns or m is self.marks[0][1]))
            self.run(t_ns)
            return self.shown(t_ns)
        finally:
            back(self, ahead)

    @property
    def resting(self) -> np.ndarray | None:
        """The sample row of the island at rest; None while it moves."""
        if self.still and self._resting is None:
            self._resting = self.shown(self.epoch)
        return self._resting

    def snapshot(self) -> Snapshot:
        """Return a snapshot of the island that includes its rollback marks."""
        return super().snapshot() | {"ahead": copied({"marks": self.marks, "span": self.span, "refused": self.refused})}

    def restore(self, snapshot: Snapshot) -> None:
        """Restore a snapshot of the island, including its rollback marks."""
        super().restore(snapshot)
        ahead = copied(snapshot["ahead"])
        self.marks, self.span, self.refused = ahead["marks"], ahead["span"], ahead["refused"]
        self._look()

    def _show_rest(self, pause: Callable[[], None]) -> None:
        """Do nothing: rows of rest are published together with those of other islands."""

    def tells(self, subscribed: frozenset[str]) -> bool:
        """Return whether the island's next event belongs to a law whose events are subscribed."""
        return not subscribed.isdisjoint(self.events.names)

    def may_be_cut(self) -> frozenset[str]:
        """Return the unhooked ropes at which to split the island because one part is at rest; empty if it should not
        be."""
        loose = self._unhooked()
        if self.events.fallen or not (share := self._resting_share(loose)):
            return frozenset()
        return loose if self.cuts.ends(self.native.attempts, loose, share) else frozenset()

    def _unhooked(self) -> frozenset[str]:
        at, s = self.program.parameters.at, self.given
        out = {r.name for r in s.ropes if not self.P[at["rope", r.name]][RopeAt.HOOKED]}
        return frozenset(out | {r.name for r in s.rigid_ropes if not self.P[at["rigid", r.name]][RigidAt.HOOKED]})

    def _resting_share(self, loose: frozenset[str]) -> float:
        """Return the share of degrees of freedom in islands at rest if the ropes `loose` couple nothing; 0 if all or
        none."""
        pieces = islands_of(self.given, loose) if loose else []
        own = [self._velocities({b.name for b in piece.bodies}) for piece in pieces]
        limit = float(still_below(self["scale"], self["faint"]))
        nq, now = self.program.nq, (self.state, self.native.part("f"))
        resting = [len(v) for v in own if all(float(x[nq:][v] @ x[nq:][v]) < limit for x in now)]
        return sum(resting) / self.program.nv if len(resting) < len(own) else 0.0

    def _velocities(self, bodies: set[str]) -> list[int]:
        links = self.program.graph.links
        return [i for k in links if k.body.name in bodies for i in range(k.v.start, k.v_modes.stop)]


def inherit(new: Simulation, old: Sequence[Simulation]) -> None:
    """Copy time and state of the simulations `old` to the simulation `new` that replaces them, before `settle`.

    Coordinates, velocities and energy accounts, discrete states, motions, locks and thresholds are copied by name; step
    control starts with the shortest of their steps.
    """
    s, at, native = new.program.system, new.program.parameters.at, new.native
    native.calm = frozenset(r.name for r in s.ropes if any(r.name in x.native.calm for x in old))
    native.use(frozenset(k.name for k in s.locks if any(k.name in x.program.locked for x in old)))
    known = dict[tuple[str, str, int], float]()
    for x in old:
        own = [label for label in labels(x.program) if label[0] in STATE]
        known |= dict(zip(own, x.state.tolist(), strict=True))
        for key, place in x.program.parameters.at.items():
            if key[0] in KINDS and key in at:
                new.P[at[key]] = x.P[place]
        new.switches.watched |= {k: v for k, v in x.switches.watched.items() if ("threshold", k) in at}
        new.events.rattling.counts |= x.events.rattling.counts
        new.references.take(x.references)
    new.state[:] = [known[label] for label in labels(new.program) if label[0] in STATE]
    native.set(h=min(x["h"] for x in old), error=max(x["error"] for x in old), scale=max(x["scale"] for x in old))
    native.epoch, new.recorder.number, new.order.phase = old[0].epoch, old[0].recorder.number, STOPPED
    new.integrator.new_stretch(new.epoch)
    new.held.measure()
