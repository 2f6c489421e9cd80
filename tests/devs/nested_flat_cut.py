"""One random model run three ways: nested by the abstract simulator, flattened, and cut into 2 to 5 nodes."""

import sys
from pathlib import Path

from abstract_simulator import nested
from heavylift.nodes.devs import Transition

sys.path.append(str(Path(__file__).parents[1] / "coordination"))

from random_models import END, Logs, build_deep, distributed, flat


def three_ways(seed: int) -> tuple[Logs, Logs, Logs]:
    """Logs by path: nested, flat, cut."""
    logs: Logs = {}

    def tell(line: Transition) -> None:
        logs.setdefault(line.path, []).append(line)

    nested(build_deep(seed), END, tell)
    return logs, flat(seed, build=build_deep), distributed(seed, seed, cut=seed % 2 > 0, build=build_deep).logs
