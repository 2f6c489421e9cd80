"""What a run puts on record: facts, events, samples, protocol traffic, and the energy balance in the result."""

from __future__ import annotations

import platform
import sys
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

import msgspec
from heavylift.kernel.describe import System
from heavylift.nodes.devs import Event, Message, OutPort
from heavylift.nodes.models import KERNEL, NodeModel
from heavylift.nodes.models.messages import StateEvent
from heavylift.nodes.scene.plan import TOLERANCE_OF_ACCURACY, HookRope, Plan, Sling, encode
from heavylift.recordings import Recorder, SampleLayout
from heavylift.recordings.samples import decode_batch

from . import messages as m
from .budget import Budget, Spent, clocked
from .drawing import RopeLines, boxes
from .energy import EnergyAudit

if TYPE_CHECKING:
    from heavylift.nodes.scene import LoadedScene

__all__ = ["Record", "Result", "rated"]


@dataclass(frozen=True)
class Result:
    """How a run ended: times and what they went into (`budget`, known when all nodes are gone), digest, per rope (peak
    tension [N], when [s]), how well the energy closes, and what the action list still waited for when a time bound
    ended the run ("" = nothing)."""

    sim_s: float
    wall_s: float
    digest: str
    peaks: dict[str, tuple[float, float]]
    energy_error: float
    energy_turned_over: float
    grants: int
    unfinished: str
    budget: Budget = field(default_factory=Budget)


class Record(Spent):
    """Recorder, digest, peaks and energy audit of one run; a context manager that finishes the file in any case."""

    def __init__(self, scene: LoadedScene, models: dict[str, NodeModel], output: Path) -> None:
        self._plan = plan = scene.plan
        self._energy: EnergyAudit | None = None
        self._layout = SampleLayout([])
        self._last_ns = 0
        self._ropes = RopeLines([])
        carried = {r.carries: r.name for r in plan.rig.hook_ropes}
        facts = {
            "scene": plan.name,
            "seed": plan.seed,
            "accuracy": f"{100 * plan.tolerance / TOLERANCE_OF_ACCURACY:.6g} %",
            "tolerance": f"{plan.tolerance:.6g}",
            "method": plan.method,
            **({"step": f"{plan.step:.6g} s"} if plan.step else {}),
            "samples_hz": plan.samples_hz,
            "nodes": [*models, KERNEL],
            "rated": rated(plan),
            "loaders": {x.name: carried[x.name] for x in plan.loaders if x.name in carried},
            "python": sys.version.split()[0],
            "platform": platform.platform(),
        }
        attachments = {scene.path.name: scene.text.encode(), "resolved.json": encode(plan)}
        self._recorder = Recorder(output, facts, attachments)
        for name, model in models.items():
            for port in model.ports.values():
                if isinstance(port, OutPort):
                    self._port(name, port.name, port.type)
            self._port(KERNEL, f"state_{name}", StateEvent)

    def _port(self, model: str, port: str, type_: type[Message]) -> None:
        self._recorder.add_port(model, port, msgspec.json.schema(type_), f"event/{model}/{port}")

    def layout(self, data: bytes, systems: list[System]) -> None:
        """The kernel's sample columns, and what of the mechanics can be drawn."""
        self._layout = msgspec.msgpack.decode(data, type=SampleLayout)
        self._energy = EnergyAudit(self._layout)
        self._recorder.layout(self._layout)
        self._recorder.boxes(boxes(self._plan, systems))
        self._ropes = RopeLines(systems)
        self._recorder.ropes(0, self._ropes.drawn())

    @clocked
    def event(self, e: Event) -> None:
        """A committed event, in total order."""
        self._last_ns = max(self._last_ns, e.t)
        self._recorder.event(e.t, e.k, e.source, e.port, e.index, e.type, e.payload)
        if self._ropes.change(e):
            self._recorder.ropes(e.t, self._ropes.drawn())

    @clocked
    def samples(self, batch: bytes) -> int:
        """A batch of the kernel; returns the time of its last sample [ns]."""
        self._recorder.samples(batch)
        rows = decode_batch(batch, self._layout.width)
        if self._energy is not None:
            self._energy.add(rows.rows)
        self._last_ns = max(self._last_ns, rows.times[-1])
        return rows.times[-1]

    @clocked
    def settle(self, t_ns: int) -> None:
        """Nothing before this time comes any more: what waits below it may be written."""
        self._recorder.settle(t_ns)

    @clocked
    def protocol(self, t_ns: int, node: str, direction: str, message: m.AnyMessage, data: bytes) -> None:
        """A message of the time protocol; outside the digest."""
        kind = type(message).__name__.upper()
        self._recorder.protocol(t_ns, node, direction, kind, _summary(message), data)

    def failed(self, message: m.Fail) -> None:
        """A node cannot go on: its traceback belongs to the record, not on the user's screen."""
        self._recorder.log(message.tag.t, "error", message.path, f"{message.sentence}\n{message.traceback}")

    @clocked
    def finish(self, grants: int, wall_s: float, unfinished: str) -> Result:
        """Close the recording."""
        audit = self._energy
        result = Result(
            sim_s=self._last_ns * 1e-9,
            wall_s=wall_s,
            digest=self._recorder.digest.hexdigest(),
            peaks={name: (p.tension, p.time) for name, p in self._recorder.peaks.items()},
            energy_error=audit.error if audit else 0.0,
            energy_turned_over=audit.turned_over if audit else 0.0,
            grants=grants,
            unfinished=unfinished,
        )
        facts: dict[str, object] = {"sim_s": result.sim_s, "wall_s": wall_s, "grants": grants, "unfinished": unfinished}
        facts |= {"energy_error": result.energy_error, "energy_turned_over": result.energy_turned_over}
        self._recorder.close("finished", "", facts)
        return result

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is not None:
            self._recorder.close("failed", str(error) or type(error).__name__)


def rated(plan: Plan) -> dict[str, float]:
    """Tension that counts as 100 % of use, per rope [N]; ropes without one are left out."""
    ropes: list[HookRope | Sling] = [*plan.rig.hook_ropes, *plan.rig.slings]
    return {r.name: r.rated for r in ropes if r.rated}


def _summary(message: m.AnyMessage) -> dict[str, object]:
    match message:
        case m.Grant():
            return {
                "gseq": message.gseq,
                "until": message.until,
                "inputs": len(message.inputs),
                "committed": message.committed,
            }
        case m.Done():
            return {
                "gseq": message.gseq,
                "next": message.next,
                "spoken": len(message.spoken),
                "offer": len(message.offer),
            }
        case m.Hello():
            return {"next": message.next, "lookahead": message.lookahead}
        case m.Fail():
            return {"tag": message.tag, "sentence": message.sentence}
        case m.Stop():
            return {"end": message.end, "why": message.why}
    return {}
