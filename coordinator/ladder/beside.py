"""Processes beside the one that chooses a model level: they compile the code for a level, or run a candidate.

LLVM compiles in one thread of a process at a time; a process of its own leaves its code in the cache. A run beside
gives the same figures as one in this process, which repeats a run that did not come to its end.
"""

import base64
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from threading import Thread
from typing import NamedTuple, TypeAlias

import msgspec
from heavylift.coordinator.record.in_memory import Played, play
from heavylift.kernel.cache import unsafe_cache
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.plan.fidelity import Asked
from heavylift.nodes.plan.plan import Plan, decode, encode, functions

from .figures import AskedFigure, figures, judged

Aside: TypeAlias = Callable[[str, str], Callable[[], str]]
"""A function that starts `main` of a module with a text on standard input, and returns a function that waits for its
output."""


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


_Figures: TypeAlias = list[AskedFigure]
_Sent = tuple[Spent, frozenset[str], int, _Figures, _Figures, _Figures]


def possible(plan: Plan) -> bool:
    """Return whether another process may run a plan: the scene brings no code, and machine code can be cached."""
    return not functions(plan) and not unsafe_cache()


def compiling(aside: Aside, plan: Plan) -> Callable[[], object]:
    """Begin to compile the machine code for a plan; return a function that waits for it."""
    return aside(__name__, _text((encode(plan), None)))


def running(
    aside: Aside, plan: Plan, ask: Sequence[Asked], compiled: Callable[[], object]
) -> Callable[[], Seen | None]:
    """Begin to run a plan once its code is `compiled`; return a function that waits for what is kept of it, or None if
    the run has failed."""
    output = list[str]()

    def follow() -> None:
        compiled()
        output.append(aside(__name__, _text((encode(plan), [*ask])))())

    thread = Thread(target=follow, daemon=True)
    thread.start()

    def seen() -> Seen | None:
        thread.join()
        with suppress(ValueError, IndexError, msgspec.MsgspecError):
            last = base64.b64decode(output[0].splitlines()[-1], validate=True)
            spent, slack, samples, found, limits, values = msgspec.msgpack.decode(last, type=_Sent)
            return Seen(spent, slack, samples, found, lambda only: values if only else limits)
        return None

    return seen


def compiled(plan: Plan) -> None:
    """Compile the machine code for a plan, so that its run starts at once; errors are left to the run to report."""
    # with the compiler, which nobody needs who only reads what is remembered
    from heavylift.coordinator.participants.kernel_node import KernelNode
    from heavylift.coordinator.participants.rows import RowSink
    from heavylift.coordinator.participants.session import Session

    with suppress(HeavyliftError):
        Session(plan, lambda config: KernelNode(config, RowSink()))


def main(arguments: list[str]) -> None:
    """Compile or run the plan on standard input."""
    data, ask = msgspec.msgpack.decode(base64.b64decode(sys.stdin.read()), type=tuple[bytes, list[Asked] | None])
    plan = decode(data)
    if ask is None:
        return compiled(plan)
    with suppress(HeavyliftError):
        x = Seen.of(play(plan), ask)
        sys.stdout.write(_text((*x[:-1], x.limits(False), x.limits(True))))


def _text(value: object) -> str:
    return base64.b64encode(msgspec.msgpack.encode(value, enc_hook=float)).decode()
