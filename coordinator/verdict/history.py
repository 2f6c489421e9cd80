"""What a run has shown, as columns: times, poses, tensions, and which rope lines hung from when on.

Taken from the samples while they are recorded (`Collector`), or from a recording (`history_of`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from heavylift.recordings import Recording, SampleLayout
from heavylift.recordings.drawing import Rig, RopeLine
from heavylift.recordings.samples import POSE
from numpy.typing import NDArray

__all__ = ["Collector", "History", "history_of"]

Floats = NDArray[np.float64]
TENSION = "rope/tension"


@dataclass(frozen=True)
class History:
    """t (n,) [s], in order; poses: body -> (n, 7) [m, quaternion x y z w]; tensions: rope -> (n,) [N]; rigs: the rope
    lines that hang, each set from its time on."""

    t: Floats
    poses: Mapping[str, Floats]
    tensions: Mapping[str, Floats]
    rigs: Sequence[Rig]


class Collector:
    """Keeps of each sample row what a verdict is made of."""

    def __init__(self, layout: SampleLayout) -> None:
        self._bodies = [c.topic.removeprefix(POSE) for c in layout.channels if c.topic.startswith(POSE)]
        columns = [i for c in layout.channels if c.topic.startswith(POSE) for i in range(c.start, c.stop)]
        tension = layout.find(TENSION)
        self._ropes = list(tension.names) if tension else []
        columns += range(tension.start, tension.stop) if tension else []
        self._columns = np.array(columns, np.intp)
        self._times: list[int] = []
        self._rows: list[Floats] = []
        self.rigs: list[Rig] = []

    def samples(self, times: Sequence[int], rows: Floats) -> None:
        """Rows (m, width) at these times [ns]."""
        self._times += times
        self._rows.append(rows[:, self._columns])

    def ropes(self, t_ns: int, lines: Sequence[RopeLine]) -> None:
        """These lines hang from now on."""
        self.rigs.append(Rig(t_ns, list(lines)))

    def history(self) -> History:
        """All of it, once the run is over."""
        t = np.array(self._times, np.float64) * 1e-9
        rows = np.concatenate(self._rows) if self._rows else np.zeros((0, len(self._columns)))
        poses = {body: rows[:, 7 * i : 7 * i + 7] for i, body in enumerate(self._bodies)}
        tensions = {rope: rows[:, 7 * len(self._bodies) + i] for i, rope in enumerate(self._ropes)}
        return History(t, poses, tensions, self.rigs)


def history_of(rec: Recording) -> History:
    """What a recording holds of it."""
    names = [name for name in rec.signals() if name.startswith(POSE)]
    rec.load([*names, *([TENSION] if TENSION in rec.signals() else [])])
    tension = rec.signal(TENSION) if TENSION in rec.signals() else None
    tensions = {name: tension.values[:, i] for i, name in enumerate(tension.names)} if tension else {}
    t = rec.signal(names[0]).t if names else tension.t if tension else np.zeros(0)
    return History(t, {name.removeprefix(POSE): rec.signal(name).values for name in names}, tensions, rec.rigs())
