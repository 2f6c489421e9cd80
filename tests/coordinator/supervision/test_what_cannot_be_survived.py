"""What would happen again and again, or otherwise each time, ends the run in one sentence."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from heavylift.coordinator.run import run_models
from heavylift.kernel import ModelError, ProtocolError
from trouble import MODELS, Notes, play, strike, trouble

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="watches processes in /proc, which only Linux has")


@pytest.mark.parametrize(
    ("doom", "how"),
    [("crash", r"was ended by signal 11 \(SIGSEGV\)"), ("leave", "ended with exit code 7")],
)
def test_three_process_losses_at_the_same_logical_time_end_the_run(
    monkeypatch: pytest.MonkeyPatch, doom: str, how: str
) -> None:
    monkeypatch.setenv("DOOM", doom)
    with pytest.raises(ProtocolError) as message:
        play({}, "doomed")
    assert re.fullmatch(
        rf"node south is gone at t = 0\.\d+ s: its process {how}; 3 successive processes were lost at the "
        "same point of the run; start the run again",
        str(message.value),
    )


def test_a_node_whose_model_raises_an_error_is_not_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DOOM", "raises")
    notes = Notes()
    with trouble({}), pytest.raises(ModelError, match=r"^ring\.south\.runner at .*ValueError: the hook is not there"):
        run_models(f"{MODELS}:doomed", watch=notes)
    assert notes.notes == []


def test_a_nondeterministic_model_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DOOM", "look_at_the_clock")
    with pytest.raises(ModelError) as message:
        play({110: strike("south")}, "doomed")
    assert re.fullmatch(
        r"model south is not deterministic after \(0\.\d+ s, \d+\): a replacement got the same messages, but "
        r"offer of its DONE differ from what it had said before; let it depend on nothing but .*",
        str(message.value),
    )


@pytest.mark.large
def test_a_model_that_hangs_is_reported_with_its_line_of_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DOOM", "hang")
    with pytest.raises(ProtocolError) as message:
        play({}, "doomed", deadline=0.3)
    assert "node south is gone at t = 0." in str(message.value)
    assert "its process has done no step for 0.3 s, at File " in str(message.value)
    assert re.search(r'doomed_models\.py", line \d+ in hang; 3 successive processes', str(message.value))


def test_a_node_whose_model_hangs_once_is_replaced(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("DOOM", "hang_once")
    monkeypatch.setenv("DOOM_FLAG", str(tmp_path / "flag"))
    run, notes = play({}, "doomed", deadline=0.3)
    assert run.digest == run_models(f"{MODELS}:build", in_process=True).digest
    assert len(notes) == 1
    assert "its process has done no step for 0.3 s, at File" in notes[0]
