"""The kernel of a run that stays in memory: it stores its samples, and a wall-clock limit can end the run."""

import time
from collections.abc import Sequence
from itertools import groupby

import numpy as np
from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.coordinator.participants.parts import KernelConfig
from heavylift.kernel.errors import KernelError
from heavylift.kernel.islands.dense_output import DenseRows
from heavylift.kernel.simulation.commands import LiftRowsView
from heavylift.kernel.simulation.native.native_functions import Stepping
from heavylift.kernel.simulation.native.samples import published
from numpy.typing import NDArray

PIECE = 512  # rows that are read together: so few that they stay in the cache of the processor


class KeepingKernel(KernelNode):
    """A kernel that keeps its samples in memory, and ends with an error when its run exceeds the `allowed` wall time
    [s]."""

    def __init__(self, config: KernelConfig, instants: Sequence[int], allowed: float, cut: str) -> None:
        super().__init__(config, lambda batch: None)
        self.looks = DenseRows(self.simulation, instants)
        self.kept: list[tuple[Stepping, tuple[int, np.ndarray]]] = []  # beside the code whose row it is
        self.sentences: list[tuple[int, str]] = []
        self.of_lifts: dict[str, list[tuple[int, np.ndarray]]] = {}
        self._allowed, self._cut, self._deadline = allowed, cut, time.perf_counter() + allowed

    def _pause(self) -> None:
        super()._pause()
        if time.perf_counter() > self._deadline:
            raise KernelError(
                f"{self._cut} {self._allowed:.3g} s of wall time, at {self.simulation.now:.3f} s of the run"
            )

    def _batch(self, rows: list[tuple[int, np.ndarray]], notes: list[tuple[int, int, str]], period: int = 0) -> None:
        self.kept += [(self.simulation.method, row) for row in rows]
        self.sentences += [(t_ns, sentence) for _, t_ns, sentence in notes]

    def _batch_apart(self, lift: LiftRowsView, rows: list[tuple[int, np.ndarray]]) -> None:
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
