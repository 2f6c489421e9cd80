"""One model against yesterday's run: unchanged it says what it said, changed it is caught at its first other word."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from heavylift.coordinator.replay import RecordedRun, single
from heavylift.kernel import ModelError, RecordingError
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.models.parts import DriveActor, Order

HEAVYLIFT = Path(sys.executable).parent / "heavylift"


def test_every_recorded_model_that_is_replayed_alone_repeats_its_outputs(recorded: RecordedRun) -> None:
    assert list(recorded.cast.models) == [
        "crane/crane", "loader/loader-1", "loader/loader-2", "loader/loader-3", "block", "commander", "kernel",
    ]  # fmt: skip
    heard = 0
    for name in recorded.cast.models:
        outcome = single(recorded, name)
        assert outcome.same, f"{name} {outcome.deviation}"
        heard += outcome.events
    assert heard == len(recorded.events), "each event is that of one model"


def test_replaying_one_model_runs_its_present_code_and_not_the_recorded_one(
    recorded: RecordedRun, monkeypatch: pytest.MonkeyPatch
) -> None:
    halt = DriveActor.halt
    late: list[int] = []

    def sluggish(self: DriveActor, order: Order) -> None:
        """Forgets the first halt that it is given."""
        if late:
            halt(self, order)  # type: ignore[arg-type]
        late.append(self.now.t)

    monkeypatch.setattr(DriveActor, "halt", sluggish)
    message = single(recorded, "crane/crane").deviation
    assert message is not None
    assert (message.t_ns, message.topic) == (late[0], "/crane/input"), "at the halt that was forgotten"
    assert message.recorded["SetProfile"]["speed"] == 0.0
    assert single(recorded, "block").same, "who has not changed does not deviate"


def test_a_replayed_kernel_with_changed_gravity_differs_from_the_recording_in_the_first_sample(
    recorded: RecordedRun, monkeypatch: pytest.MonkeyPatch
) -> None:
    make = Simulation.__init__

    def lighter(self, system, *rest, **options):  # type: ignore[no-untyped-def]
        make(self, type(system)(**{**vars(system), "gravity": 9.7}), *rest, **options)

    monkeypatch.setattr(Simulation, "__init__", lighter)
    message = single(recorded, "kernel").deviation
    assert message is not None
    assert message.t_ns == 0
    assert isinstance(message.recorded, float)
    assert message.now != message.recorded


def test_a_replayed_model_that_fails_is_named_with_the_time(
    recorded: RecordedRun, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(self: DriveActor, order: Order, asked: object) -> None:
        raise ZeroDivisionError("speed")

    monkeypatch.setattr(DriveActor, "run", broken)
    with pytest.raises(
        ModelError,
        match=r"^crane\.lower-body\.H3 at \(0 s, 0\): \w+\(\) raised ZeroDivisionError: speed \(test_one_\w+\.py:",
    ):
        single(recorded, "crane")


def test_the_error_for_replaying_an_unknown_model_lists_the_known_models(recorded: RecordedRun) -> None:
    with pytest.raises(RecordingError) as error:
        single(recorded, "crane/west")
    assert str(error.value) == (
        f"{recorded.path}: there is no model crane/west; the recording has crane/crane, loader/loader-1, "
        "loader/loader-2, loader/loader-3, block, commander, kernel"
    )


MODEL = """
from heavylift.nodes.zoo.token_ring import ring

def build():
    model = ring(3, 1, 1_000_000)
    model.children["s1"].hold += {late}
    return model
"""


@pytest.mark.large
def test_an_edited_user_model_replayed_alone_reports_its_first_deviation_from_the_recording(tmp_path: Path) -> None:
    def heavylift(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([HEAVYLIFT, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=60)

    source = tmp_path / "mine.py"
    source.write_text(MODEL.format(late=0))
    assert heavylift("devs", "mine.py:build", "--until", "10 ms", "-o", "run.mcap", "--in-process").returncode == 0
    assert heavylift("replay", "run.mcap", "--live", "s1").stdout == "s1: no deviation in 3 events\n"
    source.write_text(MODEL.format(late=7))
    done = heavylift("replay", "run.mcap", "--live", "s1")
    assert done.returncode == 1
    assert done.stdout.splitlines()[0] == (
        's1 deviates after 0 equal events, at (0.002 s, 0) on /s1/out: recorded {"Token":{"number":0}}, now nothing'
    )
    assert heavylift("replay", "run.mcap", "--live", "s0").returncode == 0
    assert heavylift("replay", "run.mcap", "--verify").returncode == 1
    source.write_text(MODEL.format(late=0))
    assert heavylift("replay", "run.mcap", "--verify").stdout.startswith("reproduced: 9 events and all samples")
