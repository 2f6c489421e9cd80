"""The action list followed statically, with the vibration modes about the equilibrium wherever an observed move changes
its speed."""

from dataclasses import dataclass, field

from heavylift.kernel.analysis.modes import Modes
from heavylift.nodes.models.parts import messages as m
from heavylift.nodes.plan.plan import Plan

from .static_run import StaticRun

At = tuple[int, int]  # numbers of an action and of an order in it, from 0


@dataclass
class MoveModes:
    """The times [ns] at which a move begins and at which it begins to stop, with the vibration modes at these times."""

    times: list[int] = field(default_factory=list)
    modes: list[Modes] = field(default_factory=list)
    speed: float = 0.0


class SignalsOnPath(StaticRun):
    """Follows the action list statically, and records times and vibration modes of the given moves."""

    def __init__(self, plan: Plan, moves: frozenset[At]) -> None:
        super().__init__(plan)
        self._moves = moves
        self.heard: dict[At, MoveModes] = {}
        self._known: tuple[int, Modes] | None = None  # when they were looked at last

    def _execute(self, value: m.KernelInput) -> None:
        if isinstance(value, m.SetProfile):
            jobs = self.models.commander.actions.jobs
            at = next((job.at for job in jobs if job.actor == value.actuator and job.at in self._moves), None)
            if at is not None:
                self._listen(self.heard.setdefault(at, MoveModes()), abs(value.speed))
        super()._execute(value)

    def _listen(self, heard: MoveModes, speed: float) -> None:
        begins, stops = not heard.times, len(heard.times) == 1 and speed < heard.speed
        if begins or stops:
            heard.times.append(self.path.epoch)
            if self._known is None or self._known[0] != self.path.epoch:
                self._known = self.path.epoch, self.path.modes()
            heard.modes.append(self._known[1])
        heard.speed = speed
        self.over = all(at in self.heard and len(self.heard[at].times) > 1 for at in self._moves)
