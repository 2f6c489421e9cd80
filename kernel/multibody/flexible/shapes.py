"""What the limits of small deflections and buckling depend on of a body's modes."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from heavylift.kernel.description.flexible import Flexible

__all__ = ["Shapes"]


class Shapes(Protocol):
    """Part of `modes.Modes`: shapes (6n, m) and masses (m,) of m modes at n nodes (n, 3) [m]; M (6n, 6n)."""

    @property
    def flexible(self) -> Flexible: ...
    @property
    def nodes(self) -> np.ndarray: ...
    @property
    def M(self) -> np.ndarray: ...
    @property
    def shapes(self) -> np.ndarray: ...
    @property
    def mass(self) -> np.ndarray: ...
    def at(self, station: int | float) -> np.ndarray: ...
