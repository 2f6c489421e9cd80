"""What a user must know of a run that goes on: motions that steps miss, energy that went with them, ropes that rattle.

A note belongs to the instant that it tells of, as a sample does, and comes out the same however a run is cut up.
"""

from __future__ import annotations

from typing import NamedTuple


class Note(NamedTuple):
    """A sentence and the simulation time that it tells of [ns]."""

    t_ns: int
    sentence: str
