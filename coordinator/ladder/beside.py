"""Processes beside the one that chooses a model level: they compile the code for a level, or run a candidate.

LLVM compiles in one thread of a process at a time; a process of its own leaves its code in the cache. A run in
another process gives the same figures as one here. If it fails there, it is repeated here, which reports its error.
"""

import base64
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import NamedTuple, TypeAlias

import msgspec
from heavylift.coordinator.record.in_memory import Played, play
from heavylift.kernel.cache import cache_bound, unsafe_cache
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.plan.fidelity import Asked, Fidelity
from heavylift.nodes.plan.plan import Plan, decode, encode, functions

from .figures import AskedFigure, figures, judged

Wait: TypeAlias = Callable[[], str]  # for the end of a process, with its output


class Spent(NamedTuple):
    """Time that a run has taken [s]: CPU time before the run and during it, and wall time from its beginning to its
    end."""

    start_s: float
    cpu_s: float
    wall_s: float


class Seen(NamedTuple):
    """What is kept of a run: time spent, ropes that went slack, number of samples, figures; `limits(values)`: those of
    its verdict."""

    spent: Spent
    slack: frozenset[str]
    samples: int
    figures: list[AskedFigure]
    limits: Callable[[bool], list[AskedFigure]]

    @classmethod
    def of(cls, run: Played, ask: Sequence[Asked]) -> "Seen":
        """Return what is kept of a finished run."""
        spent = Spent(run.start_s, run.cpu_s, run.prepared_s + run.wall_s)
        judge = run.judge if run.plan.limits else None
        limits = lambda values: judged(judge, values=values) if judge else []  # noqa: E731
        return cls(spent, run.slack, len(run.t), figures(run, ask), limits)


class Beside:
    """Work in other processes: `start` runs `main` of a module there, with a text on standard input; None starts
    nothing."""

    def __init__(self, start: Callable[[str, str], Wait] | None = None) -> None:
        self._start = start
        self._compiling: dict[tuple[Fidelity, str], Wait] = {}  # by model level and method
        self._running: dict[bytes, Wait] = {}  # by plan

    def compile(self, plan: Plan) -> None:
        """Begin to compile the code for the model level of a plan."""
        if self._start and (plan.fidelity, plan.method) not in self._compiling and _possible(plan):
            self._compiling[plan.fidelity, plan.method] = self._start(__name__, _text((encode(plan), None)))

    def compiled(self, plan: Plan) -> None:
        """Wait for the code for the model level of a plan if it is being compiled."""
        self._compiling.get((plan.fidelity, plan.method), str)()

    def run(self, plan: Plan, ask: Sequence[Asked]) -> bool:
        """Begin to run a plan as soon as its code is compiled; return whether it runs there."""
        key = encode(plan) if self._start else b""
        if self._start and key not in self._running and _possible(plan):
            self.compiled(plan)
            self._running[key] = self._start(__name__, _text((key, [*ask])))
        return key in self._running

    def seen(self, plan: Plan) -> Seen | None:
        """Return what is kept of the run of a plan; None if there was none, or if it has failed."""
        if not self._running:
            return None
        with suppress(ValueError, IndexError, msgspec.MsgspecError):
            last = self._running.pop(encode(plan), str)().splitlines()[-1]
            spent, slack, samples, found, limits, values = msgspec.convert(_data(last), _Sent)
            return Seen(spent, slack, samples, found, lambda only: values if only else limits)
        return None


ALONE = Beside()
_Figures: TypeAlias = list[AskedFigure]
_Sent = tuple[Spent, frozenset[str], int, _Figures, _Figures, _Figures]


def _possible(plan: Plan) -> bool:
    """Return whether another process can do it: the scene brings no code, and machine code is kept in the cache."""
    return not functions(plan) and not unsafe_cache() and cache_bound() > 0


def main(arguments: list[str]) -> None:
    """Compile or run the plan on standard input."""
    from heavylift.coordinator.participants.kernel_node import KernelNode
    from heavylift.coordinator.participants.rows import RowSink
    from heavylift.coordinator.participants.session import Session

    data, ask = msgspec.convert(_data(sys.stdin.read()), tuple[bytes, list[Asked] | None])
    with suppress(HeavyliftError):  # which the run in the other process will report
        if ask is None:
            Session(decode(data), lambda config: KernelNode(config, RowSink()))
        else:
            seen = Seen.of(play(decode(data)), ask)
            sys.stdout.write(_text((*seen[:-1], seen.limits(False), seen.limits(True))))


def _text(value: object) -> str:
    return base64.b64encode(msgspec.msgpack.encode(value, enc_hook=float)).decode()


def _data(text: str) -> object:
    return msgspec.msgpack.decode(base64.b64decode(text, validate=True))
