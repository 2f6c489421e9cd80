"""Time saved by solving islands separately.

    python tests/bench/islands.py [--json] [--short]

Work is attempted steps times operations of one evaluation, which does not depend on the machine; the peer is the same
kernel in one piece.  Seconds are those of this machine with machine code from the cache, least of three: the steps
alone for `two lifts`, the whole run in one process for the other.  Last, the lifts of a yard, as in `yard.py`, advance
in threads, on two processors and on one, in turns; this is wall time, so other work on the machine counts.
"""

from __future__ import annotations

import gc
import sys
import time
from collections.abc import Callable
from pathlib import Path

from heavylift.coordinator.participants import RowFrames, Session, kernel_node
from heavylift.kernel.islands import Islands, SideBySide
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.devs import Tag, seconds
from heavylift.nodes.scene import LoadedScene, parse

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "kernel/islands"))
sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))
from shared.recorded_commands import Noting, noted_in, played_again
from shared.rows import SHORT, options, row
from test_two_cranes_of_which_one_idles import scene as two_cranes
from two_loads import TWO, UP, played
from yard import text

SECOND, HOUR = 1_000_000_000, 100 * 3600
RUNS, MANY = (1, 4) if SHORT else (5, 16)

Made = Callable[[], tuple[float, float]]  # seconds, operations


def scene_run(scene: LoadedScene, apart: bool) -> Made:
    """A whole run of a scene in one process."""

    def simulate(system, tolerance, sample_ns, subscribed, method, step, ties=(), *_):
        if apart:
            return Islands(system, tolerance, sample_ns, subscribed, ties=ties, method=method, step=step)
        return Simulation(system, tolerance, sample_ns, subscribed, method=method, step=step)

    def made() -> tuple[float, float]:
        kernel_node.simulate = simulate
        plan, rows = scene.plan, list[bytes]()
        end = Tag(seconds(plan.end or HOUR))
        session = Session(plan, lambda config: kernel_node.KernelNode(config, RowFrames(rows.append)), end=end)
        began = time.perf_counter()
        session.advance()
        return time.perf_counter() - began, work(session.kernel.simulation)

    return made


def work(s: Simulation | Islands) -> float:
    """Operations of all attempted steps."""
    parts = s.parts if isinstance(s, Islands) else [s]
    return sum((p["accepted"] + p["rejected"]) * p.native.method.f_rate.operations for p in parts)


def two_lifts(apart: bool) -> Made:
    """Two lifts in one scene, each with a load of 10 t."""

    def made() -> tuple[float, float]:
        s = (Islands if apart else Simulation)(TWO, 1e-7, SECOND // 10)
        s.start()
        began = time.perf_counter()
        played(s, UP, start=False)
        return time.perf_counter() - began, work(s)

    return made


def in_threads(noted: Noting, threads: int) -> float:
    """Wall seconds of the kernel alone, with the grants and commands of a run."""
    kernel = kernel_node.KernelNode(noted.config, RowFrames(list[bytes]().append))
    kernel.simulation._side_by_side = SideBySide(threads)
    began = time.perf_counter()
    played_again(noted, kernel)
    return time.perf_counter() - began


def least(made: Made) -> tuple[float, float]:
    return min(made() for _ in range(RUNS))


def main() -> None:
    options(__doc__ or "")
    gc.set_threshold(50_000)  # as in the command itself
    cranes = two_cranes(end=5.0 if SHORT else 45.0)
    cases: list[tuple[str, Made, Made]] = [
        ("lift and an idle crane", scene_run(cranes, True), scene_run(cranes, False)),
        ("two lifts", two_lifts(True), two_lifts(False)),
    ]
    for name, ours, peer in cases:
        ours()  # compiles
        (s, n), (peer_s, peer_n) = least(ours), least(peer)
        for what, unit, value, other in (("work", "operations", n, peer_n), ("time", "s", s, peer_s)):
            row(f"{name}, apart: {what}", value, unit, "in one piece", other, at_most=1.0)
    yard = noted_in(parse(text(MANY)))
    two, one = (min(x) for x in zip(*((in_threads(yard, 2), in_threads(yard, 1)) for _ in range(RUNS)), strict=True))
    row(f"a yard of {MANY} lifts on two processors, kernel alone", two, "s", "on one", one)
    row(f"a yard of {MANY} lifts on one processor beside two", one / two, "x", at_least=1.7)


if __name__ == "__main__":
    main()
