"""Recording of the run of a scene: facts, samples, drawn shapes and the energy balance, in addition to the record of
any run.

What each rope of a recorded lift would carry at rest: tensions of the equilibrium path at the times of the run.
"""

import time
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np
from heavylift.coordinator import verdict as verdicts
from heavylift.coordinator.live.pace import Lateness
from heavylift.coordinator.participants.configuration import COMMAND, OPERATOR
from heavylift.coordinator.protocol import messages as m
from heavylift.coordinator.transport.placement import Placement
from heavylift.coordinator.verdict.conduct import Conduct, conduct_of
from heavylift.coordinator.verdict.history import Collector
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import UNREADABLE, HeavyliftError, ProtocolError, path_text
from heavylift.nodes.devs import Event, OutPort
from heavylift.nodes.limits.named import rated
from heavylift.nodes.models import KERNEL, NodeModel, sample_port, system
from heavylift.nodes.models.parts.messages import OperatorCommand, Sample, StateEvent
from heavylift.nodes.plan.plan import decode, encode
from heavylift.nodes.statics import follow
from heavylift.recordings import Recording, SampleLayout, Spectator
from heavylift.recordings.format.samples import Batch, decode_batch
from heavylift.recordings.read.verdict import RecordedVerdict
from heavylift.recordings.render.foxglove import LAYOUT, layout
from numpy.typing import NDArray

from .drawing import RopeLines, boxes, surroundings
from .facts import EnergyAudit, facts_of
from .run_record import Budget, FileRecorder, Held, clocked

if TYPE_CHECKING:
    from heavylift.nodes.scene import LoadedScene

RESOLVED = "resolved.json"  # the plan
SILENT_s = 0.4  # wall time after which samples that were foretold are taken
REST = 4096  # of them at once
MERGED = "merged.json"  # the whole scene, where its own text is not all of it


@dataclass(frozen=True)
class RunResult:
    """Results of a recorded run: simulated and wall time [s], digest, peak rope tensions [N], verdict, path of the
    recording.

    Also the error of the energy balance, number of grants, conditions for which the action list still waited at the
    time bound, `budget` of the wall time, lateness in real time, and notes of the kernel.
    """

    sim_s: float
    wall_s: float
    digest: str
    peaks: dict[str, tuple[float, float]]
    energy_error: float
    energy_turned_over: float
    grants: int
    unfinished: str
    budget: Budget = field(default_factory=Budget)
    lateness: Lateness | None = None
    notes: tuple[str, ...] = ()
    verdict: RecordedVerdict | None = None
    recording: Path = Path()
    promised: dict[str, object] = field(default_factory=dict)  # asked (nothing: tensions), accuracy, measured errors


class Record(FileRecorder):
    """The recording of one run of a scene, with peak tensions and an energy audit."""

    def __init__(
        self,
        scene: "LoadedScene",
        models: dict[str, NodeModel],
        output: Path,
        placement: Placement,
        page: Spectator,
        force: bool = False,
        more: Mapping[str, object] | None = None,
    ) -> None:
        """Create the recording. `more`: additional facts known at the start."""
        self._page = page
        self._plan = plan = scene.plan
        self._energy: EnergyAudit | None = None
        self._errors = scene.errors
        self._layout = SampleLayout([])
        self._ropes = RopeLines([])
        facts = facts_of(scene, [*models, KERNEL], placement) | dict(more or {})
        attachments = {path_text(scene.path.name): scene.text.encode(), RESOLVED: encode(plan)}
        attachments |= {MERGED: scene.merged.encode()} if scene.merged else {}
        attachments[LAYOUT] = layout([r.name for r in system(plan, models).all_ropes], *surroundings(plan))
        self._facts: dict[str, object] = facts
        measured = dict(scene.answer.errors) if scene.answer else {}
        self._promised = {"asked": list(scene.facts.ask), "accuracy": scene.facts.accuracy, "measured": measured}
        self._conduct = Conduct(shortfall=scene.answer.notes if scene.answer else ())
        self._collector = Collector(self._layout)
        self._seen, self._seen_at = 0, time.monotonic()  # samples, and when the last of them came [s]
        self._foretold: Batch | None = None  # what comes until the kernel is told something
        super().__init__(output, facts, attachments, force)
        for name, model in models.items():
            for port in model.ports.values():
                if isinstance(port, OutPort):
                    self.port(name, port.name, port.type)
            self.port(KERNEL, f"state_{name}", StateEvent)
        for own in plan.models:
            for heard in own.signals:
                self.port(KERNEL, sample_port(own.name, heard), Sample)
        self.port(OPERATOR, COMMAND, OperatorCommand)

    def layout(self, data: bytes, systems: list[System]) -> None:
        """Set the columns of samples from the kernel's layout, and the drawn shapes."""
        try:
            self._layout = msgspec.msgpack.decode(data, type=SampleLayout)
        except UNREADABLE as error:
            raise ProtocolError(
                f"the kernel's list of samples cannot be decoded ({error}); use the same version everywhere"
            ) from None
        self._energy = EnergyAudit(self._layout)
        self.recorder.layout(self._layout)
        drawn = boxes(self._plan)
        self.recorder.boxes(drawn)
        self._ropes = RopeLines(systems)
        self.recorder.ropes(0, self._ropes.drawn())
        self._collector = Collector(self._layout)
        self._collector.ropes(0, self._ropes.drawn())
        self._page.begin(self._facts, self._layout, drawn, self._ropes.drawn())

    def event(self, e: Event) -> None:
        """Record a committed event, and update rope lines and viewers; events must arrive in total order."""
        super().event(e)
        self._page.event(e.t, e.source, e.port, e.type, e.payload)
        self._conduct.event(e)
        if self._ropes.change(e):
            self.recorder.ropes(e.t, self._ropes.drawn())
            self._collector.ropes(e.t, self._ropes.drawn())
            self._page.ropes(e.t, self._ropes.drawn())

    @clocked
    def samples(self, node: str, batch: bytes) -> int:
        """Record a batch of the kernel's samples; return the time of the last sample [ns]."""
        found = decode_batch(batch, self._layout)
        if found.lift:
            self.recorder.samples(batch)
            return self.last_ns
        if found.period:
            self._foretold = found if found.first == self._seen else self._foretold  # not that of a successor
            return self.last_ns
        self.recorder.samples(batch)
        if (skip := self._seen - found.first) < len(found.times):
            times, rows = found.times[skip:], found.rows[skip:]
            if self._energy is not None:
                self._energy.add(rows)
            self._collector.samples(self._seen, times, rows)
            self._page.samples(times, rows)
            self._seen, self._seen_at = self._seen + len(times), time.monotonic()
            self.last_ns = max(self.last_ns, times[-1])
        return found.times[-1]

    def settle(self, t_ns: int) -> None:
        """Write the data before this simulation time [ns], including samples that the kernel has announced in advance.

        During a long rest the kernel sends nothing; so a crash loses no more than about a second.
        """
        if self._foretold is not None and time.monotonic() - self._seen_at > SILENT_s:
            known, period = self._foretold, self._foretold.period
            new = range(self._seen - known.first, bisect_left(known.times, t_ns))
            for i in new:
                self._take_foretold([known.times[i]], known.rows[i])
            after = self._seen - known.first - len(known.times) + 1
            times = range(known.times[-1] + after * period, t_ns, period) if after > 0 else range(0)
            for i in range(0, len(times), REST):
                self._take_foretold(times[i : i + REST], known.rows[-1])
        super().settle(t_ns)

    def _take_foretold(self, times: Sequence[int], row: NDArray[np.float64]) -> None:
        self.samples(KERNEL, msgspec.msgpack.encode((self._seen, list(times), row.astype("<f8").tobytes())))

    def protocol(
        self, t_ns: int, node: str, direction: str, message: m.AnyMessage, data: bytes, held: Held = ()
    ) -> None:
        """Record a message of the time protocol; a message to the kernel cancels the samples that the kernel has
        published in advance."""
        super().protocol(t_ns, node, direction, message, data, held)
        if node == KERNEL and direction == "to node":
            self._foretold = None

    def finish(self, grants: int, wall_s: float, unfinished: str, lateness: Lateness | None = None) -> RunResult:
        """Finish the recording and return the result of the run."""
        audit = self._energy
        result = RunResult(
            sim_s=self.last_ns * 1e-9, wall_s=wall_s, digest=self.recorder.digest.hexdigest(),
            peaks={name: (p.tension, p.time) for name, p in self.recorder.peaks.items()},
            energy_error=audit.error if audit else 0.0, energy_turned_over=audit.turned_over if audit else 0.0,
            grants=grants, unfinished=unfinished, lateness=lateness, notes=tuple(self.notes), promised=self._promised,
        )  # fmt: skip
        text = self._conduct
        text.peaks, text.end, text.unfinished = result.peaks, result.sim_s, result.unfinished
        result = replace(result, verdict=self._verdict())
        facts: dict[str, object] = {"sim_s": result.sim_s, "wall_s": wall_s, "grants": grants, "unfinished": unfinished}
        facts |= {"energy_error": result.energy_error, "energy_turned_over": result.energy_turned_over}
        facts["verdict"] = msgspec.to_builtins(result.verdict)
        if lateness is not None:
            facts["lateness"] = lateness._asdict()
        self.close(facts)
        result = replace(result, recording=self.recorder.path)
        self._end_for_all(
            "finished", {"digest": result.digest, "verdict": result.verdict.line if result.verdict else ""}
        )
        return result

    def _verdict(self) -> RecordedVerdict:
        """Compute the verdict; the recording is finished even if this fails."""
        text = self._conduct
        text.notes = [(note.t_ns * 1e-9, note.sentence) for note in self.recorder.notes]
        try:
            return verdicts.verdict_of_run(self._plan, self._collector, text, self._errors)
        except Exception as error:
            message = f"red: no verdict could be made, which is a defect of heavylift ({type(error).__name__}: {error})"
            return RecordedVerdict(red=True, state="red", line=message)

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        result = {"reason": str(error)}
        try:
            if isinstance(error, HeavyliftError) and not self.worthless():
                error.verdict = verdict = self._verdict_of_failure(error)
                self.facts = {"verdict": msgspec.to_builtins(verdict)}
                result["verdict"] = verdict.line
        finally:
            super().__exit__(kind, error, trace)
        if error is not None:
            self._end_for_all("failed", result)

    def _verdict_of_failure(self, error: HeavyliftError) -> RecordedVerdict:
        text = self._conduct
        text.status, text.reason, text.end = "failed", str(error), self.last_ns * 1e-9
        text.peaks = {name: (p.tension, p.time) for name, p in self.recorder.peaks.items()}
        return self._verdict()

    def _end_for_all(self, status: str, message: dict[str, str]) -> None:
        limits = rated(self._plan)
        peaks = [
            {"name": name, "tension": p.tension, "time": p.time, "rated": limits.get(name)}
            for name, p in self.recorder.peaks.items()
        ]
        self._page.end(status, message, peaks, str(self.recorder.path))


StaticTensions = tuple[NDArray[np.float64], NDArray[np.float64]]  # (n,) times [s], (n,) tensions at rest [N]


def at_rest(rec: Recording) -> dict[str, StaticTensions]:
    """Return the tension of each rope along the statically computed action list; empty for a recording without a plan.

    The equilibrium path has the times of actions without inertia, the run the actual times: the path's time is
    stretched between the beginnings of actions.
    """
    try:
        plan = decode(rec.attachments[RESOLVED])
        path = follow(plan)
    except (KeyError, HeavyliftError, *UNREADABLE):
        return {}
    began = {number: t for t, number, _ in reversed(conduct_of(rec).stages)}
    known = [(acted.t, began[i]) for i, acted in enumerate(path.acted) if i in began]
    if plan.lists or not known or not path.states:
        return {}
    ends = (path.states[-1].t, known[-1][1] + path.states[-1].t - known[-1][0])
    nominal, actual = np.array([*known, ends]).T
    t = np.interp([state.t for state in path.states], nominal, actual)
    ropes = path.states[0].tensions
    return {rope: (t, np.array([state.tensions[rope] for state in path.states])) for rope in ropes}
