"""What the small recorded run consists of: names, sample times, and its one kind of event."""

from __future__ import annotations

import msgspec

SECOND = 1_000_000_000
NAMES = ["west.H1", "west.H2"]
POSE = ["x", "y", "z", "qx", "qy", "qz", "qw"]
TIMES = [0, SECOND, 2 * SECOND, 2_500_000_000, 3 * SECOND, 4 * SECOND]


class Stage(msgspec.Struct, frozen=True):
    name: str
    number: int
