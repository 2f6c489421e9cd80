"""The rows of a run that stays in memory, and a wall-clock limit that can end it."""

import time
from collections.abc import Sequence
from itertools import groupby
from math import inf

import numpy as np
from heavylift.coordinator.participants.rows import Note, Row, RowSink
from heavylift.kernel.errors import KernelError
from heavylift.kernel.islands.islands import Islands
from heavylift.kernel.simulation.commands import LiftRowsView
from heavylift.kernel.simulation.native.native_functions import Stepping
from heavylift.kernel.simulation.native.samples import published
from heavylift.kernel.simulation.simulation import Simulation
from numpy.typing import NDArray

PIECE = 512  # rows that are read together: so few that they stay in the cache of the processor


class KeptRows(RowSink):
    """Receiver of sample rows that keeps them in memory."""

    def __init__(self) -> None:
        self.kept: list[tuple[Stepping, Row]] = []  # beside the code whose row it is
        self.sentences: list[tuple[int, str]] = []
        self.of_lifts: dict[str, list[Row]] = {}
        self.limit(inf, "")

    def limit(self, allowed: float, cut: str) -> None:
        """Set a limit of wall time [s] from now on, after which the run ends with an error that begins with `cut`."""
        self._allowed, self._cut, self._deadline = allowed, cut, time.perf_counter() + allowed

    def paused(self, simulation: Simulation | Islands) -> None:
        """Called during long calculations; raises KernelError once the limit of wall time has passed."""
        if time.perf_counter() > self._deadline:
            raise KernelError(f"{self._cut} {self._allowed:.3g} s of wall time, at {simulation.now:.3f} s of the run")

    def rows(
        self, method: Stepping, first: int, rows: Sequence[Row], notes: Sequence[Note] = (), period: int = 0
    ) -> None:
        """Keep sample rows and notes."""
        self.kept += [(method, row) for row in rows]
        self.sentences += [(t_ns, sentence) for _, t_ns, sentence in notes]

    def apart(self, lift: LiftRowsView, first: int, rows: Sequence[Row]) -> None:
        """Keep sample rows of one lift, which is simulated apart from the other lifts."""
        shown = published(lift.method, np.array([row for _, row in rows]))
        self.of_lifts.setdefault(lift.name, []).extend(zip([t for t, _ in rows], shown, strict=True))

    def table(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return times (n,) [ns] and rows (n, width) of all samples."""
        parts = []
        for first in range(0, len(self.kept), PIECE):
            for _, group in groupby(self.kept[first : first + PIECE], key=lambda x: id(x[0])):
                some = list(group)
                parts.append(published(some[0][0], np.array([row for _, (_, row) in some])))
        return np.array([t for _, (t, _) in self.kept], np.int64), np.concatenate(parts)
