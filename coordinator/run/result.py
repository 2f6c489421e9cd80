"""The result of a run in this process: its signals as named arrays in SI units, stages, events and verdict."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from heavylift.coordinator.record.in_memory import Played
from heavylift.kernel.errors import KernelError, RecordingError, SignalError, extra
from heavylift.kernel.islands.dense_output import instants_of
from heavylift.recordings.format.schema import RecordedEvent
from heavylift.recordings.format.text import meant
from heavylift.recordings.read.signal import Signal, titles
from heavylift.recordings.read.verdict import RecordedVerdict
from heavylift.recordings.write.sink import Peak
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas

Floats = NDArray[np.float64]
Again = Callable[[list[int]], dict[str, Signal]]  # signals of the same run at other instants [ns]

SINCE_A_SAMPLE = ("rope/peak", "rope/peak_time")  # what they show is not a state


class StageSpan(NamedTuple):
    """A stage of the action list, with its start and end [s]."""

    name: str
    start: float
    end: float


class Course(NamedTuple):
    """What happened in a run: stages, peaks of rope tension, recorded events, notes of the kernel with times [s]."""

    stages: list[StageSpan]
    peaks: dict[str, Peak]
    events: list[RecordedEvent]
    notes: list[tuple[float, str]]


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """Results of a simulated run: sampled signals, stages, peak tensions and recorded events.

    Sample times (n,) [s]; signals by name; peak tension [N] and time [s] of each rope; notes of the kernel with times
    [s]; conditions for which the action list still waited. All but the signals is computed on first use.

    Times repeat where an event or order coincides with a sample: the first row is before it, the last one after it.
    `at` has other times, each once.
    """

    t: NDArray[np.float64]
    signals: dict[str, Signal]
    unfinished: str
    _found: Callable[[], Course]
    _run: Played | None = None
    _again: Again | None = None

    @cached_property
    def course(self) -> Course:
        """Stages, peaks, events and notes of the run."""
        return self._found()

    @property
    def stages(self) -> list[StageSpan]:
        """The stages of the action list in their order."""
        return self.course.stages

    @property
    def peaks(self) -> dict[str, Peak]:
        """The largest tension [N] of each rope, with its time [s]."""
        return self.course.peaks

    @property
    def events(self) -> list[RecordedEvent]:
        """The events of the run in their total order."""
        return self.course.events

    @property
    def notes(self) -> list[tuple[float, str]]:
        """The notes of the kernel, with times [s]."""
        return self.course.notes

    @cached_property
    def verdict(self) -> RecordedVerdict | None:
        """The verdict of the run; None for a run of a bare kernel system, which has no checks."""
        return self._run.verdict if self._run else None

    @cached_property
    def digest(self) -> str:
        """The digest of the run, the same as in its recording; "" for a run of a bare kernel system."""
        return self._run.digest if self._run else ""

    def at(self, times: Floats | Sequence[float] | float, before: bool = False) -> "Result":
        """Return the results with the signals evaluated at these times [s], from the integrator's dense output.

        At an event or order, values are those after it, or (`before`) those of a nanosecond earlier. The run is
        repeated for this, with the same duration. Raises KernelError for times outside of the run, or if the repeated
        run differs because code that it uses was edited.
        """
        if self._again is None:
            raise KernelError(
                "at: this result was pickled, which keeps only its samples; call "
                "`at` before pickling, or simulate again"
            )
        asked = instants_of(times, self.t[0], self.t[-1], before)
        instants, places = np.unique(asked, return_inverse=True)
        found = self._again(instants.tolist())
        t = np.atleast_1d(np.asarray(times, np.float64))
        signals = {
            name: Signal(t, x.values[places], x.names, x.unit, name)
            for name, x in found.items()
            if name not in SINCE_A_SAMPLE
        }
        return replace(self, t=t, signals=signals)

    def __getstate__(self) -> dict[str, object]:
        found = {"course": self.course, "verdict": self.verdict, "digest": self.digest}
        return {**vars(self), **found, "_found": None, "_run": None, "_again": None}

    def __getitem__(self, name: str) -> Signal:
        """The signal of this name, such as "rope/tension"; raises SignalError that lists all names."""
        if name not in self.signals:
            raise SignalError(f"the result has no signal {name}; {meant(name, list(self.signals))}")
        return self.signals[name]

    def to_pandas(self) -> "pandas.DataFrame":
        """Return all signals as a DataFrame: index time [s], which may repeat; columns `signal/column [unit]`."""
        how = "install heavylift[pandas] or use .t and [name]"
        library = extra("pandas", RecordingError(f"a DataFrame needs pandas; {how}"))
        columns = {
            f"{name}/{title}": signal.values[:, i]
            for name, signal in self.signals.items()
            for i, title in enumerate(titles(signal))
        }
        return library.DataFrame(columns, index=library.Index(self.t, name="time [s]"))

    def __repr__(self) -> str:
        message = f"; {self.verdict.line}" if self.verdict else ""
        span = f"{self.t[0]:g} to {self.t[-1]:g} s" if len(self.t) else "nothing"
        return f"<Result: {span}, {len(self.t)} samples of {', '.join(self.signals) or 'no signal'}{message}>"
