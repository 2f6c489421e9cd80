"""Where the wall time of a run went, in seconds that are shown and never used.

`kernel`: its node at work under grants; `recording`: the coordinator at work on the file; `rounds`: the rest of the
time between the first grant and the last answer, that is models, messages and waiting.  Nodes in processes of their
own work while the coordinator records, so the parts can add up to a little more than the whole.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import wraps
from itertools import pairwise
from typing import Concatenate, ParamSpec, TypeVar

from heavylift.coordinator.stopping import whole

Mark = tuple[float, float]  # an instant, and the seconds of recording until then


@dataclass(frozen=True)
class Budget:
    """Seconds of wall time of each part of a run."""

    start: float = 0.0
    kernel: float = 0.0
    rounds: float = 0.0
    recording: float = 0.0
    exit: float = 0.0

    @staticmethod
    def of(start: Mark, greeted: Mark, played: Mark, ended: Mark, kernel: float) -> Budget:
        """From when it began, all nodes had said HELLO, nothing was left to do, all were gone; and the kernel's own."""
        marks = [start, greeted, played, ended]
        starting, playing, ending = ((b[0] - a[0]) - (b[1] - a[1]) for a, b in pairwise(marks))  # without the recording
        return Budget(starting, kernel, max(0.0, playing - kernel), ended[1], ending)

    def __str__(self) -> str:
        return ", ".join(f"{f.name} {getattr(self, f.name):.2f}" for f in fields(self))


class ClockedWork:
    """Something whose work is clocked: `spent_s` of wall time so far."""

    spent_s = 0.0

    def mark(self) -> Mark:
        """Now, and the seconds spent until now."""
        return time.perf_counter(), self.spent_s


T = TypeVar("T", bound=ClockedWork)
P = ParamSpec("P")
R = TypeVar("R")


def clocked(method: Callable[Concatenate[T, P], R]) -> Callable[Concatenate[T, P], R]:
    """Add the seconds that the method takes to those spent; no signal leaves it half done."""

    @wraps(method)
    def timed(self: T, /, *args: P.args, **kwargs: P.kwargs) -> R:
        began = time.perf_counter()
        try:
            with whole():
                return method(self, *args, **kwargs)
        finally:
            self.spent_s += time.perf_counter() - began

    return timed
