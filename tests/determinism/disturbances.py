"""Runs one model or scene under many execution conditions, none of which may change its digest.

A `Case` is one combination; `digests` runs cases, those of one hash seed in one interpreter after the other.  Node
processes get random delays of their messages through `sitecustomize`; in one process the nodes that have something to
do take turns at random; spinning processes load the cores; `CutShort` ends grants early at random.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import combinations, product
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

HERE = Path(__file__).parent
PLACES = [HERE / "disturbed", HERE, HERE.parent / "turnover", HERE.parent / "coordinator/protocol"]
PATIENCE_s = 3600.0


class Case(NamedTuple):
    """One combination; `what`: "scene" with overrides after a blank, or a model's reference with the end in ns."""

    what: str
    hash_seed: int = 0
    processes: int = 1
    start: int = 0  # 0: in order, else the seed of a shuffle
    delay: int = 0  # 0: none, else a seed
    load: int = 0  # number of spinning processes
    cut: int = 0  # 0: none, else a seed


LEVELS: dict[str, tuple[int, ...]] = {
    "hash_seed": (0, 1, 4711),
    "processes": (1, 2, 4, 12),
    "start": (0, 1),
    "delay": (0, 1),
    "load": (0, 1),
    "cut": (0, 1),
}


def full(what: str, runs: int) -> list[Case]:
    """All combinations, each in `runs` orders of start and with as many other random numbers."""
    levels = {**LEVELS, "hash_seed": (0, 4711), "start": tuple(range(runs)), "load": (0, 2)}
    cases = [dict(zip(levels, values, strict=True)) for values in product(*levels.values())]
    for case in cases:
        case |= {name: case[name] * (case["start"] + 1) for name in ("delay", "cut")}
    return [Case(what, **case) for case in cases]


def pairwise(what: str) -> list[Case]:
    """Few combinations in which any two levels of any two disturbances meet; greedy, always the same."""
    names = list(LEVELS)
    cases = [dict(zip(names, levels, strict=True)) for levels in product(*LEVELS.values())]

    def pairs(case: dict[str, int]) -> set[tuple[tuple[str, int], ...]]:
        return {((a, case[a]), (b, case[b])) for a, b in combinations(names, 2)}

    missing = set().union(*(pairs(case) for case in cases))
    found = []
    while missing:
        best = max(cases, key=lambda case: len(pairs(case) & missing))
        missing -= pairs(best)
        found.append(Case(what, **best))
    return found


def digests(cases: Iterable[Case]) -> dict[Case, str]:
    """The digest of each case, run in interpreters of its hash seed, two at a time."""
    by_seed: dict[int, list[Case]] = {}
    for case in cases:
        by_seed.setdefault(case.hash_seed, []).append(case)
    found: dict[Case, str] = {}
    for seed, group in by_seed.items():
        hands = [hand for hand in (group[0::2], group[1::2]) if hand]
        running = [_worker(seed, hand) for hand in hands]
        for worker, hand in zip(running, hands, strict=True):
            text, error = worker.communicate(timeout=PATIENCE_s)
            assert worker.returncode == 0, error
            found |= dict(zip(hand, text.split(), strict=True))
    return found


def _worker(seed: int, cases: Sequence[Case]) -> subprocess.Popen[str]:
    with tempfile.TemporaryFile("w+") as orders:
        json.dump(cases, orders)
        orders.seek(0)
        return subprocess.Popen(
            [sys.executable, __file__],
            stdin=orders,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONHASHSEED": str(seed), "PYTHONPATH": os.pathsep.join(map(str, PLACES))},
        )


# in a worker


def digest(case: Case) -> str:
    """Run one case here."""
    from cut_short import CutShort
    from heavylift.coordinator.protocol import OpenCoordinator
    from heavylift.coordinator.run import conversation

    os.environ.pop("DISTURBED_DELIVERY", None)
    if case.delay:
        os.environ["DISTURBED_DELIVERY"] = str(case.delay)
    CutShort.random = Random(case.cut)
    assert conversation.OpenCoordinator in (CutShort, OpenCoordinator), "this is what a run decides with"
    conversation.OpenCoordinator = CutShort if case.cut else OpenCoordinator  # type: ignore[misc]
    with _spinning(case.load), _turns(case.delay), tempfile.TemporaryDirectory() as folder:
        return _scene(case, Path(folder)) if case.what.startswith("scene ") else _model(case)


def _scene(case: Case, folder: Path) -> str:
    from heavylift.coordinator.run import run
    from heavylift.coordinator.transport import Placement
    from heavylift.nodes.models import KERNEL, build
    from heavylift.nodes.scene import load

    _, name, *sets = case.what.split(" ")
    scene = load(name, sets)
    nodes = _shuffled([*build(scene.plan), KERNEL], case.start)
    if case.processes == 1:
        return run(scene, folder / "run.mcap", in_process=True, order=nodes).digest
    return run(scene, folder / "run.mcap", placement=Placement.spread(nodes, case.processes)).digest


def _model(case: Case) -> str:
    from heavylift import run_models
    from heavylift.coordinator.participants import built

    reference, until = case.what.split(" ")
    nodes = _shuffled(list(built(reference).children), case.start)
    if case.processes == 1:
        return run_models(reference, int(until) / 1e9, in_process=True, order=nodes).digest
    return run_models(reference, int(until) / 1e9, processes=case.processes, order=nodes).digest


def _shuffled(nodes: list[str], seed: int) -> list[str]:
    return Random(seed).sample(nodes, len(nodes)) if seed else nodes


@contextmanager
def _spinning(count: int) -> Iterator[None]:
    spinners = [subprocess.Popen([sys.executable, "-S", "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for spinner in spinners:
            spinner.kill()
            spinner.wait()


@contextmanager
def _turns(seed: int) -> Iterator[None]:
    """Nodes of this process take turns at random, each in its own order."""
    from heavylift.coordinator.transport import LocalHub

    receive, random = LocalHub.receive, Random(seed)

    def at_random(hub: LocalHub, timeout: float | None = None) -> Any:
        random.shuffle(hub._ready)
        return receive(hub, timeout)

    if seed:
        LocalHub.receive = at_random  # type: ignore[method-assign]
    try:
        yield
    finally:
        LocalHub.receive = receive  # type: ignore[method-assign]


if __name__ == "__main__":
    for entry in json.load(sys.stdin):
        print(digest(Case(*entry)), flush=True)
