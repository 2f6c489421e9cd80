"""When a run may go on: its pace, and the pauses and steps of an operator.

While it is paused, nothing at or after `limit` is decided; a limit is never below what was decided before, so that
"paused at t" means: all before t is done, and nothing at t.  A step moves the limit.
"""

from __future__ import annotations

import math
from threading import Event as Alarm

from heavylift.coordinator.protocol.outside import OpenCoordinator
from heavylift.nodes.devs import FOREVER, NEVER, Tag, after

from .pace import Pace

TICK_s = 0.05  # longest rest, so that lost nodes are noticed
GRAIN_ns = 2  # of steps to the next event: a step of the mechanics is announced one nanosecond before its end


class Tempo:
    """Asked by the conversation before each round, and how long to rest when there is nothing to do yet."""

    def __init__(self, pace: Pace | None = None) -> None:
        self.pace = pace or Pace()
        self.alarm = Alarm()
        """Ends a rest; set by whoever has something to say."""
        self.limit: Tag | None = None
        self.held = False
        """Whether all below the limit is done."""
        self._to_event = False
        self._horizon = self._first = Tag(0)

    def horizon(self, core: OpenCoordinator) -> Tag:
        """Nothing at or after it may be decided now."""
        self.held = False
        if self._free:
            return FOREVER
        self.alarm.clear()
        self._first = first = core.first
        if self.limit is not None and self.limit <= first and not core.running:
            if not self._to_event or first == FOREVER:
                self.pace.hold()
                self.held = True
                return self.limit
            self.limit = Tag(first.t + GRAIN_ns)  # one instant more
        self._horizon = max(self._horizon, self.pace.horizon(first))
        return self._horizon if self.limit is None else min(self.limit, self._horizon)

    def granted(self) -> None:
        """Something is granted within the horizon."""
        self.pace.granted(self._first)

    def rest(self, core: OpenCoordinator) -> float:
        """Let time pass until something can be granted, if no node works; how long to wait for a node [s]."""
        if self._free:
            return math.inf
        first = core.first
        held = self.limit is not None and self.limit <= first and not self._to_event
        wait = math.inf if held else self.pace.wait(first)
        if core.running:
            return wait or math.inf  # what is due now waits for a node that works
        if wait > 0.0:
            self.pace.rest(self.alarm, min(wait, TICK_s))
        return 0.0

    @property
    def _free(self) -> bool:
        return self.limit is None and self.pace.ahead == NEVER

    def event(self) -> None:
        """A committed event has left."""
        self._to_event = False

    def pause(self, core: OpenCoordinator) -> Tag:
        """Stop as soon as may be; returns where."""
        self.limit, self._to_event = Tag(core.safe_ns), False
        return self.limit

    def step(self, core: OpenCoordinator, by_ns: int | None) -> None:
        """Go on for so long and pause again; None: until an event has left."""
        here = self.limit if self.limit is not None else Tag(core.safe_ns)
        self._to_event = by_ns is None
        self.limit = here if by_ns is None else after(here, by_ns)
        self.held = False
        self.pace.go_on(here)

    def go_on(self) -> None:
        """Without any limit."""
        if self.limit is not None:
            self.pace.go_on(self.limit)
        self.limit, self._to_event = None, False
