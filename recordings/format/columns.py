"""The columns of a sample as they stand in the file: the numbers of `/samples`, then the poses, all of them rounded.

What would stand there twice is left out: coordinates of free joints, which the poses of their bodies tell.  Digest and
comparisons are made of these columns.

Numbers are recorded in steps far below what any reader can need.  The last digits of a double are noise of the
integration, and noise cannot be packed: a sample of exact doubles takes 1.9 kB, of rounded ones 1.1 kB.  A step is a
binary fraction of the unit (4e-12 m, 2e-10 m/s, 6e-5 N, 6e-5 J, 1 us) or a billionth (of energies a millionth) of the
largest value that the column has had so far, whichever is finer; numbers in other units are kept as they are.  Tensions
computed anew from recorded poses still agree to 1e-9 of the largest.  The digest is taken from the rounded numbers:
whoever reads the file can compute it again.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .samples import POSE, POSE_COLUMNS, Field, SampleChannel, SampleLayout, sample_fields

LENGTH, ROTATION, SPEED = (38, 30), (42, 0), (32, 30)
# by unit: a step is 2^-first of it or 2^-second of the largest value
STEPS = {"m": LENGTH, "rad": LENGTH, "m or rad": LENGTH, "m/s": SPEED, "rad/s": SPEED, "m/s or rad/s": SPEED}
STEPS |= {"N": (14, 30), "N m": (14, 30), "J": (14, 20), "s": (20, 0)}
NOTHING = -40  # power of two of what is no value


class Columns:
    """Columns of the rows of one layout: `fields` of the numbers, then `bodies` with seven columns each."""

    def __init__(self, layout: SampleLayout) -> None:
        poses = [channel for channel in layout.channels if channel.topic.startswith(POSE)]
        kept = [_picked(channel) for channel in layout.channels if not channel.topic.startswith(POSE)]
        every = [*kept, *((channel, [*range(channel.start, channel.stop)]) for channel in poses)]
        self.fields: list[Field] = sample_fields([channel for channel, _ in kept])
        self.bodies = [channel.topic.removeprefix(POSE) for channel in poses]
        self.signals: dict[str, slice] = {}  # of a recorded row, by name
        at = 0
        for channel, columns in every:
            self.signals[channel.topic] = slice(at, at := at + len(columns))
        self.numbers = at - 7 * len(poses)
        self._columns = np.array([i for _, columns in every for i in columns], np.intp)
        most = [layout.most[i] for i in self._columns] if layout.recalled else []
        self._rounded = Rounding([channel for channel, _ in every], layout.recalled, most)

    def __len__(self) -> int:
        return len(self._columns)

    def spread(self, recorded: NDArray[np.float64], width: int) -> NDArray[np.float64]:
        """(n, width) rows of recorded ones; what is not recorded is 0."""
        rows = np.zeros((len(recorded), width))
        rows[:, self._columns] = recorded
        return rows

    def __call__(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, recorded columns) of rows (n, width); all rows of a run one after the other."""
        return self._rounded(rows[:, self._columns])


def _picked(channel: SampleChannel) -> tuple[SampleChannel, list[int]]:
    """The channel without the coordinates of free joints, and the columns of the row that it keeps."""
    parts, names = [name.rpartition(".") for name in channel.names], {*channel.names}
    free = {joint for joint, _, _ in parts if all(f"{joint}.{x}" in names for x in POSE_COLUMNS)}
    if channel.topic != "joint/position":
        free = set()
    kept = [i for i, (joint, _, x) in enumerate(parts) if joint not in free or x not in POSE_COLUMNS]
    some = [channel.names[i] for i in kept]
    return SampleChannel(channel.topic, some, channel.unit, 0, len(kept)), [channel.start + i for i in kept]


class Rounding:
    """Rounds the columns of these channels, side by side in their order, row after row of a run."""

    def __init__(self, channels: list[SampleChannel], recalled: int = 0, most: Sequence[float] = ()) -> None:
        """The first `recalled` rows are rounded already, from columns that were as large as `most`."""
        steps: list[tuple[int, int] | None] = []
        for channel in channels:
            pose = channel.topic.startswith(POSE)
            steps += 3 * [LENGTH] + 4 * [ROTATION] if pose else len(channel.names) * [STEPS.get(channel.unit)]
        self._exact = np.array([step is None for step in steps], bool)
        powers = np.array([step or (0, 0) for step in steps], np.intp).reshape(-1, 2)
        self._finest, self._digits = powers.T  # powers of two: of the unit, of the largest value
        self._recalled = recalled
        self._largest = np.full(len(steps), NOTHING, np.int32)  # its power of two
        if recalled:
            self._largest = _powers(np.asarray(most, np.float64))
        self._scale = self._scaled(self._largest)

    def _scaled(self, largest: NDArray[np.int32]) -> NDArray[np.float64]:
        """Steps in a unit, where the largest values so far are of these powers of two."""
        scale: NDArray[np.float64] = np.ldexp(1.0, np.maximum(self._finest, self._digits - largest))
        return scale

    def __call__(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, columns) rounded; zeros are positive."""
        if self._recalled:
            known, rows = np.split(rows, [self._recalled])
            self._recalled -= len(known)
            return np.concatenate([known, self(rows)]) if len(rows) else known
        sizes = np.where(np.isfinite(rows), np.abs(rows), 0.0)
        top = np.maximum(self._largest, _powers(sizes.max(axis=0, initial=0.0)))
        scale = self._scaled(top)
        if np.array_equal(scale, self._scale):
            self._largest = top
        else:  # it is the rows before that count, however they are cut into batches
            largest = np.maximum.accumulate(np.vstack([self._largest, _powers(sizes)]))[1:]
            scale = self._scaled(largest)
            self._largest, self._scale = largest[-1], scale[-1]
        with np.errstate(over="ignore", invalid="ignore"):
            out: NDArray[np.float64] = np.rint(rows * scale) / scale + 0.0
        np.copyto(out, rows, where=self._exact | ~np.isfinite(out))
        return out


def _powers(sizes: NDArray[np.float64]) -> NDArray[np.int32]:
    """The power of two above each size."""
    return np.where(sizes > 0.0, np.maximum(np.frexp(sizes)[1], NOTHING), NOTHING)
