"""A recording that cannot be read ends in one sentence: its name and what to do, whatever its bytes are."""

from __future__ import annotations

import os
import random
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest
import zstandard
from heavylift.kernel import RecordingError
from heavylift.recordings import Recorder, Recording, recover
from mcap.writer import Writer


def refusal(path: Path) -> str:
    with pytest.raises(RecordingError) as error:
        Recording(path)
    sentence = str(error.value)
    assert sentence.startswith(f"{path}: ")
    assert "\n" not in sentence
    return sentence.removeprefix(f"{path}: ")


def test_opening_a_pipe_as_a_recording_is_refused_without_waiting(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.mcap")
    assert refusal(tmp_path / "pipe.mcap") == "this is a pipe or device; save the recording to a file first"
    with pytest.raises(RecordingError, match=r"pipe\.mcap: this is not a file; give the name of a recording"):
        recover(tmp_path / "pipe.mcap")


def test_opening_a_missing_recording_is_reported(tmp_path: Path) -> None:
    assert refusal(tmp_path / "run.mcap") == "the file does not exist; check the name or make it with `heavylift run`"


def test_opening_a_recording_that_was_cut_off_is_reported(begin: Callable[[], Recorder], tmp_path: Path) -> None:
    rec = begin()
    assert refusal(tmp_path / "run.mcap") == (
        f"the file does not exist, but {tmp_path}/run.mcap.part does: its run is still going or was cut off; "
        f"`heavylift recover {tmp_path}/run.mcap.part`"
    )
    assert refusal(tmp_path / "run.mcap.part") == (
        "the file is cut off: its end is missing, as in the .part file of a run that was killed; "
        f"`heavylift recover {tmp_path}/run.mcap.part` saves what can be read"
    )
    rec.close()


def test_opening_a_folder_an_empty_file_or_another_format_is_reported(tmp_path: Path) -> None:
    (tmp_path / "empty.mcap").touch()
    (tmp_path / "photo.mcap").write_bytes(b"\x89PNG\r\n\x1a\n" * 20)
    assert refusal(tmp_path) == "this is a folder; give the name of a recording, such as run.mcap"
    assert refusal(tmp_path / "empty.mcap") == "the file is empty; run the scene again"
    assert refusal(tmp_path / "photo.mcap") == (
        "this is not a recording (not an MCAP file); give a file made by `heavylift run`"
    )


def test_opening_an_mcap_file_of_another_program_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "robot.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.finish()  # type: ignore[no-untyped-call]
    assert refusal(path) == "this is an MCAP file of another program; give a file made by `heavylift run`"


def test_every_truncated_recording_is_refused(recorded: Path, tmp_path: Path) -> None:
    data = recorded.read_bytes()
    part = tmp_path / "short.mcap"
    for length in [*range(1, 60), *range(60, len(data), 97), len(data) - 1]:
        part.write_bytes(data[:length])
        refusal(part)


def test_damage_anywhere_in_a_recording_is_reported_or_changes_no_data(recorded: Path, tmp_path: Path) -> None:
    data = recorded.read_bytes()
    rng = random.Random(11)
    part = tmp_path / "damaged.mcap"
    sentences = []
    for _ in range(300):
        broken = bytearray(data)
        for _ in range(rng.choice((1, 1, 4, 40))):
            broken[rng.randrange(len(broken))] = rng.randrange(256)
        part.write_bytes(broken)
        try:
            rec = Recording(part)
            rec.events()
            for name in rec.signals():
                rec.signal(name)
        except RecordingError as error:
            sentences.append(str(error))
    assert len(sentences) > 250
    assert all(sentence.startswith(f"{part}: ") and "\n" not in sentence for sentence in sentences)


def test_a_chunk_that_declares_a_huge_size_is_not_unpacked(recorded: Path, tmp_path: Path) -> None:
    rec = Recording(recorded)
    (index,) = rec._file.summary.chunk_indexes
    data = bytearray(recorded.read_bytes())
    bomb = zstandard.compress(bytes(1 << 27))
    place = index.chunk_start_offset + 9 + 16
    struct.pack_into("<QI", data, place, 1 << 27, zlib.crc32(b""))
    path = tmp_path / "bomb.mcap"
    path.write_bytes(data)
    with pytest.raises(RecordingError) as error:
        Recording(path).events()
    assert str(error.value) == (
        f"{path}: is damaged (a chunk of 134217728 bytes exceeds the size limit; the checksum of its data is wrong); "
        f"`heavylift recover {path}` saves what can be read"
    )
    frame = place + 12 + 4 + len("zstd") + 8
    struct.pack_into("<Q", data, place, index.uncompressed_size)
    head = bomb[: index.compressed_size]
    data[frame : frame + len(head)] = head
    path.write_bytes(data)
    with pytest.raises(RecordingError, match="the size of a chunk differs from the stated size"):
        Recording(path).events()


def test_the_error_for_an_unknown_signal_lists_the_known_signals(recorded: Path) -> None:
    with pytest.raises(RecordingError) as error:
        Recording(recorded).signal("rope/colour")
    assert str(error.value) == (
        f"{recorded}: the recording has no signal rope/colour; "
        "there are rope/tension, rope/peak, rope/peak_time, pose/block, pose/hook"
    )
