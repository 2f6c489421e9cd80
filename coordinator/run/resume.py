"""Repetition of a run that was cut off, to its end: from the scene in the partial recording, checked against it.

A run is a function of its scene, so no earlier state needs to be restored: the new recording is complete, and has the
digest of the undisturbed run, even if only the scene had reached the disk. Every recorded event must occur again; the
first deviation ends the run, as then the version differs, or a model is not deterministic. An operator's commands are
injected again at their times, from the recording and from the journal of those not yet recorded.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
from heavylift.coordinator.live.command_queue import TimedCommand, journaled
from heavylift.coordinator.participants.configuration import OPERATOR
from heavylift.coordinator.participants.session import configured
from heavylift.coordinator.record.scene import MERGED, RESOLVED, RunResult
from heavylift.coordinator.replay.deviation import Deviation, EventComparison
from heavylift.coordinator.replay.recorded import RecordedRun
from heavylift.coordinator.supervision.processes import Processes
from heavylift.kernel.errors import HeavyliftError, RecordingError
from heavylift.kernel.trust import allowed, demand
from heavylift.kernel.version import __version__, again
from heavylift.nodes.devs import FOREVER, Event, Tag
from heavylift.nodes.devs.execution.rules import LIMIT
from heavylift.nodes.models import build
from heavylift.nodes.plan.fidelity import Answer
from heavylift.nodes.plan.plan import Plan, decode, functions
from heavylift.nodes.scene import LoadedScene, parse, restored
from heavylift.recordings import Recording, file_path, recover
from heavylift.recordings.format.mcapfile import BROKEN
from heavylift.recordings.write.outputs import PART, beside

from .models import ModelRun, run_models
from .scene import run
from .watch import Relay, RunObserver

_START = Tag(0)


class RecordingOfModelError(RecordingError):
    """Raised if the recording to be resumed belongs to a DEVS model and not to a scene."""


@dataclass(frozen=True)
class Beginning:
    """The readable part of a run that was cut off: scene, events on disk, operator commands, version."""

    scene: LoadedScene
    events: list[Event]
    commands: list[TimedCommand]
    version: str  # of heavylift that made it

    @classmethod
    def of(cls, part: str | Path, within: Path | None = None) -> "Beginning":
        """Read the readable part of a run that was cut off or failed; raises RecordingError if it has no scene.

        `part`: a `.part` file or a recording; `within`: folder for temporary files.
        """
        part = file_path(part)
        with TemporaryDirectory(prefix="heavylift-", dir=within) as folder:
            saved = recover(part, Path(folder) / "beginning.mcap", begun=True)
            try:
                return cls.left(part, RecordedRun(saved.path))
            except RecordingError as error:  # the user knows nothing of the copy
                raise type(error)(str(error).replace(f"{saved.path}", f"{part}")) from None

    @classmethod
    def left(
        cls, part: Path, left: RecordedRun, instead: str = "`heavylift recover` keeps what there is"
    ) -> "Beginning":
        """Return the readable part of a cut-off run from its recovered recording; raises RecordingError if it cannot be
        repeated.

        `instead`: advice for this error.
        """
        files = left.recording.attachments
        name = next((name for name in files if name != RESOLVED), "")
        if "model" in left.recording.run:
            raise RecordingOfModelError(f"{part}: holds a DEVS model and no scene; `heavylift resume` repeats its run")
        if not name or RESOLVED not in files:
            raise RecordingError(f"{part}: holds no scene, so its run cannot be repeated; {instead}")
        try:
            plan = decode(files[RESOLVED])
            demand(functions(plan), f"{part}")
            scene, _ = rebuilt(left.recording, plan, files[name].decode(), files.get(MERGED, b"").decode(), name)
            configured(plan, build(plan))  # a plan may be readable and yet make no sense
        except BROKEN as error:
            made = left.recording.version
            message = "is damaged" if made == __version__ else f"is of heavylift {made}, this is {__version__}"
            message = f"its scene {message} ({error or type(error).__name__})"
            raise RecordingError(f"{part}: {message}; {instead}") from None
        commanded = {TimedCommand(event.tag, event.payload) for event in left.events if event.source == OPERATOR}
        commands = commanded.union(journaled(part.with_name(part.name.removesuffix(PART))))
        return cls(scene, left.events, sorted(commands), left.recording.version)


def rebuilt(rec: Recording, plan: Plan, text: str, merged: str, name: str) -> tuple[LoadedScene, Plan | HeavyliftError]:
    """Return the recorded scene with the plan that was simulated, and the plan that the installed version builds
    from its text.

    The plan is replaced by an error if the text gives none, for example because files are missing.
    """
    found = {key: x for key, x in rec.fact("answer", {}).items() if key != "told"}
    answer = msgspec.convert(found, Answer) if found else None
    scene = replace(restored(plan, text, merged, name), answer=answer)
    try:
        message = parse(merged or text, name, followed=any(x.spread or x.rest for x in plan.limits))
    except HeavyliftError as error:
        return scene, error
    return replace(
        message, plan=plan, text=text, merged=merged, path=Path(name), chosen=True, answer=answer
    ), message.plan


class Checked(Relay):
    """Observer that compares the events of a repeated run with the recorded ones and forwards them."""

    def __init__(
        self, events: list[Event], parted: Callable[[Deviation], RecordingError], watch: RunObserver, end: Tag = _START
    ) -> None:
        """`events`: recorded events that the run must repeat; all events before `end` are compared; `parted` returns
        the error for a deviation."""
        self._follower, self._count = EventComparison(events), len(events)
        self._parted, self._watch, self._end = parted, watch, end

    def event(self, event: Event) -> None:
        """Compare an event with the next recorded one, if there is one, and forward the event."""
        if (self._follower.count < self._count or event.tag < self._end) and (found := self._follower.hear(event)):
            raise self._parted(found)
        self._watch.event(event)

    def end(self) -> None:
        """Check at the end of the run that no recorded event is missing."""
        if missing := self._follower.reach(FOREVER):
            raise self._parted(missing)


def resume(
    part: str | Path,
    begun: Beginning,
    output: str | Path | None = None,
    watch: RunObserver | None = None,
    processes: Processes | None = None,
    in_process: bool = False,
    force: bool = False,
) -> RunResult:
    """Repeat a run that was cut off, into `output` (default: NAME-resumed.mcap); the partial recording is kept."""
    part = file_path(part)
    target = file_path(output) if output else beside(part.with_name(part.name.removesuffix(PART)), "-resumed.mcap")
    if part in (target, target.with_name(target.name + PART)):
        raise RecordingError(f"{target}: this would overwrite the recording to be resumed; choose another name with -o")
    checked = Checked(begun.events, partial(_parted, part, begun.version), watch or RunObserver())
    result = run(
        begun.scene, target, in_process, watch=checked, processes=processes, commands=begun.commands, force=force
    )
    checked.end()
    return result


def resume_model(part: str | Path, output: str | Path | None = None, force: bool = False) -> ModelRun:
    """Repeat the run of a DEVS model that was cut off, into `output`, and check it against its partial recording."""
    part = file_path(part)
    target = file_path(output) if output else beside(part.with_name(part.name.removesuffix(PART)), "-resumed.mcap")
    with TemporaryDirectory(prefix="heavylift-") as folder:
        left = RecordedRun(recover(part, Path(folder) / "beginning.mcap", begun=True).path)
        run = left.recording.run
        checked = Checked(left.events, partial(_parted, part, left.recording.version), RunObserver())
        until = int(run["until"]) / 1e9 if "until" in run else None
        with allowed([run["model"]]):
            result = run_models(
                run["model"], until, target, True, watch=checked, force=force, stop=str(run.get("stop", "")),
                microsteps=int(run.get("microsteps", LIMIT)),
            )  # fmt: skip
        checked.end()
    return result


def _parted(part: Path, made: str, found: Deviation) -> RecordingError:
    return RecordingError(
        f"{part}: the repeated run differs from the recording, {found}; {again(made)}, or "
        f"`heavylift recover {part}` to keep what there is"
    )
