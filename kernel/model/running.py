"""What those who watch or ask a running simulation see of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, Protocol

import numpy as np
from heavylift.kernel.compiler.function import Outputs
from heavylift.kernel.description.notes import Note

from .evaluation import Evaluation
from .program import Program

__all__ = ["Running"]


class Running(Protocol):
    """A simulation (`simulation.Simulation`) as it stands, `[name]` of its state vector X included."""

    X: np.ndarray
    P: np.ndarray
    M: np.ndarray | None
    epoch: int
    program: Program
    notes: list[Note]

    @property
    def method(self) -> Any: ...
    @property
    def _at(self) -> Outputs: ...
    @property
    def state(self) -> np.ndarray: ...
    def __getitem__(self, name: str) -> float: ...
    def _set(self, **values: float) -> None: ...
    def _forced(self, t: float) -> None: ...
    def _close(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]: ...
    def rate_at(self, t: float, among: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]: ...
    def row(self) -> SimpleNamespace: ...
    def instant(self) -> Evaluation: ...
