"""Cuts and turned bytes anywhere in a file: it is read whole, or recovered with every message that is physically there,
or refused as holding none; and never is one told to recover what `recover` calls whole."""

from __future__ import annotations

import random
import struct
from collections import Counter
from io import BytesIO
from pathlib import Path

import pytest
from heavylift.kernel import RecordingError
from heavylift.recordings import Recorder, Recording, compare, recover
from heavylift.recordings.format import MAGIC
from heavylift.recordings.read import complaints
from mcap.data_stream import ReadDataStream
from mcap.records import Chunk, Message
from mcap.stream_reader import breakup_chunk
from small_run import SECOND, TIMES
from spoiled_recordings import CHUNK, records

PLACES = 150
DATA_END = 15


@pytest.fixture
def several(begin, batch, stage, tmp_path: Path) -> bytes:  # type: ignore[no-untyped-def]
    """The small run in chunks of their own, with a checkpoint between them and a result at its end."""
    rec: Recorder = begin()
    for k in range(len(TIMES)):
        rec.samples(batch(k, k + 1))
        stage(rec, k, f"stage {k}")
        if k == 2:
            rec.checkpoint((2 * SECOND, 1), b"state")
        rec._sink.mcap.flush()
    return rec.close("finished", result={"verdict": {"red": False, "line": "green"}}).read_bytes()


def whole_chunks(data: bytes, spoiled: bytes) -> list[bytes]:
    """The chunks whose record is in the spoiled file as it was, at its place or elsewhere."""
    found = [data[place : place + 9 + length] for opcode, place, length in records(data) if opcode == CHUNK]
    return [chunk for chunk in found if chunk in spoiled]


def messages(chunks: list[bytes]) -> Counter[tuple[int, bytes]]:
    """Times and bytes of the messages in these chunks, as the mcap library reads them."""
    inner = (x for chunk in chunks for x in breakup_chunk(Chunk.read(ReadDataStream(BytesIO(chunk[9:])))))
    return Counter((x.publish_time, x.data) for x in inner if isinstance(x, Message))


def told(path: Path) -> str:
    """What reading everything ends in: the sentence of a RecordingError or of a contradiction, "" if all is right."""
    try:
        rec = Recording(path)
        rec.events()
        rec.load(rec.signals())
        return "; ".join(complaints(rec))
    except RecordingError as error:
        return str(error)


def check(data: bytes, spoiled: bytes, path: Path) -> Recording | None:
    """One spoiled file: what came of it is what there is; the recording that was saved, if one was."""
    path.write_bytes(spoiled)
    out = path.with_name("saved.mcap")
    text = told(path)
    try:
        found, refused = recover(path, out, force=True), ""
    except RecordingError as error:
        found, refused = None, str(error)
    assert (text == "") == ("is complete and undamaged" in refused), (text, refused)
    if found is None:
        assert text == "" or not whole_chunks(data, spoiled), refused
        assert any(x in refused for x in ("is complete and undamaged", "contains no", "is not a recording"))
        return None
    saved = Recording(found.path)
    assert told(found.path) == ""
    kept, every = whole_chunks(data, spoiled), whole_chunks(data, data)
    if every[0] in kept or not found.lost:  # else the first chunk may have taken the descriptions with it
        assert Counter((x.publish_time, x.data) for x in saved.messages(*saved.topics)) >= messages(kept)
    return saved


def places(data: bytes, rng: random.Random) -> list[int]:
    """Some of each record, the whole end, and the magic at both ends."""
    begins = [place for _, place, _ in records(data)]
    end = next(place for opcode, place, _ in records(data) if opcode == DATA_END)
    some = [*range(len(MAGIC)), *begins, *(b + 1 for b in begins), *(b + 9 for b in begins)]
    some += [rng.randrange(len(data)) for _ in range(PLACES)] + [rng.randrange(end, len(data)) for _ in range(PLACES)]
    return sorted({*some, len(data) - 1, len(data) - len(MAGIC)})


def test_a_recording_cut_anywhere_is_recovered(several: bytes, tmp_path: Path) -> None:
    data, rng = several, random.Random(1)
    end = next(place for opcode, place, _ in records(data) if opcode == DATA_END)
    for place in places(data, rng):
        saved = check(data, data[:place], tmp_path / "cut.mcap")
        if place >= end:
            assert saved is not None
            assert saved.result == Recording(tmp_path / "run.mcap").result
            assert len(saved.checkpoints) == 1
            assert compare(tmp_path / "run.mcap", saved.path).equal


@pytest.mark.parametrize("turned", [0x01, 0x55, 0x80])
@pytest.mark.large(beyond=1)
def test_a_recording_with_a_changed_byte_is_recovered_or_refused(turned: int, several: bytes, tmp_path: Path) -> None:
    data, rng = several, random.Random(turned)
    end = next(place for opcode, place, _ in records(data) if opcode == DATA_END)
    for place in places(data, rng):
        spoiled = bytearray(data)
        spoiled[place] ^= turned
        saved = check(data, bytes(spoiled), tmp_path / "turned.mcap")
        if place >= end + 13:  # behind all data
            assert saved is not None
            assert saved.result == Recording(tmp_path / "run.mcap").result
        elif saved is not None and place < end:
            assert saved.result["status"] == "damaged"


def test_a_recording_whose_end_was_zeroed_by_a_power_cut_is_recovered(several: bytes, tmp_path: Path) -> None:
    for count in (1, 8, 29, 200, 1000, 2000):
        check(several, several[:-count] + bytes(count), tmp_path / "zeros.mcap")


def test_recovery_after_a_corrupt_length_field_loses_at_most_one_chunk(several: bytes, tmp_path: Path) -> None:
    chunks = [(place, length) for opcode, place, length in records(several) if opcode == CHUNK]
    for place, length in chunks[1:]:
        for wrong in (0, 5, length + 3, length * 2, 2**40, 2**63):
            spoiled = several[: place + 1] + struct.pack("<Q", wrong) + several[place + 9 :]
            saved = check(several, spoiled, tmp_path / "astray.mcap")
            assert saved is not None
            assert len(list(saved.messages("/samples"))) >= len(TIMES) - 1
