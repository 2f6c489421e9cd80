"""Runs of plans side by side on the cores, without a recording: the figures of each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeAlias

from heavylift.coordinator.supervision.pool import Pool
from heavylift.kernel.errors import HeavyliftError, ProtocolError
from heavylift.kernel.trust import demand
from heavylift.nodes.plan.plan import Plan, decode, encode, functions

from .figures import AskedFigure, figures
from .in_memory import play

LONGEST = 3600.0  # [s] of wall time that a run may take

Ran: TypeAlias = tuple[list[AskedFigure], float] | str
"""Figures of a run and its CPU time [s], or the sentence that says why there is none."""

Start: TypeAlias = Callable[[Plan], "Future[Ran]"]
"""Starts a run of a plan."""


@contextmanager
def starting(at_once: int) -> Iterator[Start]:
    """Starts runs, so many at once in processes of their own, which end with the context; 0: here, one by one."""
    if at_once < 1:
        yield _here
        return
    with Pool(at_once) as pool:
        yield lambda plan: pool.submit(_ran, encode(plan))


def result(future: Future[Ran]) -> Ran:
    """What has become of a run."""
    try:
        return future.result()
    except BrokenProcessPool:
        raise ProtocolError("a process that ran a variant was ended by somebody else, or had no memory") from None


def _here(plan: Plan) -> Future[Ran]:
    future = Future[Ran]()
    future.set_result(_ran(encode(plan)))
    return future


def _ran(plan: bytes) -> Ran:
    try:
        found = decode(plan)
        demand(functions(found), "the scene")
        run = play(found, LONGEST)
        return [f for f in figures(run) if f.quantity != "position" or f.name.endswith("at the end")], run.cpu_s
    except HeavyliftError as error:
        return " ".join(str(error).split())
