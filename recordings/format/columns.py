"""The columns of a sample as they stand in the file: the numbers of `/samples`, then the poses, all of them rounded.

What would stand there twice is left out: coordinates of free joints, which the poses of their bodies tell.  Digest and
comparisons are made of these columns.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .rounding import Rounding
from .samples import POSE, POSE_COLUMNS, Field, SampleChannel, SampleLayout, sample_fields


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
