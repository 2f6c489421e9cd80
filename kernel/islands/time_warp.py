"""Islands run ahead by turns for a span of time; those that went past the first event go back and stop at it.

Jefferson, Virtual time, ACM TOPLAS 7, 1985.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from heavylift.kernel.errors import KernelError
from heavylift.kernel.simulation.native.native_state import FOREVER_NS
from heavylift.kernel.simulation.snapshots import Snapshot, back, mark

from .island import Island

__all__ = ["run_ahead"]


def run_ahead(parts: Sequence[Island], horizon: int, pause: Callable[[], None]) -> int:
    """All islands up to the horizon [ns], or to the first event by then; when that is, FOREVER_NS if there is none."""
    first, failed = FOREVER_NS, list[KernelError]()
    moving = [p for p in parts if not p.still]
    before: list[tuple[Island, Snapshot, int]] = []
    for p in moving:
        end = min(horizon, first)
        if p is moving[-1]:
            p.run(end, pause)
        else:
            marked = mark(p)
            try:
                p.run(end, pause)
            except KernelError as error:  # it counts if nothing happens elsewhere before
                failed.append(error)
                end = FOREVER_NS
            before.append((p, marked, end))
        if p.event and p.next_ns <= end:
            first = p.next_ns
    if failed and first == FOREVER_NS:
        raise failed[0]
    for p, marked, end in before:
        if end > first:
            back(p, marked)
            p.run(first, pause)
    return first
