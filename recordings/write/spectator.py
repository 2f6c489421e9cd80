"""Whoever looks at a run while it goes on; this one is nobody."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from heavylift.recordings.format.samples import SampleLayout
from heavylift.recordings.format.viewer_messages import Box, RopeLine
from numpy.typing import NDArray


class Spectator:
    """Receives what is recorded: `begin`, then `event`, `ropes`, `samples` as they come, then `end`."""

    def begin(
        self, run: Mapping[str, object], layout: SampleLayout, boxes: Sequence[Box], lines: Sequence[RopeLine]
    ) -> None:
        """What is known before anything happens: facts of the run, columns of the samples, what is drawn."""

    def event(self, t_ns: int, source: str, port: str, type: str, payload: bytes) -> None:
        """An event on a port of a coupled model."""

    def ropes(self, t_ns: int, lines: Sequence[RopeLine]) -> None:
        """Other ropes hang from now on."""

    def samples(self, times: Sequence[int], rows: NDArray[np.float64]) -> None:
        """Simulation times [ns] and rows of samples."""

    def end(self, status: str, told: Mapping[str, str], peaks: Sequence[Mapping[str, object]], where: str) -> None:
        """How the run ended, what is to be said of that, the peaks of the ropes, and where the recording is."""


class Spectators(Spectator):
    """Several of them, one after the other."""

    def __init__(self, *those: Spectator) -> None:
        self._those = those

    def begin(
        self, run: Mapping[str, object], layout: SampleLayout, boxes: Sequence[Box], lines: Sequence[RopeLine]
    ) -> None:
        for each in self._those:
            each.begin(run, layout, boxes, lines)

    def event(self, t_ns: int, source: str, port: str, type: str, payload: bytes) -> None:
        for each in self._those:
            each.event(t_ns, source, port, type, payload)

    def ropes(self, t_ns: int, lines: Sequence[RopeLine]) -> None:
        for each in self._those:
            each.ropes(t_ns, lines)

    def samples(self, times: Sequence[int], rows: NDArray[np.float64]) -> None:
        for each in self._those:
            each.samples(times, rows)

    def end(self, status: str, told: Mapping[str, str], peaks: Sequence[Mapping[str, object]], where: str) -> None:
        for each in self._those:
            each.end(status, told, peaks, where)
