"""A run of a plan in this process and thread: it can be advanced step by step, given orders, and inspected in between.

One node has commander and machines, another the kernel; the time protocol runs between them. No file, no bus, no other
process; the digest is that of any run. Outputs of models are not checked for side effects: `run` does that.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

from heavylift.coordinator.protocol.messages import Bye, Fail, Grant, GrantDone, Hello, RunEnd, StopRun
from heavylift.coordinator.protocol.node import Node
from heavylift.coordinator.protocol.outside import OpenCoordinator
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import FOREVER, Event, Simulator, Tag, seconds
from heavylift.nodes.models import COMMANDER, KERNEL, NodeModel, build, driving, goes_on
from heavylift.nodes.plan.plan import Plan

from .configuration import PATIENCE_ns, kernel_config, postponed, wiring
from .kernel_node import KernelNode
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
        self.models = models = build(plan)
        self.config = configured(plan, models)
        self.kernel = make(self.config)
        self.grants, self._hear, self._plan = 0, hear, plan
        self._patient = end is None and plan.end is None
        end = end or Tag(PATIENCE_ns if plan.end is None else seconds(plan.end))
        wires, most = wiring(plan), plan.microsteps
        shared = driving(plan)  # one node: what they say to each other needs no grants
        homes = {COMMANDER: [*dict.fromkeys(shared)], **{n: [n] for n in (*models, KERNEL) if n not in shared}}
        self.core = OpenCoordinator(homes, wires.couplings, end, wires.finish, self._heard, wires.outside, most, homes)
        acting = {n: [models[m] for m in own] for n, own in homes.items() if n != KERNEL}
        self._nodes = {
            n: Node(n, Simulator(own, microsteps=most, watched=False, wires=wires.all), hashed=False)
            for n, own in acting.items()
        } | {KERNEL: Node(KERNEL, self.kernel, self.kernel.finish, hashed=False)}
        for name, node in self._nodes.items():
            hello = node.hello()
            if not isinstance(hello, Hello):
                raise ModelError(hello.sentence) from node.cause
            self.core.hello(name, hello)

    def _heard(self, event: Event) -> None:
        if self._patient and goes_on(event):
            self.core.extend(Tag(event.t + PATIENCE_ns))
        self._hear(event)

    def advance(self, until: Tag = FOREVER) -> RunEnd | None:
        """Process all events before a logical time; return why the run is over, or None. Raises HeavyliftError."""
        answers: list[tuple[str, GrantDone]] = []
        while True:
            for name, grant in self.core.ready(until):
                answers.append((name, self._granted(name, grant)))
                self.grants += 1
            if answers:
                self.core.done(*answers.pop())
            elif not (self._patient and postponed(self.core, self._plan)):
                return self.core.over

    def _granted(self, name: str, grant: Grant) -> GrantDone:
        """Grant a node and return its DONE; raises the error of a FAIL."""
        node = self._nodes[name]
        text = node.handle(grant)
        if isinstance(text, Fail):
            raise self.core.failed(name, text) from node.cause
        assert isinstance(text, GrantDone)
        return text

    def finish(self, end: Tag) -> str:
        """Advance the kernel to `end`, and return the conditions for which models still wait, as text.

        Raises ModelError with this text if the plan has no end time and its action list has not finished.
        """
        bye = self._nodes[KERNEL].handle(StopRun(end))
        if not isinstance(bye, Bye):
            raise ModelError(getattr(bye, "sentence", f"{KERNEL} answered STOP with {bye!r}"))
        waiting = [text for model in self.models.values() if (text := str(getattr(model, "waiting_for", str)()))]
        if waiting and self._patient and self.core.over is not RunEnd.FINISHED:
            raise ModelError(waiting[0])
        return "; ".join(waiting)
