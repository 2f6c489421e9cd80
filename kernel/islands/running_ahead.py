"""Optimistic simulation of islands: each runs ahead, and an island that receives an earlier command rolls back (Time
Warp).

The global time is the time up to which no island has an event that was not processed (Jefferson, Virtual time, ACM
TOPLAS 7, 1985); samples, log and notes of the islands are published once no possible command can change them.

Islands advance in threads: their machine code runs without the interpreter's lock. No island depends on the others, so
neither the number of threads nor their timing changes a bit of the results.
"""

import os
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from functools import partial
from math import inf

import numpy as np
from heavylift.kernel.description.findings import Note
from heavylift.kernel.model.switching import StateChange
from heavylift.kernel.simulation.commands import CommandTarget
from heavylift.kernel.simulation.native.native_state import FOREVER_NS

from .island import Island
from .sample_merge import Joining, logged, noted

WORTH = 5000.0  # steps times degrees of freedom, about 0.7 ms: less is done before another thread wakes
PAUSE_s = 0.025  # as often as one island calls `pause`

Task = Callable[[Callable[[], None]], None]  # is given its own `pause`


class GivenUp(BaseException):
    """Raised in a worker thread to stop it when its result is no longer needed."""


class SideBySide:
    """Tasks in parallel: in the calling thread and in a pool of others, one thread per processor.

    `worth`: work from which on threads pay, in steps times degrees of freedom.
    """

    def __init__(self, threads: int = 0, worth: float = WORTH) -> None:
        self._threads, self._worth = threads or len(os.sched_getaffinity(0)), worth
        self._pool: ThreadPoolExecutor | None = None

    def carry_out(self, tasks: Sequence[Task], pause: Callable[[], None], work: float = inf) -> None:
        """Run all tasks in parallel; raise the first failed task's exception.

        The calling thread calls `pause` at short intervals until all tasks have ended. `work`: expected of
        all tasks together, in the unit of `worth`."""
        threads = min(self._threads, len(tasks)) if work >= self._worth else 1
        if threads < 2:
            for task in tasks:
                task(pause)
            return
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self._threads - 1, "island")
        waiting, failed = iter(enumerate(tasks)), dict[int, Exception]()
        over: BaseException | None = None

        def asked() -> None:
            nonlocal over
            try:
                pause()
            except BaseException as error:
                over = error
                raise

        def proceed() -> None:
            if over:
                raise GivenUp

        def carry(pause: Callable[[], None]) -> None:
            for i, task in waiting:
                try:
                    task(pause)
                except Exception as error:
                    failed[i] = error
                proceed()

        futures = [self._pool.submit(carry, proceed) for _ in range(threads - 1)]
        try:
            carry(asked)
            while wait(futures, PAUSE_s).not_done:
                asked()
        except BaseException as error:
            over = over or error
        wait(futures)
        if over or failed:
            raise over or failed[min(failed)]
        for future in futures:
            future.result()


SPAN = 32  # periods of samples that islands run ahead of each other at most


class RunningAhead(CommandTarget):
    """Base class of the simulation of several islands that run ahead of each other.

    `parts`: islands; `reached`: global time [ns]; `epoch`: last event or command; `_stopped`: islands stopped there;
    `samples`, `rows`, `log`, `notes`: of the whole scene.
    """

    samples: Joining

    def __init__(self, subscribed: frozenset[str], sample_ns: int) -> None:
        self.subscribed, self._sample_ns = subscribed, sample_ns
        self.parts: list[Island] = []
        self.rows: list[tuple[int, np.ndarray]] = []
        self.log: list[tuple[int, StateChange]] = []
        self.notes: list[Note] = []
        self.epoch = self.reached = 0
        self._stopped: list[Island] = []
        self._pause: Callable[[], None] = lambda: None
        self._due = 0  # when to look for samples again [ns]
        self._side_by_side = SideBySide()
        self._soonest: tuple[int, list[Island]] | None = None  # when something happens next, and events of whom

    @property
    def _next(self) -> tuple[int, list[Island]]:
        """The time of the first located event or end of a tentative step, and the islands with an event at it."""
        if self._soonest is None:
            rests = [p.began for p in self.parts if p.still and p.began > self.reached]  # they are on their way to it
            now = min([p.due for p in self.parts] + rests)
            self._soonest = now, [p for p in self.parts if p.firing and p.due == now]
        return self._soonest

    @property
    def next_ns(self) -> int:
        """Time [ns] of the first located event or step end among the islands; FOREVER_NS if nothing moves."""
        return self._next[0]

    @property
    def event(self) -> bool:
        """Whether the next stop, at `next_ns`, is an event of a law whose events are subscribed."""
        return any(p.tells(self.subscribed) for p in self._firing)

    @property
    def _firing(self) -> list[Island]:
        return self._next[1]

    def _run_to(self, until_ns: int, pause: Callable[[], None]) -> int:
        """Advance all islands to a time or the first event; returns its time [ns]."""
        while True:
            end = min([until_ns, *(p.due for p in self.parts if p.firing)])
            if end == self.epoch and self._firing:  # at once: who stands there, too, waits for it
                return end
            behind = [p for p in self.parts if p.due <= end and not p.firing]
            if not behind:
                return end
            refused = all(p.refused for p in behind)
            soon = end + self._sample_ns  # who would be behind then goes on with them, as one call costs less than two
            able = behind if refused else [p for p in self.parts if p.due <= soon and not p.firing and not p.refused]
            most = SPAN * self._sample_ns
            work = sum(p.work(end, most) for p in able)
            self._side_by_side.carry_out([partial(p.extend, end, most) for p in able], pause, work)
            self._soonest = None

    def _reach(self, t_ns: int, whole: bool = False) -> None:
        """Advance the global time up to which all islands agree. If `whole`, publish all rows up to this time."""
        if self._next[0] <= t_ns and not self._firing:
            self._soonest = None
        self.reached = t_ns
        self.log += logged(self._stopped)
        rested = any(p.recorder.rested for p in self._stopped)
        if whole or rested or t_ns >= self._due or self.samples.struck or self.next_ns >= FOREVER_NS:
            for p in self.parts:
                if p.marks:
                    p.forget(t_ns)
            self._collect()
            self._due = t_ns + self._sample_ns

    def _collect(self) -> None:
        """Merge samples and notes of the islands into those of the scene, in order of time."""
        self.notes += noted(self.parts, min([self.reached, *(p.began for p in self.parts if not p.still)]))
        end = min(self.reached, *(self.epoch if p in self._stopped else p.history for p in self.parts)) + 1
        more = self.samples.next_ns < end or any(p.recorder.rested for p in self._stopped)
        while more:
            more = any([p.recorder.unroll(self.samples.next_ns) for p in self.parts])
            self.rows += self.samples.take([p.rows for p in self.parts], [p.resting for p in self.parts], end)
            if more:
                self._pause()
        self.rows += self.samples.ready()

    def _stand(self, parts: Collection[Island]) -> None:
        """Commit the state of islands that were rolled back or stopped."""
        for p in parts:
            p.stand()
        self._soonest = None
