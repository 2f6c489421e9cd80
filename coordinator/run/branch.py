"""What-if runs: a recorded run with other settings from some time on, verified to equal the recording up to there.

    branch("run.mcap", "stage travel", ["stage travel/cranes=travel 20 m/min by 60 m"], output="slower.mcap")

The models run from the start with the new plan, which shows that they would have done the same; the kernel, the costly
part of a run, repeats what is recorded and continues from the last checkpoint before the branch, or runs from the start
if none fits the new scene, as with other thresholds. Every event and sample before the branch must equal the recorded
one; the first that differs ends the run, which then leaves nothing. So the new recording is complete, and has the
digest of a run of the new scene. Model level and steps that the recorded run had chosen, for its accuracy or its time
limit, are kept; the errors of the branch are measured anew.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np
from heavylift.coordinator.ladder.choosing import measured
from heavylift.coordinator.participants.recorded_kernel import RecordedKernel
from heavylift.coordinator.record.scene import MERGED, RunResult
from heavylift.coordinator.replay.deviation import Deviation
from heavylift.coordinator.replay.recorded import RecordedRun
from heavylift.kernel.description.findings import clock
from heavylift.kernel.errors import HeavyliftError, RecordingError, SceneError, path_text
from heavylift.kernel.version import __version__, again
from heavylift.nodes.devs import Event, Tag, seconds
from heavylift.nodes.models import COMMANDER, KERNEL
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.scene import LoadedScene, load
from heavylift.nodes.scene.loading import parse
from heavylift.nodes.scene.text.units import DURATION
from heavylift.recordings import Recording, file_path
from heavylift.recordings.format.text import meant
from heavylift.recordings.write.outputs import PART, beside
from numpy.typing import NDArray

from .resume import Beginning, Checked
from .scene import run
from .watch import RunObserver

CHOSEN = ("fidelity", "method", "tolerance", "step", "samples_hz", "driven")  # of a plan, whatever comes later
CHOOSING = ("fidelity", "method", "tolerance", "tolerance of", "step", "ask", "accuracy")  # keys that say otherwise
NAMED = 3  # differences of two plans in a sentence
STAGE, END = "stage ", "end of "
CLOCK = re.compile(r"(?:(?:(\d+):)?(\d+):)?(\d+(?:\.\d+)?)")  # 1:02:03.5, 2:00, 120


class _Point(NamedTuple):
    """The tag at which a branch leaves its recording, with the stage."""

    tag: Tag
    stage: str = ""

    def __str__(self) -> str:
        at = f"{self.tag.t * 1e-9:.3f} s"
        return f"{at} (stage {self.stage})" if self.stage else at


@dataclass(frozen=True)
class RunBranch:
    """A branch of a recorded run: recording, new scene, recorded beginning, and the logical time at which the branch
    leaves the recording."""

    path: Path
    scene: LoadedScene
    begun: Beginning
    at: _Point
    run: RecordedRun

    @classmethod
    def of(
        cls, path: str | Path, at: str, settings: Sequence[str] = (), scene: str | Path | None = None
    ) -> "RunBranch":
        """Return a branch of the recording `path` that starts at a time or stage; raises RecordingError or SceneError.

        `at`: "stage NAME", "end of stage NAME", "120 s" or "2:00".

        `scene`: an edited file to use instead of the recorded scene.
        """
        path = file_path(path)
        if not settings and scene is None:
            raise SceneError("the branch changes nothing; give --set or an edited --scene")
        run = RecordedRun(path)
        if (made := run.recording.version) != __version__:
            message = f"was made by heavylift {made}, this is {__version__}, which may give other results"
            raise RecordingError(f"{path}: {message}; {again(made)}")
        begun = Beginning.left(path, run, "run the scene again")
        point = _point(run, at)
        new = _new(begun, run.recording, settings, scene)
        if new.plan.end is not None and seconds(new.plan.end) <= point.tag.t:
            raise SceneError(f"the end {new.plan.end:g} s is before the branch point {point}; choose a later end")
        return cls(path, new, begun, point, run)


def branch(
    what: RunBranch, output: str | Path | None = None, watch: RunObserver | None = None, force: bool = False
) -> RunResult:
    """Run a branch in this process into `output` (default: NAME-branch.mcap); the old recording does not change."""
    target = file_path(output) if output else beside(what.path, "-branch.mcap")
    if what.path in (target, target.with_name(target.name + PART)):
        raise RecordingError(
            f"{target}: this is the recording itself, which will not be overwritten; choose another name with -o"
        )
    watch, past = watch or RunObserver(), _past(what)
    checked = _Watch(what, past, watch)
    try:
        result = run(
            what.scene, target, in_process=True, watch=checked, commands=what.begun.commands, force=force, past=past
        )
        checked.end()
    except HeavyliftError as error:
        if past.parted is None:
            raise
        t_ns, column, recorded, now = past.parted
        message = Deviation(t_ns, 0, column, recorded, now)
        raise _refused(what, message) from error
    watch.say(
        f"equal to {what.path} up to {what.at}, proved: {checked.events} events and {past.samples} samples came again"
    )
    return result


class _Watch(Checked):
    """Compares events before the branch, and reports where the mechanics continue."""

    def __init__(self, what: RunBranch, past: RecordedKernel, watch: RunObserver) -> None:
        self._events = [event for event in what.begun.events if event.tag < what.at.tag]
        super().__init__(self._events, self._refuse, watch, what.at.tag)
        self._what, self._past, self._at, self._message = what, past, what.at, False

    def _refuse(self, found: Deviation) -> RecordingError:
        self._past.over = False
        return _refused(self._what, found)

    @property
    def events(self) -> int:
        """Number of recorded events before the branch point."""
        return len(self._events)

    def event(self, event: Event) -> None:
        """Compare an event before the branch with the recorded one."""
        self._pass(event.tag)
        super().event(event)

    def progress(self, t_ns: int) -> None:
        """Report the simulation time [ns] that the branch has reached."""
        self._pass(Tag(t_ns))
        super().progress(t_ns)

    def _pass(self, tag: Tag) -> None:
        past = self._past
        if not self._message:
            self._message = True
            why = past.why or "the recording has no checkpoint before the branch"
            at = f"continues from the checkpoint at {past.at.t * 1e-9:.3f} s"
            self.say(at if past.used else f"simulates from the start: {why}")
        past.over = past.over or tag >= self._at.tag


def _refused(what: RunBranch, found: Deviation) -> RecordingError:
    changed = different(what.begun.scene.plan, what.scene.plan)
    message = f"; changed in the scene: {', '.join(changed)}" if changed else ""
    return RecordingError(
        f"{what.path}: the changes affect the run before {what.at}, {found}{message}; change only what acts "
        "later, or run the scene from the start"
    )


def _point(run: RecordedRun, text: str) -> _Point:
    """Return the tag that a user's text means."""
    answer = [(e.tag, str(e.value.name)) for e in run.events if (e.source, e.port) == (COMMANDER, "stage")]  # type: ignore[attr-defined]
    stages = [(tag, name) for tag, name in answer if name]
    whole = " ".join(text.split())
    after = whole.startswith(END)
    name = whole.removeprefix(END).removeprefix(STAGE)
    if after or whole.startswith(STAGE):
        found = [i for i, (_, stage) in enumerate(stages) if stage == name]
        if len(found) != 1:
            times = " and ".join(clock(stages[i][0].t * 1e-9) for i in found)
            message = (
                f"begins {len(found)} times, at {times}; give a time" if found else meant(name, [x for _, x in stages])
            )
            message = f"stage '{name}' {message}" if found else f"there is no stage '{name}'; {message}"
            message = message if stages else "the run has no stages; give a time"
            raise RecordingError(f"{run.path}: --at '{text}': {message}")
        if not after:
            return _inside(run, text, _Point(*stages[found[0]]))
        if found[0] + 1 == len(stages):
            raise RecordingError(
                f"{run.path}: --at '{text}': {name} is the last stage; there is nothing after it to branch into"
            )
        return _inside(run, text, _Point(*stages[found[0] + 1]))
    try:
        clocked = CLOCK.fullmatch(whole)
        parts = [float(part or 0) for part in clocked.groups()] if clocked else []
        s = 3600 * parts[0] + 60 * parts[1] + parts[2] if clocked else DURATION.read(whole)
    except ValueError as error:
        raise RecordingError(
            f"{run.path}: --at '{text}': {error}; write 'stage NAME', 'end of stage NAME', or a time such as 2:00"
        ) from None
    return _inside(run, text, _Point(Tag(seconds(s))))


def _inside(run: RecordedRun, text: str, point: _Point) -> _Point:
    end = float(run.recording.fact("sim_s", 0.0))
    if not 0 < point.tag.t <= seconds(end):
        where = "nothing lies before it; run the scene instead" if point.tag.t <= 0 else f"the run ended at {end:.3f} s"
        raise RecordingError(f"{run.path}: --at '{text}': {where}")
    return point


def _new(begun: Beginning, rec: Recording, settings: Sequence[str], scene: str | Path | None) -> LoadedScene:
    """Return the recorded scene with the changes, and with the choices of the recorded run."""
    old = begun.scene
    if scene is not None:
        found = load(scene, settings)
    else:
        whole = rec.attachments.get(MERGED, b"").decode()
        found = parse(whole or old.text, str(old.path), settings)
        found = replace(found, text=old.text, merged=found.merged or whole)
    if any(setting.split("=")[0].split(".")[0].strip() in CHOOSING for setting in settings):
        return found
    own = {"samples_hz"} if "samples" in found.facts.named else set[str]()
    kept = {name: getattr(old.plan, name) for name in CHOSEN if name not in own}
    found = replace(found, plan=msgspec.structs.replace(found.plan, **kept), chosen=True)
    return measured(found) if old.answer else found


def _past(what: RunBranch) -> RecordedKernel:
    """Return the recorded history before the branch."""
    rec, tag = what.run.recording, what.at.tag
    before = [Tag(*at) for at in rec.checkpoints if Tag(*at) <= tag]

    def rows(signals: Sequence[str]) -> Iterator[tuple[list[int], NDArray[np.float64]]]:
        for times, values in rec.blocks(signals):
            n = int(np.searchsorted(times, tag.t))
            yield times[:n], np.hstack(values)[:n]
            if n < len(times):
                return

    return RecordedKernel(
        [event for event in what.begun.events if event.source == KERNEL],
        {name: rec.columns(name) for name in rec.signals()},
        rows,
        [(round(t * 1e9), message) for t, message in rec.notes()],
        before[-1] if before else Tag(0),
        rec.checkpoint(before[-1]) if before else b"",
        lambda: ((at, rec.checkpoint(at)) for at in before),
        {
            "branch": {
                "of": path_text(what.path.name),
                "digest": rec.result.get("digest", ""),
                "t": tag.t / 1e9,
                "stage": what.at.stage,
            }
        },
    )


def different(old: Plan, new: Plan) -> list[str]:
    """Return the first paths (at most `NAMED`) at which two plans differ, and "and N more" if there are others."""
    found = list(_apart("", old, new))
    return [*found[:NAMED], *([f"and {len(found) - NAMED} more"] if len(found) > NAMED else [])]


def _apart(path: str, a: object, b: object) -> Iterator[str]:
    if isinstance(a, msgspec.Struct) and type(a) is type(b):
        for key in a.__struct_fields__:
            if not key.endswith("where") and key not in ("text", "marks"):
                yield from _apart(f"{path}.{key}" if path else key, getattr(a, key), getattr(b, key))
    elif isinstance(a, list | tuple) and isinstance(b, list | tuple) and len(a) == len(b):
        for i, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from _apart(f"{path}[{i}]", x, y)
    elif a != b:
        short = [x if isinstance(x, str | float | int) else "..." for x in (a, b)]
        yield f"{path} {short[0]} -> {short[1]}"
