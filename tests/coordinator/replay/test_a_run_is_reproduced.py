"""A recording proves itself: simulated again, every event and sample comes again, or the first that does not."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import msgspec
import pytest
from altered_recordings import Parts, altered
from heavylift import run_models
from heavylift.coordinator.cli import main
from heavylift.coordinator.live import TimedCommand
from heavylift.coordinator.replay import RecordedRun, single
from heavylift.coordinator.run import run
from heavylift.coordinator.run.verify import verify
from heavylift.kernel import RecordingError, allowed
from heavylift.nodes.devs import Tag, encode
from heavylift.nodes.models.parts import DriveActor, OperatorCommand
from heavylift.nodes.plan import Motion
from heavylift.nodes.scene import load, spoken
from heavylift.recordings import Recorder, Recording


def command(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int:
    """Exit code of `heavylift ...` in this process."""
    monkeypatch.setattr("sys.argv", ["heavylift", *map(str, arguments)])
    try:
        main()
    except SystemExit as end:
        return int(end.code or 0)
    return 0


@pytest.fixture
def hurried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Somebody lets drives move twice as fast as they are reported."""
    obey = DriveActor.run
    monkeypatch.setattr(DriveActor, "run", lambda self, order, asked: obey(self, order, faster(asked)))


def faster(asked: Motion) -> Motion:
    return msgspec.structs.replace(asked, speed=2.0 * asked.speed)


def test_verification_reproduces_every_event_and_sample(recorded: RecordedRun) -> None:
    outcome = verify(recorded)
    assert outcome.same
    assert outcome.events == len(recorded.recording.events()) >= 50
    assert outcome.digest == recorded.recording.result["digest"]


@pytest.mark.usefixtures("hurried")
def test_verification_reports_the_first_event_that_deviates_with_both_values(recorded: RecordedRun) -> None:
    outcome = verify(recorded)
    message = outcome.deviation
    assert message is not None
    before = [e for e in recorded.events if e.order < (0, 1, "crane", "input", 0)]
    assert outcome.events == len(before), "the moves are the first thing that the crane says"
    assert (message.t_ns, message.microstep, message.topic) == (0, 1, "/crane/input")
    assert message.recorded["SetProfile"]["speed"] == pytest.approx(-0.3 / 60)
    assert message.now["SetProfile"] == {
        **message.recorded["SetProfile"],
        "speed": 2 * message.recorded["SetProfile"]["speed"],
    }


def test_verification_reports_the_first_sample_that_deviates(lift: Path, tmp_path: Path) -> None:
    signal = Recording(lift).signal("rope/tension")

    def forge(parts: Parts) -> None:
        i = parts.rows()[7]
        old, new = (struct.pack("<d", x) for x in (signal.values[7, 1], signal.values[7, 1] + 0.5))
        assert old in parts.messages[i].data
        parts.messages[i] = parts.messages[i]._replace(data=parts.messages[i].data.replace(old, new))

    message = verify(RecordedRun(altered(lift, tmp_path / "altered.mcap", forge))).deviation
    assert message is not None
    assert message.t_ns == round(signal.t[7] * 1e9)
    assert message.topic.startswith("/rope/tension/")
    assert (message.recorded, message.now) == (signal.values[7, 1] + 0.5, signal.values[7, 1])


def test_a_verification_reports_its_success_by_its_exit_code(
    lift: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], request: pytest.FixtureRequest
) -> None:
    digest = Recording(lift).result["digest"]
    assert command(monkeypatch, "replay", lift, "--verify") == 0
    assert f"digest {digest}" in capsys.readouterr().out
    assert command(monkeypatch, "replay", lift, "--verify", "--json") == 0
    assert json.loads(capsys.readouterr().out)["digest"] == digest
    request.getfixturevalue("hurried")
    assert command(monkeypatch, "replay", lift, "--verify") == 1
    assert "deviates after 17 equal events, at (0 s, 1) on /crane/input: recorded" in capsys.readouterr().out


def test_replay_with_verify_or_live_refuses_the_options_that_control_a_player(
    lift: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    says = f"heavylift: {lift}: {{}} runs models as fast as possible and replays nothing; leave out {{}}\n"
    assert command(monkeypatch, "replay", lift, "--verify", "--rate", "3", "--loop") == 1
    assert capsys.readouterr().err == says.format("--verify", "--rate, --loop")
    assert command(monkeypatch, "replay", lift, "--live", "crane", "--from", "0") == 1
    assert capsys.readouterr().err == says.format("--live", "--from")


def test_a_recording_that_cannot_be_simulated_again_is_refused_in_one_sentence(tmp_path: Path) -> None:
    def recording(name: str, attachments: dict[str, bytes]) -> RecordedRun:
        with Recorder(tmp_path / name, {"scene": "lift"}, attachments) as rec:
            return RecordedRun(rec.close())

    with pytest.raises(RecordingError, match=r"bare\.mcap: has no scene attached to simulate again; record it with"):
        verify(recording("bare.mcap", {}))
    with pytest.raises(RecordingError, match=r"old\.mcap: heavylift \S+ cannot run its scene \(.*\); this version"):
        verify(recording("old.mcap", {"resolved.json": b'{"gravity": 9.81}'}))


def test_verification_repeats_the_commands_of_an_operator(tmp_path: Path) -> None:
    scene, words = load("lift", ["end=20 s"]), "trolleys: traverse 10 m/min by 0.5 m"
    text = encode(OperatorCommand(words, msgspec.msgpack.encode(spoken(scene, words))))
    run(scene, tmp_path / "run.mcap", True, commands=[TimedCommand(Tag(3_000_000_000), text)])
    recorded = RecordedRun(tmp_path / "run.mcap")
    assert [e.port for e in recorded.events if e.source == "operator"] == ["command"]
    outcome = verify(recorded)
    assert outcome.same, outcome.deviation
    assert outcome.digest == recorded.recording.result["digest"]
    assert single(recorded, "commander").same


PATIENT = """
from heavylift.nodes.devs import Atomic, Coupled

class Patient(Atomic):
    def start(self): self.left = 10_500; self.hold_in(0)
    def internal(self):
        self.left -= 1
        self.hold_in(0) if self.left else self.passivate()

def build():
    root = Coupled("yard")
    root.add(Patient("patient"))
    return root
"""


def test_verification_uses_the_microstep_limit_of_the_run(tmp_path: Path) -> None:
    (tmp_path / "patient.py").write_text(PATIENT)
    with allowed([str(tmp_path)]):
        run_models(f"{tmp_path / 'patient.py'}:build", 1.0, tmp_path / "run.mcap", True, microsteps=11_000)
        recorded = RecordedRun(tmp_path / "run.mcap")
        assert verify(recorded).digest == recorded.recording.result["digest"]
