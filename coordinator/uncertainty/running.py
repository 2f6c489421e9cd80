"""Runs of a scene with other inputs, other steps or another rung, side by side on the cores, without a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeAlias

from heavylift.coordinator.run.pool import Pool
from heavylift.coordinator.tradeoff.playing import play
from heavylift.kernel.errors import HeavyliftError, ProtocolError
from heavylift.kernel.trust import demand
from heavylift.nodes.plan.plan import Plan, decode, encode, functions

from .figures import Figure, figures

LONGEST = 3600.0  # [s] of wall time that a run may take

Played: TypeAlias = tuple[list[Figure], float] | str
"""Figures of a run and its CPU time [s], or the sentence that says why there is none."""

Start: TypeAlias = Callable[[Plan, str], "Future[Played]"]
"""Starts a run of a plan; the text is the unit of places."""


@contextmanager
def starting(at_once: int) -> Iterator[Start]:
    """Starts runs, so many at once in processes of their own, which end with the context; 0: here, one by one."""
    if at_once < 1:
        yield _here
        return
    with Pool(at_once) as pool:
        yield lambda plan, unit: pool.submit(_played, encode(plan), unit)


def result(future: Future[Played]) -> Played:
    """What has become of a run."""
    try:
        return future.result()
    except BrokenProcessPool:
        raise ProtocolError("a process that ran a variant was ended by somebody else, or had no memory") from None


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
