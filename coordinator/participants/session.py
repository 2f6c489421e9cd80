"""A run of a plan in this process and thread: it can be advanced step by step, given orders, and inspected in between.

One node has commander and machines, another the kernel, and each model of a user's own is one; they run in lockstep. No
file, no bus, no other process, no bytes; the digest is that of any run. Outputs of models are not checked for side
effects: `run` does that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Generic, NamedTuple, TypeVar

from heavylift.coordinator.protocol.messages import RunEnd
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import FOREVER, Event, Simulator, Steppable, Tag, seconds
from heavylift.nodes.models import COMMANDER, KERNEL, NodeModel, build, driving, goes_on, taken_over
from heavylift.nodes.plan.plan import Plan

from .configuration import PATIENCE_ns, Wiring, kernel_config, postponed, wiring
from .kernel_node import KernelNode
from .lockstep import Lockstep
from .parts import KernelConfig

Kernel = TypeVar("Kernel", bound=KernelNode)


def configured(plan: Plan, models: Mapping[str, NodeModel]) -> KernelConfig:
    """Return the kernel's configuration for a plan, with the mechanics that its models declare."""
    return kernel_config(plan, models, (m.declare() for m in models.values()))


class Session(Generic[Kernel]):
    """A run of a plan in this process, without messages between processes."""

    def __init__(
        self,
        plan: Plan,
        make: Callable[[KernelConfig], Kernel],
        hear: Callable[[Event], None] = lambda event: None,
        end: Tag | None = None,
    ) -> None:
        """`make` creates the kernel from its configuration; `hear` receives committed events; `end` replaces the end of
        the plan. A plan without an end is extended while a driving model is scheduled."""
        self._built = built = _spare(plan) or _Built.of(plan)
        self.models, self.config = built.models, built.config
        self.kernel = make(self.config)
        self._hear, self._plan = hear, plan
        self._patient = end is None and plan.end is None
        end = end or Tag(PATIENCE_ns if plan.end is None else seconds(plan.end))
        wires, homes = built.wires, built.homes
        nodes: dict[str, Steppable] = {**built.acting, KERNEL: self.kernel}
        self.core = Lockstep(
            nodes, wires.couplings, end, wires.finish, self._heard, wires.outside, plan.microsteps, homes
        )

    def _heard(self, event: Event) -> None:
        if self._patient and goes_on(event):
            self.core.extend(Tag(event.t + PATIENCE_ns))
        self._hear(event)

    def advance(self, until: Tag = FOREVER) -> RunEnd | None:
        """Process all events before a logical time; return why the run is over, or None. Raises HeavyliftError."""
        outcome = self.core.advance(until)
        while self._patient and postponed(self.core, self._plan):
            outcome = self.core.advance(until)
        return outcome

    def finish(self, end: Tag) -> str:
        """Advance the kernel to `end`, and return the conditions for which models still wait, as text.

        Raises ModelError with this text if the plan has no end time and its action list has not finished.
        """
        self.kernel.finish(end)
        waiting = [text for model in self.models.values() if (text := str(getattr(model, "waiting_for", str)()))]
        if waiting and self._patient and self.core.over is not RunEnd.FINISHED:
            raise ModelError(waiting[0])
        if not self._plan.models:  # whose state may be anywhere
            _SPARE[:] = [self._built]
        return "; ".join(waiting)


class _Built(NamedTuple):
    """The models of a plan in their simulators, which `start` brings to their initial states again."""

    plan: Plan
    models: dict[str, NodeModel]
    config: KernelConfig
    wires: Wiring
    homes: dict[str, list[str]]
    acting: dict[str, Simulator]

    @classmethod
    def of(cls, plan: Plan) -> _Built:
        models, wires, shared = build(plan), wiring(plan), driving(plan)
        homes = {COMMANDER: [*dict.fromkeys(shared)], **{n: [n] for n in models if n not in shared}}
        acting = {
            n: Simulator([models[m] for m in own], microsteps=plan.microsteps, watched=False, wires=wires.all)
            for n, own in homes.items()
        }
        return cls(plan, models, configured(plan, models), wires, homes, acting)


_SPARE: list[_Built] = []  # of the last run that came to its end, for the next one of a plan of equal structure


def _spare(plan: Plan) -> _Built | None:
    """Take the models of a plan of equal structure whose run is over, if they are still there; threads take them
    once."""
    with suppress(IndexError):
        built = _SPARE.pop()
        if built.plan == plan:
            return built
        if taken_over(built.models, built.plan, plan):
            return built._replace(plan=plan, config=configured(plan, built.models))
    return None
