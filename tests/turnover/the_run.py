"""Helpers of the turnover tests: the run and its stages."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from heavylift.coordinator.run import RunResult
from stock_reader import Array


@dataclass(frozen=True)
class Lift:
    """The recording, how the run ended, and the folder of the machine code, which was empty before."""

    path: Path
    result: RunResult
    code: Path


@dataclass(frozen=True)
class Stage:
    """From when to when [s], and the numbers of the samples in between."""

    start: float
    end: float
    samples: Array

    def last(self, seconds: float) -> Array:
        """The samples of its last seconds, two to the second."""
        return self.samples[-round(2 * seconds) :]
