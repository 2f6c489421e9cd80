"""One who looks at a run from another process: all events so far, then each as it happens, until the run ends.

An observer only reads the run's journal of events, in its own time: the coordinator does not know of it, so none can
slow a run, however many there are and however slow or frozen they are, and none misses or repeats anything.  (Programs
that want to be called hear the same events on the bus, where a slow one misses some.)
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from heavylift.coordinator.supervision.journal import JournalReader
from heavylift.nodes.devs import Event

from .announce import AnnouncedRun, find
from .observers import EVENTS, Ended, entry

LOOK_s = 0.02  # how often an observer looks for more


class Observer(Iterator[tuple[int, Event]]):
    """Iterates over (number, event); afterwards `ended` says how the run ended."""

    def __init__(self, found: AnnouncedRun) -> None:
        self.found = found
        self.ended = Ended("failed", 0.0, "its coordinator was killed")
        self._journal = JournalReader(found.directory / EVENTS)
        self._events = self._follow()

    def __next__(self) -> tuple[int, Event]:
        return next(self._events)

    def _follow(self) -> Iterator[tuple[int, Event]]:
        number, alive = 0, True
        with closing(self._journal) as journal:
            while alive:
                alive = self.found.lives
                for said in map(entry, journal):
                    if isinstance(said, Ended):
                        self.ended = said
                        return
                    self.ended = Ended("failed", said.t * 1e-9, self.ended.reason)
                    yield number, said
                    number += 1
                time.sleep(LOOK_s)


def observe(run: str | Path | AnnouncedRun = "") -> Observer:
    """All events of a run in progress, as (number, event) from 0 upwards; `run` as for `find`."""
    return Observer(run if isinstance(run, AnnouncedRun) else find(str(run)))
