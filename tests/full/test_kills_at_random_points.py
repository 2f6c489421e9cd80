"""Kills, stops and delays at random points of whole lifts, in several placements: one digest per scene.

Each run meets up to six troubles at random messages: SIGKILL of one or two processes, of the keeper, SIGSTOP that
lasts, SIGSTOP that is continued, a coordinator that is late.  Checkpoints are taken often, seldom or never.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from unittest import mock

import pytest
from heavylift.coordinator.hosts.placement import Placement
from heavylift.coordinator.run import joining, run
from heavylift.coordinator.run.watch import Watch
from heavylift.coordinator.supervision import succession
from heavylift.coordinator.supervision.succession import Succession
from heavylift.nodes.models import KERNEL, node_names
from heavylift.nodes.scene import load

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="sends signals to processes")

RUNS = {"lift": range(40), "pendulum": range(20), "turnover": range(6)}
DEADLINE_s = 8.0  # a loaded machine may need seconds to compile the mechanics
MESSAGES = {"lift": 80, "pendulum": 20, "turnover": 330}  # of an undisturbed run, about
Trouble = Callable[[Succession, str], None]


def signalled(number: int) -> Trouble:
    def act(hub: Succession, process: str) -> None:
        with suppress(ProcessLookupError):
            if (pid := hub._crew.pid(process)) is not None:
                os.kill(pid, number)

    return act


def rest(hub: Succession, process: str) -> None:
    signalled(signal.SIGSTOP)(hub, process)
    threading.Timer(0.3, signalled(signal.SIGCONT), (hub, process)).start()


def late(hub: Succession, process: str) -> None:
    time.sleep(0.2)


def orphan(hub: Succession, process: str) -> None:
    hub._crew._keeper.kill()


TROUBLES: list[Trouble] = [signalled(signal.SIGKILL)] * 5 + [signalled(signal.SIGSTOP), rest, late, orphan]


class Troubled(Succession):
    plan: dict[int, list[tuple[Trouble, str]]] = {}  # noqa: RUF012 - set by each run
    met = 0

    def send(self, node: str, payload: bytes) -> None:
        super().send(node, payload)
        self.sent = getattr(self, "sent", 0) + 1
        for act, process in self.plan.get(self.sent, ()):
            Troubled.met += 1
            act(self, process)


class Notes(Watch):
    def __init__(self) -> None:
        self.notes: list[str] = []

    def say(self, sentence: str) -> None:
        self.notes.append(sentence)


@pytest.fixture(scope="module")
def digests(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], str]:
    """Digest of the undisturbed run of a scene, all in this process."""
    known: dict[str, str] = {}

    def digest(scene: str) -> str:
        if scene not in known:
            path = tmp_path_factory.mktemp("whole") / f"{scene}.mcap"
            known[scene] = run(load(scene), path, in_process=True).digest
        return known[scene]

    return digest


@pytest.mark.parametrize(("scene", "seed"), [(scene, seed) for scene, seeds in RUNS.items() for seed in seeds])
def test_one_digest(tmp_path: Path, digests: Callable[[str], str], scene: str, seed: int) -> None:
    rng = random.Random(f"{scene} {seed}")
    loaded = load(scene)
    nodes = node_names(loaded.plan)
    count = rng.choice([len(nodes), len(nodes), 2, 4])
    placement = Placement.spread(nodes, count, KERNEL)
    plan: dict[int, list[tuple[Trouble, str]]] = {}
    for point in rng.sample(range(1, MESSAGES[scene]), 6):
        victims = rng.sample(sorted(placement.processes), min(rng.choice([1, 1, 2]), len(placement.processes)))
        plan[point] = [(rng.choice(TROUBLES), victim) for victim in victims]
    keep: dict[str, float] = rng.choice(
        [{"KEEP_s": 0.0, "KEEP_GRANTS": 2}, {"KEEP_s": 0.0, "KEEP_GRANTS": 15}, {"KEEP_s": 1e9}]
    )
    notes = Notes()
    with (
        mock.patch.object(joining, "Succession", Troubled),
        mock.patch.multiple(Troubled, plan=plan, met=0),
        mock.patch.multiple(succession, **keep, LOSSES=50),  # chance may strike one process thrice at one point
    ):
        result = run(loaded, tmp_path / "run.mcap", watch=notes, placement=placement, deadline=DEADLINE_s)
        assert Troubled.met > 0
    assert result.digest == digests(scene), notes.notes
