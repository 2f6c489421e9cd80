"""What a recording says of its run: the verdict, with what was found, smallest clearances and limits; peaks; and where
its result is not what its events and rows give.

The verdict is made by who knows the scene (`coordinator.verdict`) and kept as the fact `verdict` of the result.
"""

from math import nan
from pathlib import Path

import msgspec
import numpy as np
from heavylift.kernel.description.findings import Check, Finding, State, clock
from heavylift.recordings.sheets.sheet import Table
from heavylift.recordings.write.rows import Peak

from .contents import READ, Contents
from .reader import Recording

AGAIN = "`heavylift replay --verify` computes all of it again"
ROUNDED = 1e-8  # of a tension, and of 1 MN: more than rows are rounded by
Vector = tuple[float, float, float]


class Clearance(msgspec.Struct, frozen=True, kw_only=True):
    """Two things, their smallest distance [m] and its time [s], nearest points in the world [m], and the parts in
    words; `limit` [m], 0 if only penetration counts."""

    a: str
    b: str
    distance: float
    t: float
    limit: float
    p_WA: Vector
    p_WB: Vector
    place: str

    @property
    def message(self) -> str:
        """In a sentence."""
        return f"{self.distance:.2f} m, {self.a} and {self.b}, at {clock(self.t)}"


class RecordedVerdict(msgspec.Struct, frozen=True, kw_only=True, rename={"message": "told"}):
    """All of a verdict: its state and line, all checks, worst first, and what was found in order of severity and time.

    `head`, `rows`: checks as people read them, those of one kind and state in one row.  `told`: what standards foresee
    and what is not determined.  `dynamic`: the amplification that a standard foresees for this lift, and its source.
    `tables`: what only the scene knows, for the report.
    """

    red: bool
    line: str
    state: State = "amber"
    findings: tuple[Finding, ...] = ()
    not_looked_at: tuple[str, ...] = ()
    clearances: tuple[Clearance, ...] = ()
    checks: tuple[Check, ...] = ()
    head: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    message: tuple[str, ...] = ()
    dynamic: tuple[float, str] | None = None
    tables: tuple[Table, ...] = ()


def contents(rec: Recording) -> Contents:
    """Contents of a whole recording, read once."""
    with rec.reading():
        if rec.contents is not None:
            return rec.contents
        found = rec.contents = Contents()
        wanted = [x.name for x in rec.topics.values() if "port" in x.metadata or x.name.startswith(READ)]
        for name, raw in rec.stream(*wanted):
            topic = rec.topics[name]
            found.take(name, topic.metadata, topic.form, raw.publish_time, raw.data)
        found.end()
        return found


def recorded_verdict(rec: Recording) -> RecordedVerdict | None:
    """The verdict in a recording; None if it has none."""
    if not rec.result.get("verdict"):
        return None
    with rec.reading():
        return msgspec.convert(rec.fact("verdict"), RecordedVerdict)


def as_recorded(rec: Recording) -> list[str]:
    """Parts of a recording that are stored only in its result: the verdict, times of peaks, and a digest that cannot be
    computed again."""
    message = ["verdict"] if "verdict" in rec.result else []
    message += ["times of peaks"] if rec.fact("peaks", {}) else []
    return message + (["digest"] if contents(rec).unknown and "digest" in rec.result else [])


def recorded_peaks(rec: Recording) -> dict[str, Peak]:
    """Peak tension of each rope [N] and time [s] by its result."""
    with rec.reading():
        found = msgspec.convert(rec.fact("peaks", {}), dict[str, dict[str, float]])
        peaks = {name: Peak(peak["tension"], peak["time"]) for name, peak in found.items()}
        if not np.isfinite([*peaks.values()]).all():
            raise ValueError("a peak is no number")
        return peaks


def complaints(rec: Recording) -> list[str]:
    """Contradictions of a recording, as sentences: damaged bytes, or digest, number of samples or peaks that differ
    from events and rows."""
    if rec.complaints is None:
        rec.complaints = [f"{rec.path}: {what}" for what in _contradictions(rec) if what]
    return rec.complaints


def _contradictions(rec: Recording) -> list[str]:
    found, digest, peaks = contents(rec), rec.result.get("digest"), recorded_peaks(rec)
    message = [rec.damage()]
    if digest and found.torn:
        message.append(found.torn)
    elif digest and not found.unknown and found.digest != digest:
        message.append(f"events and rows give the digest {found.digest}, the result says {digest[:64]}")
    if "samples" in rec.result and (n := rec.fact("samples", 0)) != found.rows:
        message.append(f"there are {found.rows} samples, the result says {n:g}")
    for name in sorted(peaks.keys() | found.peaks.keys()) if rec.result else []:
        text, is_ = (x[name].tension if name in x else nan for x in (peaks, found.peaks))
        if not abs(text - is_) <= ROUNDED * max(abs(is_), 1e6):
            message.append(f"the peak of {name} is {is_ / 1e3:.6g} kN in the rows, the result says {text / 1e3:.6g} kN")
    return message


def opened(path: str | Path | Recording) -> Recording:
    """The recording at a path, or an open one."""
    return path if isinstance(path, Recording) else Recording(path)
