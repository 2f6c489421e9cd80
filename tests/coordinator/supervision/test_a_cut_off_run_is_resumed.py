"""The coordinator is killed: what is left is run again to its end, checked, and has the digest of the whole run."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.replay import RecordedRun
from heavylift.coordinator.run import Beginning, RunObserver, run
from heavylift.coordinator.run.resume import resume
from heavylift.kernel import RecordingError
from heavylift.nodes.scene import load

KILLED = """
import os, signal, sys
from pathlib import Path
from heavylift.coordinator.run import run
from heavylift.coordinator.run.watch import RunObserver
from heavylift.nodes.scene import load
from heavylift.recordings.write import sink

class Doom(RunObserver):
    left = int(sys.argv[2])
    def event(self, event):
        self.left -= 1
        if not self.left:
            os.kill(os.getpid(), signal.SIGKILL)

sink.FLUSH = 0.0
run(load("lift"), Path(sys.argv[1]), in_process=True, watch=Doom())
"""
ORDERED = """
import os, signal, sys
from pathlib import Path
import msgspec
from heavylift.coordinator.live import TimedCommand
from heavylift.coordinator.run import run
from heavylift.coordinator.run.watch import RunObserver
from heavylift.nodes.devs import Tag, encode
from heavylift.nodes.models.parts.messages import OperatorCommand
from heavylift.nodes.scene import load
from heavylift.nodes.scene.operator_command import spoken
from heavylift.recordings.write import sink

class Doom(RunObserver):
    def event(self, event):
        if event.port == "answer" and event.t >= 4 * 10**9 and len(sys.argv) == 3:
            os.kill(os.getpid(), signal.SIGKILL)

sink.FLUSH = 0.0
scene, words = load("case.yaml", ["mechanism.bodies.cart.mass=5 t"]), "pusher: drive 6 m/min by 50 mm"
said = encode(OperatorCommand(words, msgspec.msgpack.encode(spoken(scene, words))))
commands = [TimedCommand(Tag(t * 10**9), said) for t in (3, 4, 5)]
run(scene, Path(sys.argv[1]), in_process=True, watch=Doom(), commands=commands)
"""
SLEDGE = """\
heavylift: 1
name: sledge
mechanism:
  name: sledge
  bodies: {cart: {mass: 4 t}}
  joints: {rail: {type: prismatic, child: cart, axis: [1, 0, 0]}}
  drives: {pusher: {joint: rail, type: servo, stiffness: 1 MN/m, damping: 0.4 MN s/m, ramp: 0.5 m/s2}}
actions:
  - wait: 10 s
"""
EVENTS = 60  # after so many the coordinator is killed


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> str:
    return run(load("lift"), tmp_path_factory.mktemp("whole") / "lift.mcap", in_process=True).digest


@pytest.fixture(scope="module")
def part(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cut") / "lift.mcap"
    subprocess.run([sys.executable, "-c", KILLED, path, str(EVENTS)], check=False)
    assert not path.exists()
    return path.with_name("lift.mcap.part")


def test_a_resumed_run_equals_an_uninterrupted_one(part: Path, whole: str) -> None:
    before = part.read_bytes()
    begun = Beginning.of(part)
    assert 0 < len(begun.events) <= EVENTS
    result = resume(part, begun, in_process=True)
    assert (result.digest, result.recording.name) == (whole, "lift-resumed.mcap")
    assert RecordedRun(result.recording).events[: len(begun.events)] == begun.events
    assert part.read_bytes() == before


@pytest.mark.large
def test_a_difference_found_while_resuming_is_reported_with_time_and_port(part: Path, tmp_path: Path) -> None:
    begun = Beginning.of(part)
    events = list(begun.events)
    events[20] = msgspec.structs.replace(events[20], port="other")
    with pytest.raises(RecordingError, match=r"the repeated run differs from the recording, at \(.* s, \d+\) on /.*"):
        resume(part, replace(begun, events=events), tmp_path / "new.mcap", in_process=True)


def test_resuming_keeps_the_interrupted_recording(part: Path) -> None:
    with pytest.raises(RecordingError, match="would overwrite the recording to be resumed"):
        resume(part, Beginning.of(part), part.with_name("lift.mcap"))


def test_resuming_a_file_without_a_run_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.mcap.part").write_text("no recording")
    with pytest.raises(RecordingError, match="is not a recording"):
        Beginning.of(tmp_path / "notes.mcap.part")


@pytest.mark.large
def test_a_resumed_run_repeats_the_commands_of_an_operator(tmp_path: Path) -> None:
    """The scene extends another one and has a setting laid over it; both files are gone when the run is resumed."""
    (tmp_path / "sledge.yaml").write_text(SLEDGE)
    (tmp_path / "case.yaml").write_text("heavylift: 1\nextends: sledge.yaml\nname: case\n")
    for name, doomed in (("cut.mcap", ["doomed"]), ("whole.mcap", [])):
        subprocess.run([sys.executable, "-c", ORDERED, name, *doomed], cwd=tmp_path, check=False)
    (tmp_path / "sledge.yaml").unlink()
    (tmp_path / "case.yaml").unlink()
    begun = Beginning.of(tmp_path / "cut.mcap.part")
    assert [event.t for event in begun.events if event.source == "operator"][:1] == [3 * 10**9]
    assert [given.tag.t for given in begun.commands] == [3 * 10**9, 4 * 10**9, 5 * 10**9]
    result = resume(tmp_path / "cut.mcap.part", begun, tmp_path / "resumed.mcap", in_process=True)
    assert result.digest == RecordedRun(tmp_path / "whole.mcap").recording.result["digest"]


@pytest.mark.parametrize("moment", ["the scene is in the file", "its coordinator has failed"])
def test_a_recording_without_checkpoint_is_resumed_from_the_start(tmp_path: Path, whole: str, moment: str) -> None:
    """Nothing but the scene stands in what is left, cut off or ended by an error of the coordinator."""

    class Doom(RunObserver):
        def progress(self, t_ns: int) -> None:
            raise MemoryError

    path = tmp_path / "lift.mcap"
    if moment == "its coordinator has failed":
        with pytest.raises(MemoryError):
            run(load("lift"), path, in_process=True, watch=Doom())
    else:
        subprocess.run([sys.executable, "-c", KILLED.replace("sink.FLUSH = 0.0", ""), path, "1"], check=False)
        path = path.with_name("lift.mcap.part")
        assert Beginning.of(path).events == []
    assert resume(path, Beginning.of(path), in_process=True).digest == whole


def test_resuming_a_run_whose_recording_is_complete_is_refused(tmp_path: Path) -> None:
    run(load("pendulum", ["end=1 s"]), tmp_path / "pendulum.mcap", in_process=True)
    with pytest.raises(RecordingError, match=r"pendulum\.mcap: the file is complete and undamaged"):
        Beginning.of(tmp_path / "pendulum.mcap")
