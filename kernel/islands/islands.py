"""Simulation of a scene as several islands: each takes its own steps, and an island at rest takes none.

Each runs ahead of the others (see `running_ahead`), and the cost of an event is that of its own island, however many
islands there are. Steps depend on the history of one island only, so results do not depend on how far or in what order
islands run ahead. A command stops the addressed island only; the others' part of a row is read from their dense output.

Hooking a rope between two islands joins them; after it is unhooked and a part has come to rest, the island is split
again once that is worth its cost (see `island.RecompileBudget`).
"""

from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np
from heavylift.kernel.description.mechanics import System, Vector
from heavylift.kernel.errors import KernelError
from heavylift.kernel.methods.choice import choose, control_of
from heavylift.kernel.model.checks import accepted, check_description
from heavylift.kernel.model.program import Program
from heavylift.kernel.model.switching import ROPES, StateChange
from heavylift.kernel.multibody.joint_locking import lock_of
from heavylift.kernel.simulation import call_protocol
from heavylift.kernel.simulation.call_protocol import CallProtocol, check_present, check_time, passed_by
from heavylift.kernel.simulation.commands import CommandSwitches
from heavylift.kernel.simulation.native.native_functions import Stepping
from heavylift.kernel.simulation.simulation import FOREVER_NS
from heavylift.kernel.simulation.snapshots import Snapshot, copied, foreign, read, write

from .components import islands_of, loose_ropes
from .island import Island, inherit
from .running_ahead import SPAN, RunningAhead
from .sample_merge import Joining, LiftRows, logged, untied

KEPT = {"": ("rows", "notes", "epoch", "reached", "_due"), "order": ("phase",), "samples": ("number", "struck")}


class Islands(RunningAhead):
    """Simulation of several islands with the interface of `Simulation`; arguments as there and in `choice.simulate`."""

    def __init__(
        self,
        system: System,
        tolerance: float = 1e-7,
        sample_ns: int = 500_000_000,
        subscribed: frozenset[str] = frozenset(),
        ties: Collection[str] = (),
        lifts: Mapping[str, Collection[str]] | None = None,
        **options: Any,
    ) -> None:
        self.program = Program(system)
        self.system = check_description(system)
        found = choose(options.get("method", "dopri5"), self.program)
        self.method = Stepping(self.program, found, control_of(found, options.get("step"), self.program))
        self._options = {"tolerance": tolerance, "sample_ns": sample_ns, **options}
        super().__init__(subscribed, sample_ns)
        self.loose: frozenset[str] = frozenset()  # ropes that tie nothing now
        self.samples = Joining(self.program, sample_ns)
        self.order = CallProtocol()
        self.lifts: list[LiftRows] = []
        self._cut(loose_ropes(self.system, ties))
        self.lifts = [LiftRows(name, self._method_of(own)) for name, own in untied(self.system, lifts or {}).items()]
        for lift in self.lifts:
            lift.cut(self.parts, self.loose)

    @property
    def alone(self) -> list[LiftRows]:
        """Sample rows recorded at the events of each single lift; empty if the scene has only one lift."""
        return self.lifts

    def _method_of(self, system: System) -> Stepping:
        """Return the method of the island that holds exactly this system, or a new one that is used only for rows."""
        bodies = {b.name for b in system.bodies}
        same = next((p for p in self.parts if bodies == {b.name for b in p.given.bodies}), None)
        return same.method if same else Stepping(Program(system), self.method.method, self.method.control)

    def _cut(self, loose: frozenset[str]) -> None:
        """Split the system into islands; ropes `loose` couple nothing; new islands take over the old state."""
        self.loose, old = loose, self.parts
        self.parts, stopped = [], self._stopped
        self._stopped = []
        for system in map(accepted, islands_of(self.system, loose)):
            same = next((p for p in old if p.given == system), None)
            if same is None:
                same = Island(system, **self._options)
                own = {b.name for b in system.bodies}
                before = [p for p in old if own & {b.name for b in p.given.bodies}]
                if before:
                    inherit(same, before)
                    self._stopped.append(same)
            elif same in stopped:
                self._stopped.append(same)
            self.parts.append(same)
        self.samples.cut(self.parts, loose)
        for lift in self.lifts:
            lift.cut(self.parts, loose)
        self._soonest = None

    def start(self) -> None:
        """Find the discrete states of the initial pose and take the first sample."""
        self.order.check_new(self.epoch)
        for p in self.parts:
            p.start()
            p.stand()
        self.order.phase, self._soonest = call_protocol.SETTLED, None
        self.rows.append((0, self.samples.whole([p.struck for p in self.parts])))
        self.log += logged(self.parts)
        self._collect()

    @property
    def present_ns(self) -> int:
        """The earliest time [ns] at which commands are possible."""
        for p in self.parts:
            p.rewind(self.reached)
        self._soonest = None
        return self._present(*(p.began for p in self.parts if not p.still))

    def _present(self, *of_parts: int) -> int:
        return max(self.epoch, (self.samples.number - 1) * self._sample_ns, *of_parts)

    @property
    def now(self) -> float:
        """The time [s] that all islands have reached."""
        return self.reached * 1e-9

    def run(self, until_ns: int, pause: Callable[[], None] = lambda: None) -> None:
        """Advance to `until_ns` or to the first subscribed event."""
        check_time(until_ns)
        if self.order.phase == call_protocol.PAUSED:
            self.settle()
        self.order.check_settled("run", self.epoch)
        self.order.phase = call_protocol.GOING
        if until_ns < self.reached:
            return
        while True:
            end = self._run_to(min(until_ns, self.reached + SPAN * self._sample_ns), pause)
            self._reach(end)
            if self._firing and self.next_ns == end and not self.event:
                self.fire()
                self.settle()
                self.order.phase = call_protocol.GOING
            elif end >= until_ns or (self._firing and self.next_ns == end) or self.next_ns >= FOREVER_NS:
                return

    def foretold(self) -> tuple[int, np.ndarray] | None:
        """Return time [ns] and row of the next sample if all islands are at rest; None if an island moves."""
        parts = [found[1] for p in self.parts if (found := p.foretold())]
        if len(parts) < len(self.parts) or any(p.rows for p in self.parts) or self.samples.struck:
            return None
        return self.samples.next_ns, self.samples.whole(parts)

    def shown(self, t_ns: int) -> np.ndarray:
        """Return the sample row at a time without changing the state, as `Simulation.shown` does."""
        return self.samples.whole([p.shown_at(t_ns) for p in self.parts])

    def preview(self) -> list[StateChange]:
        """Return the events that the next `fire` will return, without changing the state."""
        self.order.check_settled("preview", self.epoch)
        return [e for p in self._firing for e in p.preview()]

    def fire(self) -> list[StateChange]:
        """Integrate the islands with the located event up to the event, and switch the laws whose guards are negative;
        return the events."""
        self.order.check_settled("fire", self.epoch)
        if not (firing := self._firing):
            raise KernelError("no event has been located; call run() first")
        self.order.phase = call_protocol.STOPPED
        self.epoch, self._stopped = self.next_ns, [*firing]
        events = [e for p in firing for e in p.fire()]
        self._stand(firing)
        self._reach(self.epoch)
        return events

    def interrupt(self, t_ns: int, pause: Callable[[], None] = lambda: None) -> None:
        """Advance to t_ns so that commands can be given; islands that receive no commands continue (see
        `Simulation.interrupt`).

        `pause` is also called in `settle` and in commands.
        """
        if self.order.stands_at(t_ns, self.epoch):
            return
        if t_ns < self.reached:
            check_present(t_ns, self.present_ns)
        self._pause = pause
        self.run(t_ns, pause)
        if self.event and self.next_ns < t_ns:
            raise passed_by(t_ns, self.next_ns, [name for p in self._firing for name in p.events.names])
        self.epoch, self._stopped = t_ns, []
        self.order.phase = call_protocol.PAUSED

    def settle(self) -> None:
        """Recompute the islands stopped by events or commands; if none is stopped (end of the run), recompute all."""
        self.order.check_standing("settle", self.epoch)
        if ended := not self._stopped:
            self._stop_all()
        self._cut_again()
        for p in self._stopped:
            p.settle()
        self._stand(self._stopped)
        if ended or not self.lifts:
            parts = [p.struck if p in self._stopped else p.shown_at(self.epoch) for p in self.parts]
            self.samples.struck.append((self.epoch, self.samples.whole(parts)))
        for lift in self.lifts if not ended else ():
            if any(p in self._stopped for p in lift.parts):
                lift.take(self.epoch, self._stopped)
        self._reach(self.epoch)
        self._stopped, self._soonest = [], None
        self.order.phase = call_protocol.SETTLED

    def _stop(self, p: Island) -> Island:
        """Stop an island at the epoch, rolling it back if needed, and return it."""
        if p not in self._stopped:
            p.rewind(self.epoch)
            p.interrupt(self.epoch)
            self._stand([p])
            self._stopped.append(p)
        return p

    def _stop_all(self) -> None:
        for p in self.parts:
            self._stop(p)
        self._reach(self.epoch, whole=True)

    def _cut_again(self) -> None:
        """Split islands at unhooked ropes if the part to be split off rests and the split is worth its cost."""
        for p in self._stopped:
            if loose := p.may_be_cut():
                self._stop_all()
                self._cut(self.loose | loose)
                return

    def _addressed(self, what: str, kind: str, name: str) -> CommandSwitches:
        """Stop the island with a law of this name and return its commands; raises KernelError if there is none."""
        self.order.command(what, self.epoch)
        kinds = ROPES if kind == "rope" else (kind,)
        for p in self.parts:
            if any((k, name) in p.program.parameters.at for k in kinds):
                return self._stop(p).commands
        raise KernelError(f"'{name}': there is no {kind} with this name; check the name")

    def set_profile(self, name: str, start_ns: int, speed: float, accel: float, distance: float | None) -> None:
        """Set a motion of an actuator or master signal in all islands that it moves."""
        self.order.command("set_profile", self.epoch)
        owners = [p for p in self.parts if name in p.references.actuators]
        if not owners:
            raise KernelError(f"'{name}': there is no drive, winch or master with this name; check the name")
        for p in owners:
            self._stop(p).set_profile(name, start_ns, speed, accel, distance)

    def set_lock(self, lock: str, engaged: bool) -> StateChange | None:
        """Engage or release a lock; the event is added to the common log."""
        self.order.command("set_lock", self.epoch)
        lock_of(self.system, lock)
        owner = next(p for p in self.parts if any(x.name == lock for x in p.given.locks))
        event = self._stop(owner).set_lock(lock, engaged)
        self.log += logged(self._stopped)
        return event

    def hook(self, rope: str, a: Vector | None = None, b: Vector | None = None, L0: float | None = None) -> None:
        """Hook a rope; a rope between two islands joins them into one."""
        self.order.command("hook", self.epoch)
        if rope in self.loose:
            self._stop_all()
            self._cut(self.loose - {rope})
        super().hook(rope, a, b, L0)

    def snapshot(self) -> Snapshot:
        """Return the complete state from which the run can continue."""
        self.order.check_begun()
        parts = [{"of": p.snapshot(), "cuts": p.cuts.kept(), "noted": p.merged[1]} for p in self.parts]
        return {
            "parts": parts,
            "loose": sorted(self.loose),
            "common": copied(read(self, KEPT)),
            "lifts": [list(lift.rows) for lift in self.lifts],
        }

    def restore(self, snapshot: Snapshot) -> None:
        """Continue, bit for bit, from a snapshot of started islands of the same system and options."""
        self.order.check_begun()
        if not isinstance(snapshot, dict) or "parts" not in snapshot:
            raise foreign()
        if self.loose != (loose := frozenset(snapshot["loose"])):
            self._cut(loose)
        if len(self.parts) != len(snapshot["parts"]):
            raise foreign()
        for p, part in zip(self.parts, snapshot["parts"], strict=True):
            p.restore(part["of"])
            p.cuts.go_on(part["cuts"])
            p.merged = len(p.log), part["noted"]
        write(self, copied(snapshot["common"]))
        for lift, rows in zip(self.lifts, snapshot["lifts"], strict=True):
            lift.rows[:] = rows
        self._stopped, self._soonest = [], None
