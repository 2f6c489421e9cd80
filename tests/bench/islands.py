"""Time saved by solving islands separately.

    python tests/bench/islands.py [--json] [--short]

Work is attempted steps times operations of one evaluation, which does not depend on the machine; the peer is the same
kernel in one piece.  Seconds are those of this machine with machine code from the cache, least of three: the steps
alone for `two lifts`, the whole run in one process for the other.  Last, many lifts advance in threads, on two
processors and on one, in turns; this is wall time, so other work on the machine counts.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

from heavylift.coordinator.participants import RowFrames, Session, kernel_node
from heavylift.kernel.description import merge
from heavylift.kernel.islands import Islands, SideBySide
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.devs import Tag, seconds
from heavylift.nodes.scene import LoadedScene

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "kernel/islands"))
sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))
from shared.rows import SHORT, options, row
from test_two_cranes_of_which_one_idles import scene as two_cranes
from two_loads import TWO, UP, G, lift, played, wind

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


def in_threads(threads: int) -> float:
    """Wall seconds until many lifts have been hoisted."""
    system = merge([lift(f"load{i}", 10.0 * i) for i in range(MANY)], G)
    islands = Islands(system, 1e-8, SECOND // 10)
    islands._side_by_side = SideBySide(threads)
    stages = [(1.0 + 0.1 * i, wind(f"load{i}", -3.0)) for i in range(MANY)]
    islands.start()
    began = time.perf_counter()
    played(islands, stages, start=False)
    return time.perf_counter() - began


def least(made: Made) -> tuple[float, float]:
    return min(made() for _ in range(RUNS))


def main() -> None:
    options(__doc__ or "")
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
    in_threads(1)  # compiles
    two, one = (min(found) for found in zip(*((in_threads(2), in_threads(1)) for _ in range(RUNS)), strict=True))
    row(f"{MANY} lifts on one processor beside two", one / two, "x", at_least=1.7)


if __name__ == "__main__":
    main()
