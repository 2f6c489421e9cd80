"""What the tables of a report read: the recording with its verdict, plan and peaks."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format import machines
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import RecordedVerdict, recorded_peaks, recorded_verdict
from heavylift.recordings.write.sink import Peak


@dataclass(frozen=True)
class Facts:
    """A recording with its verdict, if any, and its plan as plain data."""

    rec: Recording
    verdict: RecordedVerdict | None
    plan: dict[str, Any] = field(repr=False)

    @cached_property
    def peaks(self) -> dict[str, Peak]:
        """Peak tension of each rope in its result."""
        return recorded_peaks(self.rec)

    @cached_property
    def stages(self) -> list[tuple[float, str]]:
        """Begin of each stage [s], and its name."""
        return [*self.rec.stages()]

    def stage_at(self, t: float) -> str:
        """Name of the stage at a time [s]."""
        return next((name for at, name in reversed(self.stages) if at <= t), "")


def facts(rec: Recording, verdict: RecordedVerdict | None = None) -> Facts:
    """Facts of a recording; `verdict`: replaces a missing one. Raises RecordingError for a DEVS model."""
    with rec.reading():
        if "model" in rec.run:
            raise RecordingError(
                f"{rec.path}: a DEVS model lifts nothing to report; `heavylift info` prints its results"
            )
        return Facts(rec, verdict or recorded_verdict(rec), machines.plan_of(rec.attachments))
