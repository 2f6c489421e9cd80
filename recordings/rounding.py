"""How finely numbers are recorded: in steps far below what any reader can need.

The last digits of a double are noise of the integration, and noise cannot be packed: a sample of exact doubles takes
1.9 kB, of rounded ones 1.1 kB.  A step is a binary fraction of the unit (4e-12 m, 2e-10 m/s, 6e-5 N, 6e-5 J, 1 us)
or a billionth (of energies a millionth) of the largest value that the column has had so far, whichever is finer;
numbers in other units are kept as they are.  Tensions computed anew from recorded poses still agree to 1e-9 of the
largest.  The digest is taken from the rounded numbers: whoever reads the file can compute it again.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .samples import POSE, SampleChannel

__all__ = ["Rounding"]

LENGTH, ROTATION, SPEED = (38, 30), (42, 0), (32, 30)
# by unit: a step is 2^-first of it or 2^-second of the largest value
STEPS = {"m": LENGTH, "rad": LENGTH, "m or rad": LENGTH, "m/s": SPEED, "rad/s": SPEED, "m/s or rad/s": SPEED}
STEPS |= {"N": (14, 30), "N m": (14, 30), "J": (14, 20), "s": (20, 0)}


class Rounding:
    """Rounds the columns of these channels, side by side in their order, row after row of a run."""

    def __init__(self, channels: list[SampleChannel]) -> None:
        steps: list[tuple[int, int] | None] = []
        for channel in channels:
            pose = channel.topic.startswith(POSE)
            steps += 3 * [LENGTH] + 4 * [ROTATION] if pose else len(channel.names) * [STEPS.get(channel.unit)]
        self._exact = np.array([step is None for step in steps], bool)
        powers = np.array([step or (0, 0) for step in steps], np.intp).reshape(-1, 2)
        self._scale, self._digits = np.ldexp(1.0, powers[:, 0]), powers[:, 1]
        self._largest = np.zeros(len(steps))

    def __call__(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, columns) rounded; zeros are positive."""
        sizes = np.abs(np.where(np.isfinite(rows), rows, 0.0))
        sizes[0] = np.maximum(sizes[0], self._largest)
        largest = np.maximum.accumulate(sizes)
        self._largest = largest[-1]
        with np.errstate(over="ignore", invalid="ignore"):
            scale = np.maximum(self._scale, np.ldexp(1.0, self._digits - np.frexp(largest)[1]))
            out: NDArray[np.float64] = np.rint(rows * scale) / scale + 0.0
        np.copyto(out, rows, where=self._exact | ~np.isfinite(out))
        return out
