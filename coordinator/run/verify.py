"""Verification of a recording: the run is simulated again in this process, and everything that a run determines
compared.

Events are compared as they are committed, so the new run ends at its first deviation. Then the new recording is
compared with the old one: every row, the verdict, which is computed again, peaks, facts, attachments; and the simulated
plan with the attached text of its scene. An operator's commands are injected again at their tags. A recording that was
stopped or cut off is compared as far as it goes.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
import numpy as np
from heavylift.coordinator.live.command_queue import TimedCommand
from heavylift.coordinator.participants.configuration import OPERATOR
from heavylift.coordinator.record.scene import MERGED, RESOLVED
from heavylift.coordinator.replay.deviation import Deviation, EventComparison, ReplayResult
from heavylift.coordinator.replay.recorded import RecordedRun
from heavylift.kernel.errors import HeavyliftError, RecordingError
from heavylift.kernel.trust import allowed
from heavylift.nodes.devs import FOREVER, NEVER, Event
from heavylift.nodes.devs.execution.rules import LIMIT
from heavylift.nodes.plan.plan import Plan, decode
from heavylift.nodes.scene import LoadedScene
from heavylift.recordings import Recording, compare
from heavylift.recordings.read.verdict import complaints, recorded_verdict
from heavylift.recordings.render.differences import CIRCUMSTANCES, attachments, channels, facts, hashes

from .branch import CHOSEN, different
from .models import run_models
from .resume import rebuilt
from .scene import run as run_scene
from .watch import RunObserver

LATER = ("certified", "measured", "branch", "answer")  # facts beside those that a run determines
GONE = ("No such file", "there is no file")  # in sentences about files that a scene names, which may be gone
LOG = "/measured"  # topic of the log of a real lift beside a run


def verify(run: RecordedRun) -> ReplayResult:
    """Simulate a recorded run again and compare; the result has the digest of the new run if everything was equal."""
    assert run.cast  # with what is not to be run a sentence ends it here
    with TemporaryDirectory(prefix="heavylift-") as folder:
        return _Again(run, Path(folder) / "again.mcap").outcome()


class _Deviated(Exception):
    """Ends the new run: it deviates from its recording, or has passed the end of an incomplete one."""


class _Checking(RunObserver):
    """Observer that compares committed events with the recorded ones."""

    def __init__(self, run: RecordedRun) -> None:
        self._run, self.follower, self.over = run, EventComparison(run.events), False
        self.apart: Deviation | None = None
        samples = hashes(run.recording, "/samples")["t"].tolist()
        self._last_ns = max([*samples[-1:], *(event.t for event in run.events[-1:])], default=0)

    def event(self, event: Event) -> None:
        """Compare an event with the next recorded one; raises _Deviated if it differs or an incomplete recording
        ends."""
        if self.over or (found := self.follower.hear(event)) is None:
            return
        self.over = True  # what has been decided already is still to come
        if self._run.complete or found.recorded is not None or self.follower.count < len(self._run.events):
            self.apart = found
        raise _Deviated

    def progress(self, t_ns: int) -> None:
        """Raise _Deviated if samples arrive from beyond the end of an incomplete recording."""
        if not (self._run.complete or self.over) and t_ns > self._last_ns:
            self.over = True
            raise _Deviated


class _Again:
    """Comparison of a recorded run with its repetition in the file `path`."""

    def __init__(self, run: RecordedRun, path: Path) -> None:
        self._run, self._old, self._path = run, run.recording, path
        self._others, self._unreported = list[str](), ""  # what differs, and what cannot be compared
        self._watch = _Checking(run)

    def outcome(self) -> ReplayResult:
        """Simulate the recorded run again and return how the new run compares with the recorded one."""
        watch, count = self._watch, self._watch.follower
        try:
            self._repeat()
            watch.apart = watch.apart or count.reach(FOREVER)
        except _Deviated:
            pass
        except HeavyliftError as error:
            if not watch.over and (self._run.complete or self._old.result.get("reason") != str(error)):
                self._others.append(f"simulated again, the run ends by an error: {error}")
        if watch.apart is not None:
            return ReplayResult(count.count, watch.apart)
        if not self._path.exists():  # an error before anything was recorded
            return ReplayResult(count.count, None, "", tuple(self._others))
        new = Recording(self._path)
        digest = self._compared(new) if self._run.complete else self._as_far_as_it_goes(new)
        found = _row_apart(self._old, new, not self._run.complete)
        same = found is None and not self._others
        verdict = recorded_verdict(new) if self._run.complete else None
        later = [name for name in (*LATER, *sorted(CIRCUMSTANCES)) if name in self._old.run or name in self._old.result]
        later += [] if self._run.complete else sorted(self._old.result.keys() - {*later})
        later += [self._unreported] if self._unreported else []
        checked = verdict.line if verdict and same else ""
        return ReplayResult(count.count, found, digest if same else "", tuple(self._others), checked, tuple(later))

    def _repeat(self) -> None:
        """Run the recorded scene or model again."""
        old, watch = self._old, self._watch
        if RESOLVED in old.attachments:
            commands = [TimedCommand(e.tag, e.payload) for e in self._run.events if e.source == OPERATOR]
            run_scene(self._scene(), self._path, in_process=True, watch=watch, commands=commands)
            return
        until_ns = old.fact("until", self._run.end.t)
        until = until_ns / 1e9 if until_ns < NEVER else None
        microsteps, stop = old.fact("microsteps", LIMIT), str(old.fact("stop", ""))
        with allowed([old.run["model"]]):
            run_models(old.run["model"], until, self._path, True, watch=watch, microsteps=microsteps, stop=stop)

    def _scene(self) -> LoadedScene:
        """Return the scene with the simulated plan, and note where the attached text yields another one."""
        files = self._old.attachments
        plan, name = decode(files[RESOLVED]), next((name for name in files if name != RESOLVED), "")
        text, merged = files.get(name, b"").decode(errors="replace"), files.get(MERGED, b"").decode(errors="replace")
        try:
            scene, message = rebuilt(self._old, plan, text, merged, name)
        except HeavyliftError as error:
            raise RecordingError(f"{self._old.path}: the attached text is not a readable scene ({error})") from None
        if isinstance(message, HeavyliftError):
            self._unreported = f"text of the scene ({message})"
            if not any(x in str(message) for x in GONE):
                self._others.append(f"the attached scene cannot be run: {message}")
            return scene
        self._others += [
            f"the attached scene differs from the simulated plan: {x}" for x in self._different(message, plan)
        ]
        return scene

    def _different(self, message: Plan, plan: Plan) -> list[str]:
        """Return paths at which the text's plan differs from the simulated one, without settings that the run chose."""
        kept = CHOSEN if "branch" in self._old.run or "answer" in self._old.run else ("driven",)
        return different(msgspec.structs.replace(message, **{name: getattr(plan, name) for name in kept}), plan)

    def _compared(self, new: Recording) -> str:
        """Compare everything but events of a complete recording; returns the digest."""
        old, but = self._old, {*LATER}
        if "until" not in old.run:  # nor may it be known of a model when its atomics told their results
            but |= {"until", "results"} if "model" in old.run else {"until"}
        if "measured" in old.result:
            but |= {LOG, *(old.attachments.keys() - new.attachments.keys())}
        if self._unreported:
            but |= {"asked", "accuracy", "modelled"}
        found = compare(old.path, new.path, but)
        self._others += [*found.wrong, *(x.replace(new.path.name, "the new run") for x in (*found.rows, *found.others))]
        if not found.equal and not self._others:
            self._others.append(found.first)
        return new.result.get("digest", "")

    def _as_far_as_it_goes(self, new: Recording) -> str:
        """Compare the existing part of a recording that was cut off; return "", since such a recording has no
        digest."""
        old = self._old
        self._others += complaints(old)
        self._others += [x for x in facts(old, new, LATER) if x.startswith("run.")] + [*attachments(old, new)]
        self._others += [x for x in channels(old, new) if not x.startswith("topics")]
        if new.result["status"] == "finished" and old.result.get("digest") == new.result["digest"]:
            self._others.append(
                f"simulated again, the run finishes, but its recorded status is '{old.result.get('status')}'"
            )
        return ""


def _row_apart(old: Recording, new: Recording, prefix: bool) -> Deviation | None:
    """Return the first difference between recorded rows of two runs; with `prefix` the new run may have more."""
    for topic in sorted(x for x in {*old.topics, *new.topics} if x.startswith(("/samples", "/poses"))):
        a, b = hashes(old, topic), hashes(new, topic)
        n = min(len(a), len(b))
        off = np.flatnonzero(a[:n] != b[:n])
        if not len(off) and (len(a) == len(b) or (prefix and len(a) < len(b))):
            continue
        row = int(off[0]) if len(off) else n
        t_ns = min(int(x["t"][row]) for x in (a, b) if row < len(x))
        for name in (x for x in old.signals() if x in new.signals() and topic in ("/samples", "/poses")):
            if name.startswith("pose/") == (topic == "/poses"):
                x, y = (rec.signal(name) for rec in (old, new))
                for column in x.names:
                    values = [s[column][row].item() if row < len(s) and column in s.names else None for s in (x, y)]
                    if repr(values[0]) != repr(values[1]):
                        return Deviation(t_ns, 0, f"/{name}/{column}", *values)
        return Deviation(t_ns, 0, topic, f"row {row}" if row < len(a) else None, f"row {row}" if row < len(b) else None)
    return None
