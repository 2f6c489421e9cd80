"""A model that leads a drive: one digest in one process and in many, after kills, cut off and resumed, and replayed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from heavylift.coordinator.record import play
from heavylift.coordinator.replay import RecordedRun, single
from heavylift.coordinator.run import Beginning, RunObserver, run
from heavylift.coordinator.run.resume import resume
from heavylift.coordinator.run.verify import verify
from heavylift.coordinator.supervision import failover
from heavylift.coordinator.transport import Placement
from heavylift.nodes.devs import Event
from heavylift.nodes.models import node_names
from heavylift.nodes.scene import LoadedScene, load

END = "end=8 s"
DELAYS = ("0 s", "50 ms", "250 ms")


def damper(delay: str = "0 s") -> LoadedScene:
    return load("damper", (END, f"models.damper.delay={delay}"))


@pytest.fixture(scope="module")
def truth() -> dict[str, str]:
    return {delay: play(damper(delay).plan).digest for delay in DELAYS}


def test_a_user_model_with_a_changed_delay_gives_a_run_with_another_digest(truth: dict[str, str]) -> None:
    assert len({*truth.values()}) == len(DELAYS)


@pytest.mark.parametrize("delay", DELAYS)
@pytest.mark.large(beyond=1)
def test_the_digest_of_a_run_does_not_depend_on_the_process_in_which_a_user_model_runs(
    tmp_path: Path, truth: dict[str, str], delay: str
) -> None:
    scene = damper(delay)
    nodes = list(node_names(scene.plan))
    other = Placement({"here": ("damper", "commander"), "there": ("mechanism",), "kernel": ("kernel",)})
    assert run(scene, tmp_path / "one.mcap", in_process=True).digest == truth[delay]
    assert run(scene, tmp_path / "apart.mcap").digest == truth[delay]
    assert run(scene, tmp_path / "beside.mcap", placement=other).digest == truth[delay]
    assert run(scene, tmp_path / "turned.mcap", order=nodes[::-1]).digest == truth[delay]


class Killing(RunObserver):
    """Kills these nodes at these times [s]."""

    def __init__(self, victims: dict[float, str]) -> None:
        self.victims, self.message = dict(victims), list[str]()
        self.crew: failover.Processes | None = None

    def say(self, sentence: str) -> None:
        self.message.append(sentence)

    def event(self, event: Event) -> None:
        for t in [t for t in self.victims if event.t >= t * 1e9]:
            assert self.crew is not None
            os.kill(self.crew.pids[self.victims.pop(t)], signal.SIGKILL)


@pytest.mark.parametrize("often", [False, True], ids=["told in full", "from checkpoints"])
@pytest.mark.large(beyond=1)
@pytest.mark.skipif(sys.platform != "linux", reason="watches processes in /proc, which only Linux has")
def test_a_run_with_user_models_survives_killed_processes(
    tmp_path: Path, truth: dict[str, str], often: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = Killing({1.5: "damper", 3.0: "kernel", 4.5: "commander", 6.0: "damper"})
    began = failover.Processes.start

    def start(crew: failover.Processes, *more: object) -> object:
        watch.crew = crew
        return began(crew, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(failover.Processes, "start", start)
    if often:
        monkeypatch.setattr(failover, "KEEP_s", 0.0)
        monkeypatch.setattr(failover, "KEEP_GRANTS", 3)
    assert run(damper("50 ms"), tmp_path / "damper.mcap", watch=watch).digest == truth["50 ms"]
    replaced = [note.split()[1] for note in watch.message if "is replaced" in note]
    assert replaced == ["damper", "kernel", "commander", "damper"]


KILLED = """
import os, signal, sys
from pathlib import Path
from heavylift.coordinator.run import run
from heavylift.coordinator.run.watch import RunObserver
from heavylift.nodes.scene import load
from heavylift.recordings.write import sink

class Doom(RunObserver):
    def event(self, event):
        if event.t > 5 * 10**9:
            os.kill(os.getpid(), signal.SIGKILL)

sink.FLUSH = 0.0
run(load("damper", ("end=8 s", "models.damper.delay=50 ms")), Path(sys.argv[1]), in_process=True, watch=Doom())
"""


def test_an_interrupted_run_with_user_models_is_resumed(tmp_path: Path, truth: dict[str, str]) -> None:
    subprocess.run([sys.executable, "-c", KILLED, tmp_path / "damper.mcap"], check=False)
    part = tmp_path / "damper.mcap.part"
    begun = Beginning.of(part)
    assert begun.events[-1].t > 3 * 10**9, "what waits for islands that run ahead is lost"
    assert resume(part, begun, in_process=True).digest == truth["50 ms"]


def test_a_recorded_user_model_replayed_alone_gives_the_same_outputs(tmp_path: Path, truth: dict[str, str]) -> None:
    run(damper("50 ms"), tmp_path / "damper.mcap", in_process=True)
    recorded = RecordedRun(tmp_path / "damper.mcap")
    outcome = verify(recorded)
    assert (outcome.same, outcome.digest) == (True, truth["50 ms"])
    assert list(recorded.cast.models) == ["mechanism/mechanism", "model/damper", "commander", "kernel"]
    heard = [single(recorded, name) for name in recorded.cast.models]
    assert all(outcome.same for outcome in heard)
    assert sum(outcome.events for outcome in heard) == len(recorded.events)
