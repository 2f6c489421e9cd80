"""Islands advance in threads: their machine code runs without the interpreter's lock.

No island knows of the others, so neither the number of threads nor their timing changes a bit of what they compute.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait

PAUSE_s = 0.025  # as often as one island calls `pause`

Task = Callable[[Callable[[], None]], None]  # is given its own `pause`


class GivenUp(BaseException):
    """Raised in threads whose results nobody waits for any more."""


class SideBySide:
    """Threads, one a processor, that are started when there is work for two."""

    def __init__(self, threads: int = 0) -> None:
        self._threads = threads or len(os.sched_getaffinity(0))
        self._pool: ThreadPoolExecutor | None = None

    def carry_out(self, tasks: Sequence[Task], pause: Callable[[], None]) -> None:
        """Return when all are done; the first exception in the order of tasks is raised, `pause` called here alone."""
        if len(tasks) < 2 or self._threads < 2:
            for task in tasks:
                task(pause)
            return
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self._threads, "island")
        over = False

        def proceed() -> None:
            if over:
                raise GivenUp

        futures = [self._pool.submit(task, proceed) for task in tasks]
        try:
            while wait(futures, PAUSE_s).not_done:
                pause()
        finally:
            over = True
            wait(futures)
        for future in futures:
            future.result()
