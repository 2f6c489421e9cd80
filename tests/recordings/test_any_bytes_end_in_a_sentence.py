"""Whatever a file holds, every reading command ends in a result or in one sentence, and soon.

Three hundred spoiled files here; tests/full has ten thousand.
"""

from __future__ import annotations

import random
import struct
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
import zstandard
from heavylift.kernel import RecordingError
from heavylift.recordings import Recorder, Recording, curves, recover
from heavylift.recordings.format import McapFile
from heavylift.recordings.render.view import content
from numpy.typing import NDArray
from small_run import TIMES
from spoiled_recordings import patience, read_in_all_ways, spoiled

FILES, SHARDS = 300, 3


@pytest.mark.parametrize("shard", range(SHARDS))
@pytest.mark.large(beyond=1)
def test_a_corrupted_recording_is_refused_with_a_one_sentence_error(recorded: Path, tmp_path: Path, shard: int) -> None:
    data, rng = recorded.read_bytes(), random.Random(shard)
    path, sentences = tmp_path / "spoiled.mcap", []
    for number in range(FILES // SHARDS):
        path.write_bytes(spoiled(data, rng))
        sentences += read_in_all_ways(path, recorded, tmp_path, pictures=number % 50 == 0)
    assert len(sentences) > FILES // SHARDS
    assert not [s for s in sentences if "\n" in s or len(s) > 1000]


def test_a_recording_of_a_later_version_is_reported(
    recorded: Path, tmp_path: Path, begin: Callable[[], Recorder]
) -> None:
    with Recorder(tmp_path / "later.mcap", {"format": 3, "scene": "lift"}) as rec:
        rec.log(0, "info", "x", "x")
    with pytest.raises(
        RecordingError,
        match=r"has format 3, but this is heavylift .*, which reads format 2; install .* or a later one",
    ):
        Recording(tmp_path / "later.mcap")
    for number, early in enumerate(("0", "9" * 5000, "\u00b2", "")):
        with Recorder(tmp_path / f"{number}.mcap", {"format": early}) as rec:
            rec.log(0, "info", "x", "x")
        with pytest.raises(RecordingError, match=rf"has format {early[:20]}, but this is .*; run the scene again"):
            Recording(tmp_path / f"{number}.mcap")


def bombs(path: Path, chunks: int, size: int, claim: int | None = None, frame: bytes = b"") -> None:
    """A file of a few kilobytes whose chunks unpack to `size` bytes, or to what is in a frame that claims another."""
    crc = 0 if frame else zlib.crc32(bytes(size))
    frame = frame or zstandard.compress(bytes(size))
    head = struct.pack("<QQQII", 0, 0, size if claim is None else claim, crc, 4) + b"zstd"
    head += struct.pack("<Q", len(frame))
    with path.open("wb") as stream:
        file = McapFile(stream, "bomb")
        file.metadata("run", {"format": "2"})
        channel = file.channel("/samples", "protobuf", file.schema("x", "", b""), {"signals": "[]"})
        for _ in range(chunks):
            file.write(channel, 0, 0, b"")
            file.flush()
            index = file._chunks[-1]
            index.uncompressed_size, index.compressed_size = size, len(frame)
            index.chunk_start_offset, index.chunk_length = file._record(_Raw(6, head + frame))
        file.finish()


class _Raw:
    """A record made of these bytes."""

    def __init__(self, opcode: int, body: bytes) -> None:
        self._opcode, self._body = opcode, body

    def write(self, builder: object) -> None:
        builder.write(struct.pack("<BQ", self._opcode, len(self._body)) + self._body)  # type: ignore[attr-defined]


def test_compressed_data_that_would_expand_without_bound_are_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "bomb.mcap"
    bombs(path, 400, 48 << 20)
    assert path.stat().st_size < 1 << 20
    with (
        patience(5.0),
        pytest.raises(
            RecordingError, match=r"it would have 20132659200 bytes when unpacked, more than any run records"
        ),
    ):
        Recording(path)
    with patience(5.0):
        lost = recover(path).lost
    assert lost[-1].endswith("would unpack to more than any run records")


BIG = 512 << 20


def bomb(says: int | None = BIG) -> bytes:
    """A frame of noughts that says how many they are, or something else, or nothing."""
    packer = zstandard.ZstdCompressor(write_content_size=says is not None).compressobj(size=BIG)
    frame = b"".join(packer.compress(bytes(1 << 20)) for _ in range(BIG >> 20)) + packer.flush()
    return frame if says is None else frame.replace(struct.pack("<I", BIG), struct.pack("<I", says), 1)


def peak_kB() -> int:
    """The most that this process had in memory since the last call."""
    lines = Path("/proc/self/status").read_text().splitlines()
    Path("/proc/self/clear_refs").write_text("5")
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def attached(path: Path, claim: int) -> None:
    """A file with an attachment whose own length is not that of its record."""
    with path.open("wb") as stream:
        file = McapFile(stream, "bomb")
        file.metadata("run", {"format": "2"})
        file.attachment(0, "scene.yaml", "text/yaml", b"1234567890")
        file.finish()
    data = path.read_bytes()
    length = struct.pack("<Q", 10)
    path.write_bytes(data.replace(length + b"1234567890", struct.pack("<Q", claim) + b"1234567890"))


CRAFTED: dict[str, Callable[[Path], None]] = {
    "a chunk that says little": lambda path: bombs(path, 3, 1000, None, bomb()),
    "a chunk that says much": lambda path: bombs(path, 3, 1000, BIG, bomb()),
    "an index that says much": lambda path: bombs(path, 3, BIG, 1000, bomb()),
    "a frame that says little": lambda path: bombs(path, 3, 1000, None, bomb(1000)),
    "a frame that does not say": lambda path: bombs(path, 3, 1000, None, bomb(None)),
    "a frame behind another": lambda path: bombs(path, 3, 1000, None, zstandard.compress(bytes(1000)) + bomb()),
    "a frame with the largest window": lambda path: bombs(
        path, 3, 1000, None, b"\x28\xb5\x2f\xfd\x40\xff\xe8\x02" + b"\x43\x1f\x00\x00"
    ),
    "an attachment that says much": lambda path: attached(path, 1 << 36),
    "an attachment that says too much": lambda path: attached(path, (1 << 64) - 1),
}


@pytest.mark.skipif(sys.platform != "linux", reason="watches processes in /proc, which only Linux has")
@pytest.mark.parametrize("kind", CRAFTED)
def test_a_decompression_bomb_uses_little_memory(kind: str, recorded: Path, tmp_path: Path) -> None:
    path = tmp_path / "bomb.mcap"
    CRAFTED[kind](path)
    peak_kB()
    before = peak_kB()
    for sentence in read_in_all_ways(path, recorded, tmp_path, pictures=False):
        assert "\n" not in sentence
    assert peak_kB() - before < BIG >> 12  # a quarter of it


def test_deeply_nested_text_does_not_exhaust_the_stack(tmp_path: Path) -> None:
    path = tmp_path / "deep.mcap"
    with path.open("wb") as stream:
        file = McapFile(stream, "deep")
        file.metadata("run", {"format": "2", "rated": "[" * 200_000})
        schema = file.schema("x", "jsonschema", b"{}")
        channel = file.channel("/west/report", "json", schema, {"model": "west", "port": "report"})
        file.write(channel, 0, 0, b'{"value":' + b"[" * 200_000)
        file.finish()
    with pytest.raises(RecordingError, match="is damaged"):
        Recording(path).events()
    read_in_all_ways(path, path, tmp_path)


def test_a_recorded_number_too_large_to_draw_is_reported_as_damaged_content(
    begin: Callable[[], Recorder], rows: NDArray[np.float64], tmp_path: Path
) -> None:
    rows[3, 0] = -1e200
    with begin() as rec:
        rec.samples(msgspec.msgpack.encode([0, TIMES, rows.tobytes()]))
    whole = tmp_path / "run.mcap"
    # in newtons or kilonewtons
    too_large = r"run\.mcap: has contents that no run writes \(the number 1e\+(200|197) is too large to be drawn\)"
    with pytest.raises(RecordingError, match=too_large):
        content(Recording(whole))
    with pytest.raises(RecordingError, match=too_large):
        curves(whole, ["rope/*"], tmp_path / "x.html")
