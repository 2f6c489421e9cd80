"""The models of a recorded run, built again by the code that is installed now.

A run of a scene attaches its plan: machines, commander, and the kernel.  A run of any other
DEVS model names the function that built it: its children.  A model is asked for by kind and name, such as crane/west,
or by its name alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from heavylift.coordinator.participants import building
from heavylift.coordinator.participants.configuration import Wiring, wiring
from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.coordinator.participants.session import configured
from heavylift.coordinator.record.scene import RESOLVED
from heavylift.kernel.errors import UNREADABLE, RecordingError
from heavylift.kernel.trust import demand
from heavylift.kernel.version import __version__, again
from heavylift.nodes.devs import Model, OutPort, Simulator, Steppable
from heavylift.nodes.devs.execution.rules import LIMIT
from heavylift.nodes.models import COMMANDER, KERNEL, build, build_one
from heavylift.nodes.plan.plan import Mechanism, Plan, decode, functions
from heavylift.nodes.plan.spellings import BEAM
from heavylift.recordings import Recording


@dataclass(frozen=True)
class RecordedModels:
    """Who takes part: nodes by the name that a user gives, how they are wired, who ends the run, and how each is made.

    `make(name, publish)` starts afresh; `publish` gets the sample batches of the kernel.
    """

    models: dict[str, str]
    wiring: Wiring
    make: Callable[[str, Callable[[bytes], None]], Steppable] = field(repr=False)
    microsteps: int = LIMIT

    @property
    def nodes(self) -> list[str]:
        """All nodes."""
        return list(self.models.values())

    def node(self, name: str) -> str:
        """The node that a user means; RecordingError if there is none."""
        if name in self.models or name in self.models.values():
            return self.models.get(name, name)
        raise RecordingError(f"there is no model {name} in it, it has {', '.join(self.models)}")


def cast_of(rec: Recording) -> RecordedModels:
    """The models of a recording; RecordingError if they cannot be built any more."""
    if RESOLVED in rec.attachments:
        try:
            plan = decode(rec.attachments[RESOLVED])
            demand(functions(plan), f"{rec.path}")
            with rec.reading():  # a plan may be readable and yet make no sense
                return _of_plan(plan)
        except UNREADABLE as error:
            raise RecordingError(
                f"{rec.path}: heavylift {__version__} cannot run its scene ({error}); {again(rec.version)}"
            ) from None
    if "model" in rec.run:
        return _of_model(rec.run["model"], f"{rec.path}", _microsteps(rec), str(rec.fact("stop", "")))
    raise RecordingError(f"{rec.path}: has no scene attached to simulate again; record it with `heavylift run`")


def _of_plan(plan: Plan) -> RecordedModels:
    found = {f"{_kind(x)}/{x.name}" if _kind(x) else x.name: x.name for x in plan.machines}
    found |= {f"model/{x.name}": x.name for x in plan.models}

    def make(name: str, publish: Callable[[bytes], None]) -> Steppable:
        if name == KERNEL:
            return KernelNode(configured(plan, build(plan)), publish)
        return _alone(build_one(plan, name), wires, plan.microsteps)

    wires = wiring(plan)
    return RecordedModels({**found, COMMANDER: COMMANDER, KERNEL: KERNEL}, wires, make, plan.microsteps)


def _kind(machine: Mechanism) -> str:
    """By which word a machine is asked for beside its name; none of what is lifted alone."""
    if not machine.levels:
        return "mechanism"
    return "crane" if machine.hooks or machine.girders else "" if machine.cargo else BEAM


def _of_model(reference: str, by: str, microsteps: int, stop: str) -> RecordedModels:
    model = building.built(reference, by)
    wires = Wiring(building.couplings(model), [], building.stopping(model, stop))

    def make(name: str, publish: Callable[[bytes], None]) -> Steppable:
        return _alone(building.with_children(reference, [name], by).children[name], wires, microsteps)

    return RecordedModels({name: name for name in model.children}, wires, make, microsteps)


def _alone(model: Model, wires: Wiring, microsteps: int) -> Simulator:
    """A model that tells all that it says as if others heard it."""
    said = [(model.name, port.name, "", "") for port in model.ports.values() if isinstance(port, OutPort)]
    return Simulator(model, microsteps=microsteps, wires=[*wires.all, *said])


def _microsteps(rec: Recording) -> int:
    """How many tags without time between them were allowed."""
    found = rec.fact("microsteps", LIMIT)
    if type(found) is not int or found < 1:
        raise RecordingError(f"{rec.path}: it allows {found!r} microsteps, which is no number of them; run it again")
    return found
