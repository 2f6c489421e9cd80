"""What a killed run had put on disk becomes a whole recording again; what is lost is said."""

from __future__ import annotations

import random
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel import RecordingError
from heavylift.recordings import Recorder, Recording, recover
from small_run import SECOND

TRIALS = 300


@pytest.fixture
def killed(recorded: Path, tmp_path: Path) -> Path:
    """The .part file of a run that was killed after its last chunk, before metadata and summary."""
    whole = Recording(recorded)
    (chunk,) = whole._file.summary.chunk_indexes
    part = tmp_path / "killed.mcap.part"
    part.write_bytes(recorded.read_bytes()[: chunk.chunk_start_offset + chunk.chunk_length + 3])
    return part


def test_everything_that_a_killed_run_had_flushed_is_recovered(killed: Path, recorded: Path, tmp_path: Path) -> None:
    found = recover(killed)
    assert found.path == tmp_path / "killed-recovered.mcap"
    assert found.sim_s == 4.0
    old, new = Recording(recorded), Recording(found.path)
    assert new.run == old.run
    assert new.attachments == old.attachments
    assert new.events() == old.events()
    assert new.signals() == old.signals()
    for name in old.signals():
        assert np.array_equal(new.signal(name).values, old.signal(name).values)
        assert np.array_equal(new.signal(name).t, old.signal(name).t)


def test_a_recovered_recording_says_that_the_run_was_cut_off(killed: Path, recorded: Path) -> None:
    new = Recording(recover(killed).path)
    assert new.result["status"] == "cut off"
    assert new.result["reason"].startswith("recovered from killed.mcap.part: ")
    assert new.fact("peaks") == Recording(recorded).fact("peaks")


def test_a_recovered_recording_that_is_cut_again_is_recovered_without_loss(killed: Path, tmp_path: Path) -> None:
    first = recover(killed).path
    (tmp_path / "again.mcap").write_bytes(first.read_bytes()[:-1])
    again = recover(tmp_path / "again.mcap")
    assert again.lost == []
    assert Recording(again.path).result == Recording(first).result
    assert Recording(again.path).topics.keys() == Recording(first).topics.keys()


def test_recovery_skips_and_names_a_damaged_chunk(recorded: Path, tmp_path: Path) -> None:
    (chunk,) = Recording(recorded)._file.summary.chunk_indexes
    data = bytearray(recorded.read_bytes())
    data[chunk.chunk_start_offset + chunk.chunk_length - 5] ^= 0xFF
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data)
    with pytest.raises(RecordingError, match="contains no readable message"):
        recover(damaged)


def test_the_command_recover_reports_how_many_seconds_of_the_run_are_lost(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", {"scene": "lift"}) as rec:
        for t in range(4):
            rec.log(t * SECOND, "info", "x", "x")
            rec.settle((t + 1) * SECOND)
            rec._sink.mcap.flush()
    _, second, _, fourth = Recording(tmp_path / "run.mcap")._file.summary.chunk_indexes[:4]
    data = bytearray((tmp_path / "run.mcap").read_bytes()[: fourth.chunk_start_offset + 40])
    data[second.chunk_start_offset + second.chunk_length - 5] ^= 0xFF
    (tmp_path / "cut.mcap.part").write_bytes(data)
    damaged, cut = recover(tmp_path / "cut.mcap.part").lost
    assert damaged.endswith(": 0.000 s of the run, 1.000 to 1.000 s")
    assert cut.endswith("where the file is cut off or damaged: 0.000 s of the run, 3.000 to 3.000 s")


def test_the_command_recover_refuses_a_recording_that_is_complete(recorded: Path, tmp_path: Path) -> None:
    with pytest.raises(RecordingError) as error:
        recover(recorded)
    assert str(error.value) == f"{recorded}: the file is complete and undamaged; there is nothing to recover"
    assert not (tmp_path / "run-recovered.mcap.part").exists()


def test_recovery_never_overwrites_its_source(killed: Path) -> None:
    before = killed.read_bytes()
    with pytest.raises(RecordingError) as error:
        recover(killed, killed.with_suffix(""))
    assert str(error.value) == (
        f"{killed.with_suffix('')}: this would overwrite the file to be recovered; choose another name with -o"
    )
    assert killed.read_bytes() == before


def test_the_command_recover_refuses_files_that_contain_no_run(tmp_path: Path, begin: Callable[[], Recorder]) -> None:
    photo = tmp_path / "photo.mcap"
    photo.write_bytes(b"\x89PNG\r\n\x1a\n" * 20)
    with pytest.raises(RecordingError, match="is not a recording"):
        recover(photo)
    with pytest.raises(RecordingError, match="cannot be opened"):
        recover(tmp_path / "missing.mcap.part")
    rec = begin()  # killed before the first flush: only the facts are on disk
    early = tmp_path / "early.mcap.part"
    shutil.copy(tmp_path / "run.mcap.part", early)
    with pytest.raises(RecordingError, match="contains no readable message"):
        recover(early)
    rec.close()


def test_recovering_any_damaged_file_gives_a_recording_or_a_one_sentence_error(recorded: Path, tmp_path: Path) -> None:
    data = recorded.read_bytes()
    rng = random.Random(5)
    sentences = []
    for _ in range(TRIALS):
        broken = bytearray(data[: rng.randrange(len(data))] if rng.random() < 0.5 else data)
        for _ in range(rng.choice((0, 1, 4, 40))):
            if broken:
                broken[rng.randrange(len(broken))] = rng.randrange(256)
        part = tmp_path / "fuzz.mcap.part"
        part.write_bytes(broken)
        try:
            Recording(recover(part).path).events()
        except RecordingError as error:
            sentences.append(str(error))
    assert 0 < len(sentences) < TRIALS
    assert not any("\n" in sentence for sentence in sentences)
