"""The action list carried out at rest: the DEVS models of a scene around its equilibrium path.

Commander, cranes, loaders, block and mechanisms are those of a run; in place of the kernel stands the path, on which
time goes on, but nothing swings.  So each verb, condition and switch means here what it means in a run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from heavylift.kernel.analysis.path import EquilibriumPath
from heavylift.kernel.methods.at_rest import AtRest
from heavylift.kernel.errors import HeavyliftError, KernelError
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.switching import StateEvent as Switched
from heavylift.nodes.devs import Coupled, Event, Out, Simulator, Tag, ns, succ
from heavylift.nodes.models import COMMANDER, KERNEL, CommanderModel, build, couplings, subscriptions, system
from heavylift.nodes.models import messages as m
from heavylift.nodes.models.inputs import obey
from heavylift.nodes.scene.plan import Plan

__all__ = ["Rehearsal", "Stretch"]

LAST_NS = 100 * 3600 * 10**9  # simulated time after which a list that has not ended never does


class Models(Coupled):
    """All models of a scene but the kernel, which is reached through the ports of this one."""

    stage = Out(m.Stage)
    finished = Out(m.Finished)

    def __init__(self, plan: Plan) -> None:
        super().__init__(plan.name)
        self.models = build(plan)
        for model in self.models.values():
            self.add(model)
        for source, out, target, into in couplings(plan):
            if target == KERNEL:
                self.connect(self.models[source].ports[out], self.add_out(into, m.KernelInput))
            elif source == KERNEL:
                self.connect(self.add_in(out, m.StateEvent), self.models[target].ports[into])
            else:
                self.connect(self.models[source].ports[out], self.models[target].ports[into])
        self.connect(self.commander.stage, self.stage)
        self.connect(self.commander.finished, self.finished)

    @property
    def commander(self) -> CommanderModel:
        """The model with the action list."""
        model = self.models[COMMANDER]
        assert isinstance(model, CommanderModel)
        return model


@dataclass(frozen=True)
class Stretch:
    """New points of the path, from `first`, that an action (from 1; 0: none yet) has led to."""

    action: int
    first: int


class Rehearsal:
    """Carries out the action list of a plan along the path of its simulation; `why` it stopped, if not at the end."""

    def __init__(self, plan: Plan, simulation: Simulation | None = None) -> None:
        self.plan = plan
        self._hears = subscriptions(plan)
        self.path = EquilibriumPath(simulation or Simulation(system(plan), method=AtRest.name), frozenset(self._hears))
        self.models = Models(plan)
        self.simulator = Simulator(self.models)
        self.why = ""
        self.over = False
        self._last = Tag(-1)

    def walk(self) -> Iterator[Stretch]:
        """Go on to the end of the list, or to where no rest is known; what each step of it has led to."""
        end = LAST_NS if self.plan.end is None else ns(self.plan.end)
        try:
            self.simulator.start()
            happened = self.path.start()
            seen = 0
            while True:
                while happened:
                    happened = self._tell(happened)
                yield Stretch(self.models.commander.actions.index, seen)
                seen = len(self.path.points)
                due = self.simulator.next_time
                if self.over:
                    break
                happened = self.path.run(min(due.t, end))
                if happened:
                    continue
                if self.path.epoch >= end:
                    break
                happened = self._transit(due)
        except HeavyliftError as error:
            self.why = str(error)
        if not self.why and not self.over and self.plan.end is None:
            self.why = self.models.commander.waiting_for()

    def _transit(self, tag: Tag) -> list[Switched]:
        """Let the models speak at a tag; what that changes at rest."""
        said = self.simulator.outputs()
        self.simulator.advance(tag)
        self._last = tag
        inputs = [e for e in said if isinstance(e.value, m.KernelInput)]
        self.over = self.over or any(isinstance(e.value, m.Finished) for e in said)
        before = len(self.path.command.log)
        for e in inputs:
            obey(self.path.command, e.value)
        changed = [x for _, x in self.path.command.log[before:] if x.name in self._hears]
        return [*changed, *self.path.settle()] if inputs else []

    def _tell(self, happened: list[Switched]) -> list[Switched]:
        """Let the models hear what has happened; what they change by that."""
        for e in happened:
            for model in self._hears.get(e.name, ()):
                self.simulator.inject(f"state_{model}", m.StateEvent(e.name, e.what, e.value))
        tag = max(Tag(self.path.epoch), succ(self._last))
        if not self.simulator._staged:
            return []
        due = self.simulator.next_time
        if due <= tag:
            return self._transit(due)
        self.simulator.advance(tag)
        self._last = tag
        return []
