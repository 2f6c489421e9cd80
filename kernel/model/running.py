"""What those who ask a running simulation about its present instant see of it."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from .evaluation import Evaluation
from .program import Program

__all__ = ["Running"]


class Running(Protocol):
    """A simulation, or its native state, as it stands; `[name]` of its state vector X included."""

    @property
    def program(self) -> Program: ...
    @property
    def P(self) -> np.ndarray: ...
    @property
    def state(self) -> np.ndarray: ...
    def __getitem__(self, name: str) -> float: ...
    def instant(self) -> Evaluation: ...
