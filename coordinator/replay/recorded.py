"""Models and events of a recorded run, events with their canonical bytes.

The values of events, JSON in the file, are decoded into their message classes and encoded again. The models are built
by the installed code: of a scene from its attached plan, of another DEVS model by the function that it names. A
recording is refused if this version does not know its models or messages. Users name a model by kind and name, such as
crane/west, or by its name alone.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import msgspec
from heavylift.coordinator.participants import building
from heavylift.coordinator.participants.configuration import Wiring, wiring
from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.coordinator.participants.rows import RowFrames
from heavylift.coordinator.participants.session import configured
from heavylift.coordinator.protocol.messages import RunEnd
from heavylift.coordinator.record.scene import RESOLVED
from heavylift.kernel.errors import UNREADABLE, ModelError, RecordingError
from heavylift.kernel.trust import demand
from heavylift.kernel.version import __version__, again
from heavylift.nodes.devs import (
    FOREVER,
    Event,
    Model,
    OutPort,
    Simulator,
    Steppable,
    Tag,
    encode,
    message_type,
    seconds,
)
from heavylift.nodes.devs.execution.rules import LIMIT
from heavylift.nodes.models import COMMANDER, KERNEL, build, build_one
from heavylift.nodes.plan.plan import Mechanism, Plan, decode, functions
from heavylift.recordings import RecordedEvent, Recording
from heavylift.recordings.format.spellings import BEAM


@dataclass(frozen=True)
class RecordedModels:
    """The models of a recorded run, with the node of each, their couplings, and the function that rebuilds them.

    `make(name, publish)` builds a new model; `publish` receives the sample batches of the kernel.
    """

    models: dict[str, str]
    wiring: Wiring
    make: Callable[[str, Callable[[bytes], None]], Steppable] = field(repr=False)
    microsteps: int = LIMIT

    @property
    def nodes(self) -> list[str]:
        """Names of all recorded nodes."""
        return list(self.models.values())

    def node(self, name: str) -> str:
        """Return the node with this name; raises RecordingError if there is none."""
        if name in self.models or name in self.models.values():
            return self.models.get(name, name)
        raise RecordingError(f"there is no model {name}; the recording has {', '.join(self.models)}")


def recorded_models(rec: Recording) -> RecordedModels:
    """Build the models of a recording; raises RecordingError if that is no longer possible."""
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
            return KernelNode(configured(plan, build(plan)), RowFrames(publish))
        return _alone(build_one(plan, name), wires, plan.microsteps)

    wires = wiring(plan)
    return RecordedModels({**found, COMMANDER: COMMANDER, KERNEL: KERNEL}, wires, make, plan.microsteps)


def _kind(machine: Mechanism) -> str:
    """Return the kind of a machine as a prefix of its name; "" for a block."""
    if machine.hooks:
        return "crane"
    return "" if machine.cargo else BEAM if any(not tie.rigging for tie in machine.ties) else "mechanism"


def _of_model(reference: str, by: str, microsteps: int, stop: str) -> RecordedModels:
    model = building.built(reference, by)
    wires = Wiring(building.couplings(model), [], building.stopping(model, stop))

    def make(name: str, publish: Callable[[bytes], None]) -> Steppable:
        return _alone(building.with_children(reference, [name], by).children[name], wires, microsteps)

    return RecordedModels({name: name for name in model.children}, wires, make, microsteps)


def _alone(model: Model, wires: Wiring, microsteps: int) -> Simulator:
    """Return a simulator of one model that reports all its outputs as if other nodes received them."""
    outputs = [(model.name, port.name, "", "") for port in model.ports.values() if isinstance(port, OutPort)]
    return Simulator(model, microsteps=microsteps, wires=[*wires.all, *outputs])


def _microsteps(rec: Recording) -> int:
    """Return the allowed number of microsteps from a recording; raises RecordingError if it is invalid."""
    found = rec.fact("microsteps", LIMIT)
    if type(found) is not int or found < 1:
        raise RecordingError(
            f"{rec.path}: its number of microsteps, {found!r}, is not a positive integer; run it again"
        )
    return found


class RecordedRun:
    """A recorded run: its models, events and end."""

    def __init__(self, path: str | Path) -> None:
        self.recording = Recording(path)
        self.path = self.recording.path

    @cached_property
    def cast(self) -> RecordedModels:
        """The models of the recorded run; raises RecordingError if this version cannot build them."""
        return recorded_models(self.recording)

    @cached_property
    def events(self) -> list[Event]:
        """All events of the recorded run in total order."""
        assert self.cast  # their message classes are known when the models are built
        return [self._event(e) for e in self.recording.events()]

    def _event(self, e: RecordedEvent) -> Event:
        try:
            value = msgspec.convert(e.value, message_type(e.type))
        except (*UNREADABLE, ModelError) as error:
            raise RecordingError(
                f"{self.path}: {e.source}.{e.port} at {Tag(e.t_ns, e.microstep)} cannot be read as {e.type} by "
                f"heavylift {__version__} ({error}); {again(self.recording.version)}"
            ) from None
        return Event(e.t_ns, e.microstep, e.source, e.port, e.index, e.type, encode(value))

    @property
    def complete(self) -> bool:
        """Whether the recorded run reached its end, so that its recording is complete."""
        return self.recording.result.get("status") == "finished"

    @property
    def end(self) -> Tag:
        """The logical time up to which the recording is complete."""
        last = self.events[-1].tag if self.events else Tag(0)
        if not self.complete:
            return last
        if self.recording.fact("outcome") == RunEnd.QUIET.value:
            return FOREVER
        return Tag(max(last.t, seconds(float(self.recording.fact("sim_s", 0.0)))) + 1)


def plain(e: RecordedEvent) -> Event:
    """Return a recorded event with its value encoded as plain data, so that its message class is not needed."""
    return Event(e.t_ns, e.microstep, e.source, e.port, e.index, e.type, msgspec.msgpack.encode(e.value))
