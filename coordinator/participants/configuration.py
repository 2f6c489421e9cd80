"""Couplings between a plan's models, and the kernel's configuration; both are the same wherever the models run."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from heavylift.coordinator.protocol.distance import Coupling
from heavylift.coordinator.protocol.messages import RunEnd
from heavylift.coordinator.protocol.outside import OpenCoordinator
from heavylift.kernel.description.forces import Wind
from heavylift.kernel.description.mechanics import System
from heavylift.nodes.devs import FOREVER, Tag
from heavylift.nodes.models import COMMANDER, KERNEL, NodeModel, couplings, driving, hooked_later, subscriptions
from heavylift.nodes.models.user_models import OUTSIDE, aim_port
from heavylift.nodes.plan.plan import Plan

from .lockstep import Lockstep
from .parts import KernelConfig, SignalSubscription

PATIENCE_ns = 4 * 3600 * 10**9  # simulated time without an order after which a scene without an end is stuck: a load
# that swings undamped never comes to rest, and a run must not go on for ever

OPERATOR, COMMAND = "operator", "command"  # source and port of the events that commands are
WIND = "wind"  # port of the events that set its speed


class Wiring(NamedTuple):
    """All couplings of a run: between nodes, from operators to nodes, and from nodes to the coordinator."""

    couplings: list[Coupling]
    outside: list[Coupling]
    finish: tuple[str, str] | None
    message: tuple[tuple[str, str], ...] = ()
    """Ports (model, port) without a receiving model, whose messages the observers of the run receive at once."""

    @property
    def all(self) -> list[Coupling]:
        """All couplings of a run: between nodes, from operators to nodes, and from nodes to the coordinator."""
        message = (*self.message, *([self.finish] if self.finish else []))
        return [*self.couplings, *self.outside, *(Coupling(*port, "", "") for port in message)]


def wiring(plan: Plan) -> Wiring:
    """Return the couplings between the models of a plan."""
    wires = [Coupling(*wire) for wire in couplings(plan)]
    notices = tuple((COMMANDER, port) for port in ("answer", "skipped", "stage"))
    outside = [Coupling(OPERATOR, COMMAND, COMMANDER, COMMAND)]
    for own in (own for own in plan.models if own.model == OUTSIDE):
        ports = [aim_port(own.name, led.port) for led in own.leads]
        outside += [Coupling(OPERATOR, port, COMMANDER, port) for port in ports]
    outside += [Coupling(OPERATOR, WIND, KERNEL, WIND)] if driven_winds(plan) else []
    return Wiring(wires, outside, (COMMANDER, "finished"), notices)


def driven_winds(plan: Plan) -> dict[str, float]:
    """Return the wind forces whose wind speed is an input from outside the run, each with its initial speed [m/s]."""
    forces = (f for machine in plan.machines for f in machine.system.forces)
    return {f.name: f.signal.value for f in forces if isinstance(f, Wind) and f.signal.driven}


def kernel_config(plan: Plan, models: Mapping[str, NodeModel], systems: Iterable[System]) -> KernelConfig:
    """Return the kernel's configuration for a plan, its models and their declared mechanics."""
    declared = dict(zip(models, systems, strict=True))
    return KernelConfig(
        [*declared.values()],
        plan.gravity,
        plan.tolerance,
        round(1e9 / plan.samples_hz),
        {element: list(hearing) for element, hearing in subscriptions(plan, models).items()},
        plan.method,
        plan.step,
        hooked_later(plan),
        plan.fidelity.islands == "apart",
        {own.name: SignalSubscription(own.period, own.signals) for own in plan.models},
        {
            x.name: [b.name for machine in x.machines for b in declared[machine].bodies]
            for x in plan.lists
            if x.machines
        },
    )


def postponed(core: OpenCoordinator | Lockstep, plan: Plan) -> bool:
    """Postpone the end of a run without a stated end while models that give orders have events; return whether it was.

    A load that only swings does not count.
    """
    if plan.end is not None or core.over is not RunEnd.BOUND or (due := core.scheduled(driving(plan))) >= FOREVER:
        return False
    core.extend(Tag(due.t + PATIENCE_ns))
    return True
