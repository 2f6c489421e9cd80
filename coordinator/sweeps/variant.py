"""One variant of a scene as a row of numbers: the work of a sweep's worker on any host.

A worker gets everything by its arguments and always answers with bytes of MessagePack, so it may be a process of a
pool, a thread, or a dask worker on another host; no answer is a pickle. The row has the digest of `heavylift run` with
the same settings.
"""

import os
import platform
import re
import tempfile
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np
from heavylift.coordinator.ladder.looking import as_it_is, errors_of_limits
from heavylift.coordinator.ladder.measuring import Measuring
from heavylift.coordinator.ladder.model_levels import ModelLevel
from heavylift.coordinator.record.in_memory import CUT, Judged, Played, play
from heavylift.coordinator.run.simulate import result_of
from heavylift.coordinator.verdict.limits import signals_of_run
from heavylift.coordinator.verdict.worst_corners import with_worst_clearances
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.kernel.errors import SPACES, UNREADABLE, HeavyliftError, ModelError, ProtocolError, SceneError, printable
from heavylift.nodes.limits.reading import evaluated
from heavylift.nodes.plan.fidelity import USUAL, Asked
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.loading import parse
from heavylift.nodes.scene.text.source import read
from heavylift.nodes.scenes import bundled
from heavylift.recordings.format.text import shown

from .axes import Variant
from .function_studies import called

Keep = Literal["none", "failed", "all"]
KEEP: tuple[Keep, ...] = ("none", "failed", "all")
PLACES = ("hook height", "rope length", "rails", "girder")  # limits that say how far something may go
FAILED = ("red", "refused", "failed", "cut", "lost")
STATUSES = ("done", *FAILED)
TEXTS = (
    "status",
    "sentence",
    "digest",
    "verdict",
    "state",
    "unfinished",
    "limit",
    "limit stage",
    "error in",
    "host",
)  # other columns: numbers
RESPONSE = "response/"  # before the name of a column: what a function of the user gives
EACH = 20  # variants, of which one is measured
MOST_COLUMNS, MOST_TEXT, MOST_BYTES = 20_000, 100_000, 1 << 30  # of an answer
Row = dict[str, Any]


@dataclass(frozen=True)
class Task:
    """The data that all variants of a study share, sent to each worker.

    Text and name of the scene, settings, wall time limit [s], recordings to keep, whether limits and clearances are
    checked, quantities whose errors are measured, and references of the functions that give further columns.
    """

    text: str
    name: str
    settings: tuple[str, ...]
    limit_s: float
    keep: Keep
    judged: bool
    ask: tuple[Asked, ...] = ()  # whose error is measured on one variant in `EACH`
    responses: tuple[tuple[str, str], ...] = ()

    @classmethod
    def of(cls, scene: LoadedScene, limit_s: float, keep: Keep, judged: bool) -> "Task":
        """Return the study's task for a scene; the task contains the text of the scene and of all scenes that it
        extends."""
        name = scene.path.name if scene.path in bundled().values() else str(scene.path)
        if "extends" in read(scene.text, name).data:  # files that a worker elsewhere has not
            own = tuple(ModelLevel(scene.plan).settings) if scene.chosen else ()
            return cls(scene.merged, name, own, limit_s, keep, judged, scene.facts.ask)
        return cls(scene.text, name, scene.settings, limit_s, keep, judged, scene.facts.ask)


def answered(task: Task, variant: Variant) -> bytes:
    """Run a variant and return the worker's encoded answer: its row, or a row with the error."""
    try:
        row = played(task, variant)
    except Exception as error:
        row = {"number": variant.number, "status": "lost", "sentence": f"{type(error).__name__}: {error}"}
    return msgspec.msgpack.encode(row, enc_hook=lambda number: number.item())


def received(answer: object, variant: Variant) -> Row:
    """Decode the row in a worker's answer; raises ProtocolError if the answer is not a row of this variant."""
    if not isinstance(answer, bytes) or len(answer) > MOST_BYTES:
        raise ProtocolError("the worker of this variant returned something other than an encoded row")
    try:
        row = msgspec.msgpack.decode(answer, type=dict[str, Any])  # each column is checked below
    except UNREADABLE:
        raise ProtocolError("the worker of this variant returned bytes that are not a row") from None
    recording = row.pop("recording", b"")
    wrong = [name for name, x in row.items() if name.startswith("input/") or not _fits(name, x)]
    if row.get("number") != variant.number or row.get("status") not in STATUSES or "sentence" not in row:
        raise ProtocolError("the worker of this variant returned the row of another variant")
    if wrong or len(row) > MOST_COLUMNS or not isinstance(recording, bytes):
        message = f": {printable(wrong[0], 80)}" if wrong else ""
        raise ProtocolError(f"the worker of this variant returned an invalid row{message}")
    sentence = printable(str(row["sentence"]), keep=f"\n{SPACES}")
    return shown(row) | {"sentence": sentence} | ({"recording": recording} if recording else {})


def _fits(name: str, x: object) -> bool:
    """Return whether a column has a valid value."""
    if name in TEXTS:
        return isinstance(x, str) and len(x) <= MOST_TEXT
    return len(name) <= MOST_TEXT and (x is None or isinstance(x, float) or (isinstance(x, int) and abs(x) < 1 << 63))


def first_sentence(text: str) -> str:
    """Return the first sentence of an error message, without its place in the scene and the list of further cases."""
    first = text.splitlines()[0]
    return re.sub(r"^(.*?error: )?(actions\[[^:]*: )?", "", first).partition("; likewise")[0]


def played(task: Task, variant: Variant) -> Row:
    """Run a variant of a scene and return its row of the study."""
    return judged(task, variant)[0]


def judged(task: Task, variant: Variant) -> tuple[Row, Judged | None]:
    """Run a variant and return its row of the study, with the verdict and utilisations if the run reached its end."""
    began, cpu = time.perf_counter(), time.thread_time()
    row: Row = {"number": variant.number, "status": "done", "sentence": ""}
    scene, verdict, settings = None, None, (*task.settings, *variant.settings)
    try:
        scene = parse(task.text, task.name, settings, passing=True, followed=task.judged)
        scene = with_worst_clearances(scene) if task.judged else scene
        try:
            run = play(scene.plan, task.limit_s, errors=scene.errors if task.judged else None)
        except HeavyliftError:
            if not task.judged:
                parse(task.text, task.name, settings, passing=True)  # which may know better why
            raise
        row |= _numbers(run, task.judged)
        row |= {RESPONSE + name: _response(name, reference, run) for name, reference in task.responses}
        verdict = run.judge.fine if task.judged else None
        if task.ask and variant.number % EACH == 0:
            measuring = Measuring(task.ask)
            look = as_it_is(scene.plan, USUAL, measuring)
            row["error in"] = max(look.error, key=lambda x: (look.error[x], x), default="")
            row["error"] = look.error.get(row["error in"], 0.0)
            if task.judged and look.whole:  # the checks of this row have errors of their own
                judge = replace(run.judge, errors=look.error | errors_of_limits(look, measuring))
                row |= _verdict(judge.fine)
                verdict = judge.fine
    except SceneError as error:
        row |= {"status": "refused", "sentence": str(error)}
    except HeavyliftError as error:
        row |= {"status": "cut" if CUT in str(error) else "failed", "sentence": str(error)}
    if scene is not None and (task.keep == "all" or (task.keep == "failed" and row["status"] in ("red", "failed"))):
        row["recording"] = _recorded(scene)
    row |= {"host": platform.node(), "process": os.getpid()}
    return row | {"cpu_s": time.thread_time() - cpu, "wall_s": time.perf_counter() - began}, verdict


def _response(name: str, reference: str, run: Played) -> float:
    """Return the number that a user's function gives for the `Result` of a run."""
    found = called(reference, result_of(run))
    with suppress(TypeError, ValueError, OverflowError):
        if isfinite(number := float(found)):
            return number
    raise ModelError(f"the response {name} is {found!r:.60}, not a finite number")


def _numbers(run: Played, judged: bool) -> Row:
    """Return all numbers of a completed run in SI units, by column name."""
    row: Row = {"digest": run.digest, "simulated [s]": run.end_ns / 1e9, "unfinished": run.unfinished}
    row |= {f"peak/{rope} [N]": peak.tension for rope, peak in run.peaks.items()}
    row |= {f"peak time/{rope} [s]": peak.time for rope, peak in run.peaks.items()}
    stages = [(name, t) for t, _, name in run.conduct.stages if name]
    ends = [t for _, t in stages[1:]] + [run.end_ns / 1e9]
    row |= {f"stage/{name} [s]": end - t for (name, t), end in zip(stages, ends, strict=False)}
    row["off-lead [deg]"] = _off_lead(run)
    if judged:
        verdict, found = run.judge.fine
        row |= _verdict(run.judge.fine)
        row |= {"clearance [m]": min((x.distance for x in verdict.clearances), default=np.nan)}
        uses = governing_uses(found)
        row |= {f"use/{name}": x.use for name, x in uses.items()}
        loads = [(x.use, name) for name, x in uses.items() if x.limit.quantity not in PLACES]
        row |= {"use": np.nan, "limit": ""}
        if loads:
            most, name = max(loads)
            row |= {"use": most, "limit": name, "limit stage": uses[name].stage, "limit at [s]": uses[name].t}
    return row


def _verdict(found: Judged) -> Row:
    verdict, _ = found
    return {"verdict": verdict.line, "state": verdict.state, "status": "red" if verdict.red else "done"}


def governing_uses(uses: Sequence[Use]) -> dict[str, Use]:
    """Return the maximum utilisation of each checked limit, by the limit's name."""
    return {f"{x.limit.subject} {x.limit.quantity}": x.at_worst for x in uses if x.use is not None}


def _off_lead(run: Played) -> float:
    """Return the largest angle between a hook rope and the vertical [deg]; NaN without such ropes."""
    signals = signals_of_run(run.plan, run.t, {}, run.past.part(0, len(run.t)).poses, ())
    hooks = (hook for machine in run.plan.machines for hook in machine.hooks)
    leads = (evaluated(run.plan, ScalarSignal("off-lead", ropes=(x.rope,), point=x.eye), signals) for x in hooks)
    angles = [np.degrees(np.minimum(angle, np.pi - angle).max()) for angle in leads if angle is not None]
    return float(max(angles, default=np.nan))


def _recorded(scene: LoadedScene) -> bytes:
    """Run the variant again and return its recording; empty if it cannot be recorded."""
    from heavylift.coordinator.run.scene import run

    with tempfile.TemporaryDirectory(prefix="heavylift-") as folder:
        path = Path(folder) / "run.mcap"
        with suppress(HeavyliftError):  # the row says why; the recording goes as far as the run
            run(scene, path, in_process=True)
        return path.read_bytes() if path.exists() else b""
