"""What a run has shown, as columns: times, poses, tensions, and which rope lines hung from when on.

Taken from the samples while they are recorded (`Collector`), or from a recording (`history_of`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from heavylift.nodes.statics.state import REEVING, reeved
from heavylift.recordings import Recording, SampleLayout
from heavylift.recordings.drawing import Rig, RopeLine
from heavylift.recordings.samples import POSE
from numpy.typing import NDArray

__all__ = ["Collector", "History", "history_of"]

Floats = NDArray[np.float64]
NUMBERS = ("rope/tension", "rope/length", REEVING)


@dataclass(frozen=True)
class History:
    """t (n,) [s], in order; poses: body -> (n, 7) [m, quaternion x y z w]; tensions: rope -> (n,), of its most
    loaded part [N]; unstretched
    lengths: rope -> (n,) [m]; rigs: the rope lines that hang, each set from its time on."""

    t: Floats
    poses: Mapping[str, Floats]
    tensions: Mapping[str, Floats]
    lengths: Mapping[str, Floats]
    rigs: Sequence[Rig]


class Collector:
    """Keeps of each sample row what a verdict is made of."""

    def __init__(self, layout: SampleLayout) -> None:
        self._bodies = [c.topic.removeprefix(POSE) for c in layout.channels if c.topic.startswith(POSE)]
        columns = [i for c in layout.channels if c.topic.startswith(POSE) for i in range(c.start, c.stop)]
        self._names: list[list[str]] = []
        for topic in NUMBERS:
            channel = layout.find(topic)
            self._names.append(list(channel.names) if channel else [])
            columns += range(channel.start, channel.stop) if channel else []
        self._columns = np.array(columns, np.intp)
        self._times: list[int] = []
        self._rows: list[Floats] = []
        self.rigs: list[Rig] = []

    def samples(self, first: int, times: Sequence[int], rows: Floats) -> None:
        """Rows (m, width) at these times [ns], numbered from `first` on; what is here already is passed over."""
        skip = len(self._times) - first
        if skip < len(times):
            self._times += times[skip:]
            self._rows.append(rows[skip:, self._columns])

    def ropes(self, t_ns: int, lines: Sequence[RopeLine]) -> None:
        """These lines hang from now on."""
        self.rigs.append(Rig(t_ns, list(lines)))

    def history(self) -> History:
        """All of it, once the run is over."""
        t = np.array(self._times, np.float64) * 1e-9
        table = np.empty((len(self._columns), len(t)))  # a column is one piece of memory, as all sums run along it
        if self._rows:
            np.concatenate([rows.T for rows in self._rows], axis=1, out=table)
        columns = iter(table[7 * len(self._bodies) :])
        poses = {body: table[7 * i : 7 * i + 7].T for i, body in enumerate(self._bodies)}
        tensions, lengths, parts = [{name: next(columns) for name in names} for names in self._names]
        return History(t, poses, tensions | _most(parts), lengths, self.rigs)


def history_of(rec: Recording) -> History:
    """What a recording holds of it."""
    bodies = [name for name in rec.signals() if name.startswith(POSE)]
    rec.load([*bodies, *(name for name in NUMBERS if name in rec.signals())])
    t = np.zeros(0)
    numbers: dict[str, dict[str, Floats]] = {name: {} for name in NUMBERS}
    for name in (x for x in NUMBERS if x in rec.signals()):
        signal = rec.signal(name)
        numbers[name] = {x: signal.values[:, i] for i, x in enumerate(signal.names)}
        t = signal.t
    poses = {name.removeprefix(POSE): rec.signal(name).values for name in bodies}
    tensions, lengths, parts = numbers.values()
    return History(rec.signal(bodies[0]).t if bodies else t, poses, tensions | _most(parts), lengths, rec.rigs())


def _most(parts: Mapping[str, Floats]) -> dict[str, Floats]:
    """Of ropes over sheaves the most loaded part at each time."""
    found: dict[str, Floats] = {}
    for part, tension in parts.items():
        rope = reeved(part)
        found[rope] = np.maximum(found[rope], tension) if rope in found else tension
    return found
