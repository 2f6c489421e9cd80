"""Receivers of the kernel's sample rows: nobody, the largest values only, or encoded batches for whoever records them.

A batch is [first, times, rows, notes, period, lift] in MessagePack, as `recordings/format/samples.py` reads it; rows of
a lift that is simulated apart are numbered by themselves. Rows in memory are kept by `coordinator/record/kept_rows.py`.
"""

from collections.abc import Callable, Sequence

import msgspec
import numpy as np
from heavylift.kernel.islands.islands import Islands
from heavylift.kernel.simulation.commands import LiftRowsView
from heavylift.kernel.simulation.native.native_functions import Stepping
from heavylift.kernel.simulation.native.samples import published
from heavylift.kernel.simulation.simulation import Simulation
from numpy.typing import NDArray

Row = tuple[int, NDArray[np.float64]]  # time [ns], and values as the kernel's `method` lays them out
Note = tuple[int, int, str]  # number, time [ns], sentence


class RowSink:
    """Receiver of sample rows that discards them; base class of all receivers."""

    most: NDArray[np.float64] = np.zeros(0)
    """The largest absolute value in each column of the samples so far, if the receiver keeps it."""

    def rows(
        self, method: Stepping, first: int, rows: Sequence[Row], notes: Sequence[Note] = (), period: int = 0
    ) -> None:
        """Receive consecutive sample rows from number `first` on, and notes; with a `period` [ns], the last row repeats
        while the scene is at rest."""

    def apart(self, lift: LiftRowsView, first: int, rows: Sequence[Row]) -> None:
        """Receive sample rows of one lift, which is simulated apart from the other lifts."""

    def paused(self, simulation: Simulation | Islands) -> None:
        """Called repeatedly during a long calculation; a subclass may raise HeavyliftError to end the calculation."""


class LargestRows(RowSink):
    """Receiver of sample rows that keeps the largest absolute value of each column."""

    def rows(
        self, method: Stepping, first: int, rows: Sequence[Row], notes: Sequence[Note] = (), period: int = 0
    ) -> None:
        """Update the largest values by sample rows, except by the row that repeats while a scene is at rest."""
        different = rows[:1] if all(row is rows[0][1] for _, row in rows) else rows
        values = published(method, np.array([row for _, row in different])).astype("<f8", copy=False)
        if not period:
            most = np.abs(values).max(axis=0)
            if not np.isfinite(most).all():
                most = np.where(np.isfinite(values), np.abs(values), 0.0).max(axis=0)
            self.most = np.maximum(most, self.most) if len(self.most) else most
        self._shown(values, first, [t for t, _ in rows], notes, period)

    def _shown(
        self, values: NDArray[np.float64], first: int, times: list[int], notes: Sequence[Note], period: int
    ) -> None:
        """Receive the published values, one row for all times if they are equal."""


class RowFrames(LargestRows):
    """Receiver of sample rows that publishes them as encoded batches."""

    def __init__(self, publish: Callable[[bytes], None]) -> None:
        self._publish = publish

    def _shown(
        self, values: NDArray[np.float64], first: int, times: list[int], notes: Sequence[Note], period: int
    ) -> None:
        more = (notes, period) if period else (notes,) if notes else ()
        self._publish(msgspec.msgpack.encode((first, times, values.tobytes(), *more)))

    def apart(self, lift: LiftRowsView, first: int, rows: Sequence[Row]) -> None:
        """Publish sample rows of one lift, which is simulated apart from the other lifts."""
        values = published(lift.method, np.array([row for _, row in rows])).astype("<f8", copy=False)
        batch = first, [t for t, _ in rows], values.tobytes(), (), 0, lift.name
        self._publish(msgspec.msgpack.encode(batch))
