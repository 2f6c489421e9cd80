"""Pools of processes that run calls in parallel.

They start with a fresh interpreter, so that no thread of this process is copied; they ignore Ctrl-C, which this process
handles, end with this process, and after an error do not finish their calls.
"""

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing import get_context
from types import ModuleType, TracebackType
from typing import Any

POLL_s = 1.0  # between two looks whether the parent still lives


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def submits(executor: object) -> bool:
    """Return whether an object has the method `submit` of executors, like those of concurrent.futures."""
    return callable(getattr(executor, "submit", None))


def finished(futures: Collection[Future[Any]], patience: float) -> Collection[Future[Any]]:
    """Wait up to `patience` [s] for at least one future, and return those completed."""
    if all(isinstance(future, Future) for future in futures):
        return wait(futures, timeout=patience, return_when=FIRST_COMPLETED).done
    if not (done := [future for future in futures if future.done()]):
        time.sleep(patience)
    return done


class Pool(ProcessPoolExecutor):
    """A pool of worker processes, as a context manager."""

    def __init__(self, processes: int) -> None:
        super().__init__(processes, get_context("spawn"), initializer=_begin, initargs=(os.getpid(),))

    def submit(self, call: Callable[..., Any], /, *args: Any, **named: Any) -> Future[Any]:
        """Submit a call, which may start a worker process."""
        with _apart():
            return super().submit(call, *args, **named)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            for process in list((self._processes or {}).values()):
                process.terminate()
        self.shutdown(wait=kind is None, cancel_futures=True)


@contextmanager
def _apart() -> Iterator[None]:
    """Start processes without Ctrl-C and without the running script, which may lack a `__main__` guard."""
    main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        sys.modules["__main__"] = main


def _begin(parent: int) -> None:
    gc.set_threshold(10_000)  # hardly anything is garbage that is not seen at once; more would be memory
    signal.signal(signal.SIGTERM, signal.SIG_DFL)

    def follow() -> None:
        while os.getppid() == parent:
            time.sleep(POLL_s)
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
