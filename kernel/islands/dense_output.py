"""Values of a run at any time between samples: the run is repeated, and the dense output of its steps is read at these
times.

Steps do not depend on samples or subscribers, so the second run equals the first to the last bit.
"""

from collections import deque
from collections.abc import Callable, Sequence
from hashlib import sha256

import numpy as np
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.switching import StateChange
from heavylift.kernel.simulation.native.samples import published
from heavylift.kernel.simulation.simulation import Simulation
from numpy.typing import NDArray

from .islands import Islands


class DenseRows:
    """Reads sample rows (columns,) of a simulation at given ascending times [ns], after the events at each time."""

    def __init__(self, simulation: Simulation | Islands, instants: Sequence[int]) -> None:
        self._simulation, self._waiting = simulation, deque(instants)
        self._run, self._fire = simulation.run, simulation.fire
        self.rows: list[NDArray[np.float64]] = []
        if instants:
            simulation.run, simulation.fire = self.run, self.fire  # type: ignore[method-assign]

    def run(self, until_ns: int, pause: Callable[[], None] = lambda: None) -> None:
        """Run the simulation, stopping at the requested times before `until_ns`."""
        s = self._simulation
        while self._waiting and self._waiting[0] < until_ns:
            self._run(self._waiting[0], pause)
            if s.event and s.next_ns <= self._waiting[0]:
                return
            self._look()
        self._run(until_ns, pause)

    def fire(self) -> list[StateChange]:
        """Execute the located event of the simulation, after reading the rows at the requested times before it."""
        if self._waiting and self._waiting[0] < self._simulation.next_ns:
            self.run(self._simulation.next_ns)
        return self._fire()

    def finish(self) -> NDArray[np.float64]:
        """Return the rows (n, columns) at all requested times, after the run."""
        while self._waiting:
            self._look()
        return np.array(self.rows)

    def _look(self) -> None:
        row = self._simulation.shown(self._waiting.popleft())
        self.rows.append(published(self._simulation.method, row[None])[0])


def instants_of(times: object, start: float, end: float, before: bool) -> NDArray[np.int64]:
    """Convert times [s] within a run to integer nanoseconds (n,), or one less if `before`; raises KernelError for times
    outside the run."""
    try:
        t = np.atleast_1d(np.asarray(times, np.float64))
    except (TypeError, ValueError):
        raise KernelError(f"at: {times!r:.60} are not times; give seconds") from None
    if t.ndim != 1 or not np.isfinite(t).all():
        raise KernelError("at: give one finite time [s] or a list of finite times")
    ns, last = np.round(t * 1e9).astype(np.int64), round(end * 1e9)
    outside = t[(ns < round(start * 1e9)) | (ns > last + 1)]  # a scene ends a nanosecond before the time of its end
    if len(outside):
        raise KernelError(f"at: {outside[0]:.10g} s is outside the run, which lasts from {start:g} to {end:.10g} s")
    return np.minimum(np.maximum(ns - before, 0), last)


def trail_of(rows: Sequence[tuple[int, NDArray[np.float64]]]) -> str:
    """Return a digest of all sample rows of a run; equal runs have equal digests."""
    return sha256(b"".join(row.tobytes() for _, row in rows)).hexdigest()


def check_same(now: str, before: str) -> None:
    """Raise KernelError if a repeated run differs from the first run; the digests of their sample rows are compared."""
    if now != before:
        raise KernelError("at: the run cannot be repeated, since code that it uses has been edited; simulate again")
