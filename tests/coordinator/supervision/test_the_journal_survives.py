"""A journal is read up to its first cut or damaged entry, wherever that lies, and never further."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import closing
from pathlib import Path
from types import FrameType

import pytest
from heavylift.coordinator.supervision import Journal, read
from heavylift.kernel import RecordingError

ENTRIES = [b"hoist", b"", b"travel" * 9, b"\x00" * 8, b"end"]
HEAD = 8  # bytes before each entry
STARTS = [sum(HEAD + len(e) for e in ENTRIES[:i]) for i in range(len(ENTRIES) + 1)]


@pytest.fixture
def written(tmp_path: Path) -> Path:
    path = tmp_path / "run.journal"
    with closing(Journal(path)) as journal:
        for entry in ENTRIES:
            journal.append(entry)
    return path


def whole_before(place: int) -> list[bytes]:
    """The entries that end at this byte or before."""
    return [entry for entry, end in zip(ENTRIES, STARTS[1:], strict=True) if end <= place]


def test_journal_entries_are_read_in_order(written: Path) -> None:
    assert list(read(written)) == ENTRIES


def test_a_journal_cut_at_any_byte_gives_its_complete_entries(written: Path) -> None:
    data = written.read_bytes()
    for place in range(len(data) + 1):
        written.write_bytes(data[:place])
        assert list(read(written)) == whole_before(place)


def test_a_damaged_journal_is_read_up_to_the_first_flipped_bit(written: Path) -> None:
    data = written.read_bytes()
    for place in range(len(data)):
        for bit in range(8):
            spoiled = bytearray(data)
            spoiled[place] ^= 1 << bit
            written.write_bytes(spoiled)
            assert list(read(written)) == whole_before(place)


def test_a_journal_file_that_contains_only_zeros_has_no_entry(written: Path) -> None:
    """As a file system may leave it when the power fails: the length is there, the data is not."""
    written.write_bytes(bytes(64))
    assert list(read(written)) == []


def test_reading_a_journal_that_does_not_exist_gives_no_entries(tmp_path: Path) -> None:
    assert list(read(tmp_path / "none.journal")) == []


def test_a_killed_writer_loses_no_journal_entry(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    pid = os.fork()
    if pid == 0:
        journal = Journal(path)
        for i in range(1000):
            journal.append(i.to_bytes(4, "little"))
        os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(pid, 0)
    assert list(read(path)) == [i.to_bytes(4, "little") for i in range(1000)]


def test_reading_a_growing_journal_again_returns_the_entries_added_since_the_last_read(tmp_path: Path) -> None:
    with closing(Journal(tmp_path / "run.journal")) as journal:
        journal.append(b"one")
        entries = read(journal.path)
        assert next(entries) == b"one"
        journal.append(b"two", sync=True)
        assert list(entries) == [b"two"]


def test_restarting_a_journal_at_a_checkpoint_discards_all_earlier_entries(written: Path) -> None:
    with closing(Journal(written)) as journal:
        journal.append(b"granted")
        journal.restart([b"checkpoint", b"outstanding"])
        journal.append(b"granted next")
        assert list(read(written)) == [b"checkpoint", b"outstanding", b"granted next"]
        assert [p.name for p in written.parent.iterdir()] == ["run.journal"]


def test_the_command_journal_is_deleted_at_the_end_of_a_run_without_failure(written: Path) -> None:
    journal = Journal(written)
    journal.append(b"last")
    journal.delete()
    assert not written.exists()


def test_an_unwritable_folder_for_the_journal_is_reported_by_name(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"nowhere/run\.journal: the journal cannot be written"):
        Journal(tmp_path / "nowhere" / "run.journal")


def test_an_interrupt_during_a_restart_of_the_journal_leaves_a_file_that_can_be_deleted(tmp_path: Path) -> None:
    lines = 0
    while True:
        journal, countdown = Journal(tmp_path / "run.journal"), lines

        def interrupt(frame: FrameType, event: str, arg: object) -> object:
            nonlocal countdown
            if event == "line":
                countdown -= 1
                if countdown < 0:
                    raise KeyboardInterrupt
            return interrupt

        before, _ = sys.gettrace(), sys.settrace(interrupt)
        try:
            journal.restart([b"checkpoint"])
        except KeyboardInterrupt:
            lines += 1
        else:
            break
        finally:
            sys.settrace(before)
            journal.delete()
            journal.delete()
    assert lines > 5
