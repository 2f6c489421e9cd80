"""Runs of a scene with other inputs, other steps or another rung, side by side on the cores, without a recording."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import active_children, get_context
from types import ModuleType
from typing import TypeAlias

from heavylift.coordinator.tradeoff.playing import play
from heavylift.kernel.errors import HeavyliftError, ProtocolError
from heavylift.kernel.trust import demand
from heavylift.nodes.plan.plan import Plan, decode, encode, functions

from .figures import Figure, figures

__all__ = ["Played", "Start", "cores", "result", "starting"]

LONGEST = 3600.0  # [s] of wall time that a run may take

Played: TypeAlias = tuple[list[Figure], float] | str
"""Figures of a run and its CPU time [s], or the sentence that says why there is none."""

Start: TypeAlias = Callable[[Plan, str], "Future[Played]"]
"""Starts a run of a plan; the text is the unit of places."""


def cores() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def starting(at_once: int) -> Iterator[Start]:
    """Starts runs, so many at once in processes of their own, which end with the context; 0: here, one by one."""
    if at_once < 1:
        yield _here
        return
    others = set(active_children())
    pool = ProcessPoolExecutor(at_once, get_context("spawn"))

    def start(plan: Plan, unit: str) -> Future[Played]:
        with _apart():
            return pool.submit(_played, encode(plan), unit)

    try:
        yield start
    except BaseException:
        for process in set(active_children()) - others:
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def result(future: Future[Played]) -> Played:
    """What has become of a run."""
    try:
        return future.result()
    except BrokenProcessPool:
        raise ProtocolError("a process that ran a variant was ended by somebody else, or had no memory") from None


@contextmanager
def _apart() -> Iterator[None]:
    """A process begun in here leaves Ctrl-C to this one, and does not import the script that runs, which may have no
    guard of its main part."""
    main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        sys.modules["__main__"] = main


def _here(plan: Plan, unit: str) -> Future[Played]:
    future = Future[Played]()
    future.set_result(_played(encode(plan), unit))
    return future


def _played(plan: bytes, unit: str) -> Played:
    try:
        found = decode(plan)
        demand(functions(found), "the scene")
        run = play(found, LONGEST)
    except HeavyliftError as error:
        return " ".join(str(error).split())
    return figures(run.shown, unit), run.cpu_s
