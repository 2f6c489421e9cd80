"""What a run shows is on disk within a second, and not in memory, whatever the run is busy with."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from heavylift.coordinator.participants.kernel_node import BATCH
from heavylift.coordinator.protocol import Coordinator
from heavylift.coordinator.run import run
from heavylift.kernel import RecordingError
from heavylift.kernel.simulation.native import ROWS as REST
from heavylift.nodes.scene import bundled, load, parse
from heavylift.recordings import Recorder, Recording, recover
from heavylift.recordings.format import McapFile
from heavylift.recordings.write import PendingRows
from lifting import unstated

SWING = ["end=900 s", "samples=2 Hz"]
ROWS = 1 + 2 * 900  # and all of them lie between two events


def waiting(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Sample rows that wait for their place in the file, after each batch."""
    found: list[int] = []
    settle = Recorder.settle

    def counted(recorder: Recorder, t_ns: int) -> None:
        settle(recorder, t_ns)
        blocks = [what for *_, what in recorder._queue if isinstance(what, PendingRows)]
        found.append(sum(len(what.block.times) - what.first for what in blocks))

    monkeypatch.setattr(Recorder, "settle", counted)
    return found


@pytest.mark.parametrize("in_process", [True, False])
def test_samples_are_written_to_disk_without_waiting_for_the_next_event(
    in_process: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A load that swings, in one grant or in ninety."""
    rows = waiting(monkeypatch)
    run(load("pendulum", SWING), tmp_path / "swing.mcap", in_process=in_process)
    assert max(rows) <= 2 * BATCH
    monkeypatch.setattr(Coordinator, "working", lambda core, name, t_ns: None)
    rows.clear()
    if in_process:
        run(load("pendulum", SWING), tmp_path / "swing.mcap", in_process=True)
        assert max(rows) > ROWS - BATCH


def test_sample_rows_of_a_lift_at_rest_are_written_in_batches_before_the_run_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A lift to which nobody gives an order: its last 2000 rows are made when the run ends."""
    text = unstated(bundled()["lift"].read_text())
    lift = parse(
        f"{text[: text.index('actions:')]}actions:\n  - wait: 12 s\n", overrides=["end=12 s", "samples=200 Hz"]
    )
    rows, sizes, sampled = waiting(monkeypatch), [0], Recorder.samples

    def counted(recorder: Recorder, payload: bytes) -> None:
        sizes.append(len(payload))
        sampled(recorder, payload)

    monkeypatch.setattr(Recorder, "samples", counted)
    run(lift, tmp_path / "rest.mcap", in_process=True)
    found = Recording(tmp_path / "rest.mcap").signal("rope/tension")
    assert len(found.t) == 2 + 200 * 12
    assert (found.values[200:] == found.values[200]).all()
    assert max(rows) <= 2 * REST
    assert sum(sizes) < 8 * 2 * BATCH * len(found.t), "a tenth of what each by itself would take"


def test_recorded_data_reach_the_disk_without_a_further_call_of_the_recorder(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", {"scene": "x"}) as rec:
        part = rec._sink._file.part
        rec.log(10**9, "info", "x", "said")
        rec.settle(2 * 10**9)
        before, patience = part.stat().st_size, time.monotonic() + 20.0
        while part.stat().st_size == before:  # nobody calls the recorder meanwhile
            assert time.monotonic() < patience
            time.sleep(0.01)
        assert recover(part, tmp_path / "saved.mcap").messages == 1


def test_an_error_of_the_thread_that_writes_the_recording_is_raised_at_the_next_recorded_item(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(file: McapFile) -> None:
        raise OSError(28, "No space left on device")

    rec = Recorder(tmp_path / "run.mcap", {"scene": "x"})
    monkeypatch.setattr(McapFile, "flush", full)
    rec.log(10**9, "info", "x", "said")
    rec._sink._thread.join(20.0)
    with pytest.raises(RecordingError, match=r"run.mcap.part: the file cannot be written \(No space left on device\)"):
        rec.settle(2 * 10**9)
    with pytest.raises(RecordingError, match="No space left"):
        rec.close()
    assert not rec._sink._thread.is_alive()
