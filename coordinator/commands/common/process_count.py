"""Measure how many processes are fastest on this machine: the beginning of a run with one, two, four ... processes.

The gain of a process depends on how long the models work between two messages and on the cost of a message, which are
known only on this machine. The first trial gives the simulation time that one process reaches in a second; each other
trial runs up to this time, and is cut when it takes longer than the best. The number does not change any bit of a run.
"""

import time
from collections.abc import Callable

from heavylift.coordinator.run.watch import RunObserver
from heavylift.coordinator.supervision.pool import cores
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.devs import NEVER, Event

TRIED_s = 1.0  # of wall time, long beside what starting and a busy moment add
GAIN = 1.1  # so many times as fast must more processes be: less is noise, and they take memory


class _StretchDone(Exception):
    """Ends a trial run: its simulation time is reached, or it takes too long."""


class _TimedStretch(RunObserver):
    """Ends a run at simulation time `until` [ns], or `limit` seconds of wall time after its first grants."""

    def __init__(self, limit: float, until: int) -> None:
        self._limit, self._until = limit, until
        self._began: float | None = None
        self.spent, self.reached = 0.0, 0  # wall time [s], and the time of the run [ns]

    def event(self, event: Event) -> None:
        """Note the simulation time of an event, and end the trial run once enough simulation time has passed."""
        self.reached = event.t
        self.waiting()

    def waiting(self) -> None:
        """End the trial run, by raising _StretchDone, at its limit of simulation time or of wall time."""
        now = time.perf_counter()
        if self._began is None:
            self._began = now
        self.spent = now - self._began
        if self.reached >= self._until or self.spent > self._limit:
            raise _StretchDone


def paying(run: Callable[[int, RunObserver], object], models: int, most: int | None = None) -> tuple[int, str]:
    """Measure with how many processes a run is fastest; return their number and a sentence with the measured times.

    `run(count, watch)` starts a trial run.
    """
    most = min(models, cores() if most is None else most)
    until, best, found, notes = NEVER, 1, TRIED_s, list[str]()
    for count in sorted({*(2**i for i in range(most.bit_length())), most}):
        stretch = _TimedStretch(found, until)
        try:
            run(count, stretch)
            whole = True
        except _StretchDone:
            whole = False
        except HeavyliftError:
            break
        if count == 1:
            until, found = stretch.reached, stretch.spent
            part = "all" if whole else f"the first {until * 1e-9:.4g} s"
            notes = [f"1 process takes {found:.2f} s for {part} of the run"]
            if whole:
                break
            if not until:
                return most, f"its models work for {TRIED_s:g} s before anything is said"
        elif stretch.reached < until:
            notes.append(f"{count} take longer")
        else:
            notes.append(f"{count} take {stretch.spent:.2f} s")
            if stretch.spent * GAIN < found:
                best, found = count, stretch.spent
    return best, ", ".join(notes) or "the run fails"
