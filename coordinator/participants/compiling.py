"""Machine code for a plan, compiled before its run and beside other work: in a thread, or in a process of its own.

LLVM compiles in one thread of a process at a time; a process of its own leaves its code in the cache.
"""

import base64
import sys
from collections.abc import Callable
from contextlib import suppress
from threading import Thread
from typing import TYPE_CHECKING, TypeAlias

from heavylift.kernel.cache import unsafe_cache
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.plan.plan import Plan, decode, encode, functions

if TYPE_CHECKING:
    from heavylift.coordinator.supervision.processes import Processes

Ahead: TypeAlias = Callable[[Plan], Callable[[], None]]
"""A function that begins to compile the machine code for a plan, and returns a function that waits for it."""


def in_thread(plan: Plan) -> Callable[[], None]:
    """Compile in a thread of this process."""
    thread = Thread(target=compiled, args=(plan,))
    thread.start()
    return thread.join


def in_process(crew: "Processes | None") -> Ahead:
    """Return a function that compiles in a fork of the process manager; in a thread where that would be of no use."""

    def begin(plan: Plan) -> Callable[[], None]:
        if crew is None or functions(plan) or unsafe_cache():
            return in_thread(plan)
        return crew.aside(__name__, base64.b64encode(encode(plan)).decode())

    return begin


def compiled(plan: Plan) -> None:
    """Compile the machine code for a plan, so that its run starts at once; errors are left to the run to report."""
    from .kernel_node import KernelNode
    from .rows import RowSink
    from .session import Session

    with suppress(HeavyliftError):
        Session(plan, lambda config: KernelNode(config, RowSink()))


def main(arguments: list[str]) -> None:
    """Compile for the plan on standard input."""
    compiled(decode(base64.b64decode(sys.stdin.buffer.read())))
