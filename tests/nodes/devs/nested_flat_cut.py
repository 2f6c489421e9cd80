"""Runs one model nested by the abstract simulator, flattened, and distributed over nodes at the root's children."""

import sys
from collections.abc import Callable
from pathlib import Path

from abstract_simulator import nested
from heavylift.coordinator.protocol import Coordinator, Coupling, Node
from heavylift.nodes.devs import Coupled, Simulator, Tag, Transition
from in_memory import run_in_memory

sys.path.append(str(Path(__file__).parents[2] / "coordinator/protocol"))

from random_models import END, Logs, build_deep, distributed, flat


def three_ways(seed: int) -> tuple[Logs, Logs, Logs]:
    """Logs of a random model by path: nested, flat, cut."""
    logs: Logs = {}

    def tell(line: Transition) -> None:
        logs.setdefault(line.path, []).append(line)

    nested(build_deep(seed), END, tell)
    return logs, flat(seed, build=build_deep), distributed(seed, seed, cut=seed % 2 > 0, build=build_deep).logs


def logs_of(build: Callable[[], Coupled], until: int) -> list[list[Transition]]:
    """Logs of a model in order of tag and path: nested, flat, cut."""
    by_the_book: list[Transition] = []
    nested(build(), until, by_the_book.append)
    flattened: list[Transition] = []
    whole = Simulator(build(), flattened.append)
    whole.start()
    whole.run(until)
    cut: list[Transition] = []
    root = build()
    couplings = [Coupling(s.owner.name, s.name, t.owner.name, t.name) for s, t in root.couplings]
    parts = {name: Simulator(child, cut.append, wires=couplings) for name, child in root.children.items()}
    run_in_memory(Coordinator(parts, couplings, Tag(until)), [Node(name, part) for name, part in parts.items()])
    return [sorted(log, key=lambda line: (line.tag, line.path)) for log in (by_the_book, flattened, cut)]
