"""The energy balance of a run: kinetic + potential + stored - work + heat must stay what it was at the start.

Work of drives and winches and heat of every damper, brake, rope and stop are integrated from their own powers by the
kernel, so a law whose power is not counted shows up here as an error.
"""

import numpy as np
from heavylift.recordings import SampleLayout


class EnergyAudit:
    """Largest imbalance [J] and energy turned over [J]: what drives and winches moved up or down, all heat, and what
    went in and out of motion."""

    def __init__(self, layout: SampleLayout) -> None:
        self._energy, self._accounts = layout.find("energy"), layout.find("account")
        names = self._accounts.names if self._accounts else []
        self._works = [i for i, n in enumerate(names) if n.endswith(".work")]
        self._start: float | None = None
        self._last_works: np.ndarray | None = None
        self._heat = 0.0
        self._moved = 0.0
        self._slow, self._fast = np.inf, -np.inf  # least and largest kinetic energy
        self.imbalance = 0.0

    def add(self, rows: np.ndarray) -> None:
        """(n, columns) samples in order."""
        if self._energy is None:
            return
        kinetic, potential, stored, work, heat = rows[:, self._energy.start : self._energy.stop].T
        total = kinetic + potential + stored - work + heat
        if self._start is None:
            self._start = float(total[0])
        self.imbalance = max(self.imbalance, float(np.abs(total - self._start).max()))
        self._heat = abs(float(heat[-1]))  # less than nothing only where the steps are wrong
        self._slow, self._fast = min(self._slow, float(kinetic.min())), max(self._fast, float(kinetic.max()))
        if self._accounts is not None and self._works:
            works = rows[:, [self._accounts.start + i for i in self._works]]
            before = works[:1] if self._last_works is None else self._last_works[None]
            steps = np.abs(np.diff(np.vstack([before, works]), axis=0)).sum(axis=1)
            self._moved = float(np.cumsum([self._moved, *steps])[-1])  # in order, whatever the batches
            self._last_works = works[-1]

    @property
    def turned_over(self) -> float:
        return self._moved + self._heat + max(0.0, self._fast - self._slow)

    @property
    def error(self) -> float:
        """Imbalance as a fraction of the energy turned over."""
        return self.imbalance / self.turned_over if self.turned_over else 0.0
