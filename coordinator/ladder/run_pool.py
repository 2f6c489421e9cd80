"""Parallel runs of plans on all cores, without a recording; each returns its figures."""

from collections.abc import Iterable, Iterator
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Protocol, TypeAlias

from heavylift.coordinator.record.in_memory import play
from heavylift.coordinator.supervision.pool import Pool
from heavylift.kernel.errors import HeavyliftError, ProtocolError
from heavylift.kernel.trust import demand
from heavylift.nodes.plan.fidelity import ASKABLE, USUAL
from heavylift.nodes.plan.plan import Plan, decode, encode, functions

from .figures import AskedFigure, figures
from .looking import as_it_is
from .measuring import Errors, Measuring

LONGEST = 3600.0  # [s] of wall time that a run may take


@dataclass(frozen=True)
class RunFigures:
    """Figures of a run with their relative errors, if measured, and the CPU time [s] spent."""

    figures: list[AskedFigure]
    cpu_s: float
    steps: Errors = field(default_factory=dict)
    model: Errors = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)


Ran: TypeAlias = RunFigures | str
"""A run, or the sentence that says why there is none."""


class Start(Protocol):
    """Interface of a function that starts a run of a plan and, if `measured`, also runs that measure its errors."""

    def __call__(self, plan: Plan, measured: bool = False) -> Future[Ran]: ...


@contextmanager
def starting(at_once: int) -> Iterator[Start]:
    """Yield a function that starts runs in a pool of `at_once` processes, or in this process if `at_once` is 0."""
    if at_once < 1:
        yield _here
        return
    with Pool(at_once) as pool:
        yield lambda plan, measured=False: pool.submit(_ran, (encode(plan), measured))


def result(future: Future[Ran]) -> Ran:
    """Wait for a run and return its result; raises ProtocolError if its process died."""
    try:
        return future.result()
    except BrokenProcessPool:
        raise ProtocolError(
            "a process that ran a variant was killed or ran out of memory; use fewer processes"
        ) from None


def _here(plan: Plan, measured: bool = False) -> Future[Ran]:
    future = Future[Ran]()
    future.set_result(_ran((encode(plan), measured)))
    return future


def _ran(task: tuple[bytes, bool]) -> Ran:
    try:
        plan = decode(task[0])
        demand(functions(plan), "the scene")
        if not task[1]:
            run = play(plan, LONGEST)
            return RunFigures(_at_the_end(figures(run)), run.cpu_s)
        measuring = Measuring(ASKABLE, lambda: LONGEST)
        look = as_it_is(plan, USUAL, measuring)
        spent = sum(x.cpu_s for x in measuring.spent.values())
        found = _at_the_end(measuring.figures(look.candidate).values())
        return RunFigures(found, spent, look.steps, look.model, look.missing)
    except HeavyliftError as error:
        return " ".join(str(error).split())


def _at_the_end(found: Iterable[AskedFigure]) -> list[AskedFigure]:
    """Return the figures that count, with positions only at the end of the run."""
    return [f for f in found if f.asked and (f.quantity != "position" or f.name.endswith("at the end"))]
