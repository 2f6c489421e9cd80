"""The same scene in one process and with a process per node, as `heavylift run` runs it: what the messages cost.

Both give the same digest; the wall time is that between the start and the last answer, with the recording.
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from heavylift.coordinator.participants.participant import PRELOAD
from heavylift.coordinator.run import run
from heavylift.coordinator.supervision.processes import Processes

if TYPE_CHECKING:
    from heavylift.nodes.scene import LoadedScene

__all__ = ["Distributed", "distributed"]


@dataclass(frozen=True)
class Distributed:
    """A run of the product: simulated and wall seconds, of which the kernel's and those of starting and leaving;
    grants, each answered by one DONE; digest."""

    where: str
    simulated_s: float
    wall_s: float
    kernel_s: float
    around_s: float
    grants: int
    digest: str

    @property
    def per_grant(self) -> float:
        """Wall seconds between grants that are no work of the kernel: models, messages, waiting, recording."""
        return max(0.0, self.wall_s - self.around_s - self.kernel_s) / self.grants


def distributed(scene: LoadedScene) -> list[Distributed]:
    """Run a scene as it is written, in this process and in processes of its own."""
    with tempfile.TemporaryDirectory(prefix="heavylift-") as folder:
        return [_run(scene, Path(folder) / "run.mcap", apart) for apart in (False, True)]


def _run(scene: LoadedScene, output: Path, apart: bool) -> Distributed:
    crew = Processes(PRELOAD) if apart else None
    began = time.perf_counter()
    try:
        result = run(scene, output, in_process=not apart, processes=crew)
    finally:
        if crew is not None:
            crew.end()
    where = "a process per node" if apart else "one process"
    wall, spent = time.perf_counter() - began, result.budget
    around = spent.start + spent.exit
    return Distributed(where, result.sim_s, wall, spent.kernel, around, result.grants, result.digest)
