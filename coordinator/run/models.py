"""A run of any DEVS model: each child of a coupled model becomes a node, its couplings those of the protocol.

    import heavylift

    if __name__ == "__main__":
        run = heavylift.run_models("my_models:build", until=10.0, output="ring.mcap")

The node processes import the module and take their child by its name, so a fresh interpreter must find the function
under that name. Flat or distributed, in one process or many, a run is the same to the last byte.
"""

import inspect
import time
import warnings
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec
from heavylift.coordinator.hosts.listener import RemoteListener
from heavylift.coordinator.live.command_queue import CommandQueue
from heavylift.coordinator.live.observers import shown
from heavylift.coordinator.live.pace import Tempo
from heavylift.coordinator.participants import NODE_MODULE, parts
from heavylift.coordinator.participants.building import built, couplings, declarations, difference, module, stopping
from heavylift.coordinator.participants.configuration import Wiring
from heavylift.coordinator.participants.external import externals
from heavylift.coordinator.participants.participant import read
from heavylift.coordinator.protocol.messages import RunEnd
from heavylift.coordinator.record.run_record import FileRecorder, RunRecorder
from heavylift.coordinator.supervision.failover import DEADLINE_s
from heavylift.coordinator.supervision.hash_seed import fixed, loose
from heavylift.coordinator.supervision.processes import Processes
from heavylift.coordinator.transport.hub import Hub
from heavylift.coordinator.transport.link import LOCAL
from heavylift.coordinator.transport.placement import Placement, place
from heavylift.kernel.errors import ModelError
from heavylift.kernel.trust import allowed
from heavylift.nodes.devs import FOREVER, Coupled, Message, OutPort, Tag, Transition
from heavylift.nodes.devs.execution.rules import LIMIT, MicrostepLimit
from heavylift.nodes.devs.references import importing
from heavylift.recordings import file_path

from .arguments import end_ns
from .conversation import Conversation, joined
from .watch import RunObserver


@dataclass(frozen=True)
class ModelRun:
    """Result of a run of DEVS models.

    Reason of its end, time of the last event [s], wall time of the whole run and of its rounds [s], grants, digest,
    recording, and the `result()` of each atomic model by path.
    """

    outcome: RunEnd
    sim_s: float
    wall_s: float
    rounds_s: float
    grants: int
    digest: str
    recording: Path | None = None
    results: dict[str, Message] = field(default_factory=dict)


def run_models(
    build: str | Callable[[], Coupled],
    until: float | None = None,
    output: str | Path | None = None,
    in_process: bool = False,
    log: Callable[[Transition], None] | None = None,
    watch: RunObserver | None = None,
    order: list[str] | None = None,
    processes: int = 0,
    microsteps: int = LIMIT,
    force: bool = False,
    deadline: float = DEADLINE_s,
    places: Sequence[str] = (),
    remote: Collection[str] = (),
    listener: RemoteListener | None = None,
    stop: str = "",
    external: Collection[str] = (),
) -> ModelRun:
    """Run a DEVS model up to, but not including, time `until` [s], or until no event is left.

    `build`: the model, or the "module:function" that returns it.

    `stop`: "child.port" whose first message ends the run, together with everything else at that time.

    Each child has a process of its own, unless `processes` is their number, `places` assign children to processes, such
    as "west,east=yard", or `in_process` runs all of them in this one; `remote` processes connect to the `listener`; for
    each of the `external` ones, which are other programs, a file NAME.ticket is written (WIRE.md). `log` receives every
    transition of every process after the run, in the order of a flat run. Reaching `microsteps` tags without time
    advance counts as a loop and is an error. A process that does not answer for `deadline` [s] is probed, and replaced
    if it makes no progress. Raises HeavyliftError: one sentence, after the recording is finished and all processes are
    gone.
    """
    if importing():
        raise ModelError(
            f"{importing()} runs a model when it is imported, and each node imports it; "
            'put the call of run_models under `if __name__ == "__main__":`'
        )
    MicrostepLimit(microsteps)  # complains before anything begins
    end = Tag(end_ns(until))
    if in_process and (processes or places or remote or external):
        raise ModelError("in_process: all models run in this process; leave out processes, places, remote and external")
    reference = referred(build)
    model = built(reference)
    if in_process and not fixed() and (some := loose(model)):
        warnings.warn(
            f"{', '.join(some)}: may iterate over a set, whose order another process does not share; start Python with "
            "PYTHONHASHSEED=0 for equal runs, or sort it",
            stacklevel=2,
        )
    finish = stopping(model, stop)
    names = order or list(model.children)
    placement = (
        Placement({LOCAL: tuple(names)}) if in_process else place(names, {}, places, processes, remote, external)
    )
    started = time.perf_counter()
    lines: list[Transition] = []
    tempo = Tempo()
    with (
        allowed([reference]),  # in the processes, too: the caller names it, not a recording
        CommandQueue(lambda: Path(model.name), tempo) as queue,  # no model takes commands
        _recorder(reference, model, output, lines, placement, microsteps, stop, end.t, force) as recorder,
        joined(
            placement, in_process, None if in_process else Processes(_preload(reference)), listener, deadline
        ) as hub,
        shown(hub, model.name, recorder.recording) as publisher,
    ):
        watching = watch or RunObserver()
        wiring = Wiring(couplings(model), [], finish)
        talk = Conversation(
            hub,
            wiring,
            end,
            recorder,
            watching,
            publisher=publisher,
            tempo=tempo,
            queue=queue,
            microsteps=microsteps,
            externals=externals(placement, model.children, wiring.couplings, microsteps),
        )
        talk.written_to(output, recorder.recording)
        if isinstance(hub, Hub):
            queue.open(hub)
        try:
            if isinstance(hub, Hub):
                hub.admit(parts.fingerprint(reference.encode()), watching.say)
            _greet(talk, model, hub.placement, parts.ModelPart(reference, log is not None, microsteps, finish))
            greeted = time.perf_counter()
            outcome = talk.play()
            played = time.perf_counter()
            last = min(talk.core.end, end)
            left = talk.dismiss(last if last < FOREVER else talk.core.last)
            gathered = [result for bye in left.values() for result in bye.results]
        except BaseException as error:
            talk.abort(error)
            raise
        wall_s = time.perf_counter() - started
        sim_s, digest = recorder.last_ns / 1e9, recorder.digest.hexdigest()
        results = {result.path: result.value for result in sorted(gathered, key=lambda result: result.path.split("."))}
        kept = {path: {"type": type(x).__name__, "value": msgspec.to_builtins(x)} for path, x in results.items()}
        facts = {"sim_s": sim_s, "wall_s": wall_s, "grants": talk.grants, "outcome": outcome.value, "results": kept}
        recorder.close(facts)
        run = ModelRun(outcome, sim_s, wall_s, played - greeted, talk.grants, digest, recorder.recording, results)
    if log is not None:
        for line in sorted(lines, key=lambda line: (line.tag, line.path.split("."))):
            log(line)
    return run


class _Lines(RunRecorder):
    """A recorder without a file that collects transitions."""

    lines: list[Transition]
    recording: Path | None = None

    def samples(self, node: str, batch: bytes) -> int:
        """Record a node's batch of model transitions; return the simulation time of the last one [ns]."""
        found = read(batch)
        self.lines += found
        return found[-1].tag.t


class _FileLines(_Lines, FileRecorder):
    """A recorder that writes a file and collects transitions."""

    @property
    def recording(self) -> Path:  # type: ignore[override]
        """Path of the recording of the run."""
        return self.recorder.path


def _recorder(
    reference: str,
    model: Coupled,
    output: str | Path | None,
    lines: list[Transition],
    placement: Placement,
    microsteps: int,
    stop: str,
    until: int,
    force: bool,
) -> _Lines:
    recorder: _Lines
    if output is None:
        recorder = _Lines()
    else:
        placed = {process: list(nodes) for process, nodes in placement.processes.items()}
        facts = {"model": reference, "nodes": list(model.children), "placement": placed, "microsteps": microsteps}
        facts |= ({"stop": stop} if stop else {}) | ({"until": until} if until < FOREVER.t else {})
        recorder = file = _FileLines(file_path(output), facts, {}, force)
        for name, child in model.children.items():
            for port in child.ports.values():
                if isinstance(port, OutPort):
                    file.port(name, port.name, port.type)
    recorder.lines = lines
    return recorder


def _greet(talk: Conversation, model: Coupled, placement: Placement, part: parts.ModelPart) -> None:
    config, reference = parts.encode(part), part.build
    for node in placement.nodes:
        talk.welcome(node, config, parts.fingerprint(reference.encode()))
    here = dict(zip(placement.nodes, declarations(model, placement.nodes.values()), strict=True))
    for _ in placement.nodes:
        node, declared = talk.hello()
        if node not in talk.externals and declared != here[node]:
            name, what = difference(here[node], declared)
            raise ModelError(
                f"{reference}: {what} differs between the process of node {name or node} "
                "and this one; the function must build the same model "
                "each time, without clocks, sets or unseeded random numbers, and from the same version of the module"
            )


# what a node of models imports when it joins
PRELOAD = ("building", "isolation")


def _preload(reference: str) -> list[str]:
    where = module(reference)
    needed = (f"heavylift.coordinator.participants.{name}" for name in PRELOAD)
    return [NODE_MODULE, *needed, *([] if where.endswith(".py") else [where])]


def referred(build: str | Callable[..., Any]) -> str:
    """Return a reference `module:function` to a function, by which other processes can import it."""
    if isinstance(build, str):
        return build
    name = getattr(build, "__qualname__", "")
    if not name.isidentifier():
        raise ModelError(
            f"{name or build!r}: other processes cannot import it; define the function at the top level of a module"
        )
    if build.__module__ != "__main__":
        return f"{build.__module__}:{name}"
    file = inspect.getsourcefile(build)
    if file is None or not Path(file).exists():
        raise ModelError(f"{name}: other processes cannot import a function defined interactively; put it into a file")
    return f"{Path(file).resolve()}:{name}"
