"""What it gains to leave out what a scene does not require at the moment, and to solve islands apart.

    python tests/bench/midrun.py [--json] [--short]

Work is attempted steps times operations of one evaluation, which does not depend on the machine; the peer is the same
kernel in one piece with all laws in its code.  Seconds are those of this machine with machine code from the cache,
least of three: the steps alone for `crate` and `two lifts`, whole runs in one process for the others.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from heavylift.coordinator.participants import kernel_node
from heavylift.coordinator.participants.pause import configured
from heavylift.coordinator.protocol.core import Coordinator
from heavylift.coordinator.protocol.memory import run_in_memory
from heavylift.coordinator.protocol.node import Node
from heavylift.kernel.description.contacts import Box, Contact, Plane
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.islands.islands import Islands
from heavylift.kernel.simulation.simulation import Simulation
from heavylift.nodes.devs import Simulator, Tag, ns
from heavylift.nodes.models import COMMANDER, KERNEL, build, couplings
from heavylift.nodes.scene import LoadedScene, load

sys.path.insert(0, str(Path(__file__).parents[1] / "kernel/islands"))
sys.path.insert(0, str(Path(__file__).parents[1] / "kernel"))
from contact_scenes import brick, floating
from shared.rows import SHORT, options, row
from test_islands_are_solved_apart import TWO, UP, played
from test_two_cranes_of_which_one_idles import scene as two_cranes
from test_what_is_not_required_leaves_the_code import on_the_ground, play

SECOND, HOUR = 1_000_000_000, 100 * 3600
RUNS, SWING_s, END = (1, 20, ["end=5 s"]) if SHORT else (3, 2000, [])


class Metered(Simulation):
    """Counts the operations of all attempted steps."""

    work, counted = 0.0, 0.0

    def _leave_out(self, absent: frozenset[str]) -> None:
        if absent != self.absent:
            self.count()
        super()._leave_out(absent)

    def count(self) -> float:
        """Operations so far."""
        attempts = self["accepted"] + self["rejected"]
        self.work += (attempts - self.counted) * self.operations(self.absent)[0]
        self.counted = attempts
        return self.work


Made = Callable[[], tuple[float, float, np.ndarray]]  # seconds, operations, rows


def scene_run(scene: LoadedScene, lean: bool | None, apart: bool) -> Made:
    """A whole run of a scene in one process."""

    def simulate(system, tolerance, sample_ns, subscribed, method, step, ties=(), *_):
        if apart:
            return Islands(system, tolerance, sample_ns, subscribed, ties=ties, method=method, step=step)
        return Metered(system, tolerance, sample_ns, subscribed, method=method, step=step, lean=lean)

    def made() -> tuple[float, float, np.ndarray]:
        kernel_node.simulate = simulate
        plan, rows = scene.plan, list[bytes]()
        models = build(plan)
        kernel = kernel_node.KernelNode(configured(plan, models), rows.append)
        end = Tag(ns(plan.end or HOUR))
        core = Coordinator([*models, KERNEL], couplings(plan), end, (COMMANDER, "finished"), lambda event: None)
        nodes = [*(Node(n, Simulator(m)) for n, m in models.items()), Node(KERNEL, kernel)]
        began = time.perf_counter()
        run_in_memory(core, nodes)
        return time.perf_counter() - began, work(kernel.simulation), np.frombuffer(b"".join(rows), np.uint8)

    return made


def work(s: Simulation | Islands) -> float:
    if isinstance(s, Metered):
        return s.count()
    assert isinstance(s, Islands)
    return sum((p["accepted"] + p["rejected"]) * p.operations(frozenset())[0] for p in s.parts)


def crate(lean: bool | None) -> Made:
    """A crate of 10 t that a rope lifts off the ground and that swings for half an hour."""
    body = brick("load", (2.0, 2.0, 2.0), 1e4)
    ground = Contact("ground", Box("load", (2.0, 2.0, 2.0)), Plane(), 0.4)
    scene = on_the_ground()
    scene = System((body,), (floating("load", (0.5, 0.0, 1.0)),), ropes=scene.ropes, contacts=(ground,))

    def made() -> tuple[float, float, np.ndarray]:
        s = Metered(scene, sample_ns=SECOND // 4, lean=lean)
        s.start()
        began = time.perf_counter()
        play(s, before=12)
        s.run(SWING_s * SECOND)
        return time.perf_counter() - began, s.count(), np.array([row for _, row in s.rows])

    return made


def two_lifts(apart: bool) -> Made:
    """Two lifts in one scene, each with a load of 10 t."""

    def made() -> tuple[float, float, np.ndarray]:
        s = Islands(TWO, 1e-7, SECOND // 10) if apart else Metered(TWO, 1e-7, SECOND // 10, lean=False)
        s.start()
        began = time.perf_counter()
        played(s, UP, start=False)
        return time.perf_counter() - began, work(s), np.zeros(0)

    return made


def least(made: Made) -> tuple[float, float, np.ndarray]:
    return min((made() for _ in range(RUNS)), key=lambda x: x[0])


def main() -> None:
    options(__doc__ or "")
    turnover, lift, cranes = load("turnover", END), load("lift", END), two_cranes(end=5.0 if SHORT else 45.0)
    cases: list[tuple[str, Made, Made, bool]] = [
        ("crate, in the air without its ground", crate(None), crate(False), True),
        ("turnover, where that pays", scene_run(turnover, None, False), scene_run(turnover, False, False), True),
        ("turnover, at once", scene_run(turnover, True, False), scene_run(turnover, False, False), True),
        ("lift, where that pays", scene_run(lift, None, False), scene_run(lift, False, False), True),
        ("lift and an idle crane, apart", scene_run(cranes, None, True), scene_run(cranes, False, False), False),
        ("two lifts, apart", two_lifts(True), two_lifts(False), False),
    ]
    for name, ours, peer, same in cases:
        ours()  # compiles
        (s, n, rows), (peer_s, peer_n, peer_rows) = least(ours), least(peer)
        if same:
            assert rows.tobytes() == peer_rows.tobytes(), f"{name}: a bit has changed"
        for what, unit, value, other in (("work", "operations", n, peer_n), ("time", "s", s, peer_s)):
            row(f"{name}: {what}", value, unit, "in one piece, all laws", other, at_most=1.0)


if __name__ == "__main__":
    main()
