"""Recordings spoiled in every way: bytes, lengths, whole records; also with checksums that hold nevertheless."""

from __future__ import annotations

import random
import signal
import struct
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import zstandard
from heavylift.kernel import RecordingError
from heavylift.recordings import (  # fmt: skip
    Recording,
    compare,
    curves,
    export,
    info,
    info_data,
    overlay,
    plot,
    recover,
    report,
    storyboard,
)
from heavylift.recordings.documents import facts, tables_of
from heavylift.recordings.render.view import content

PATIENCE_s = 20.0  # for all that is done with one file of a few kilobytes, but pictures
PICTURES_s = 100.0  # matplotlib takes its time, more so where others compute
CHUNK, MAGIC = 6, 8
FOOTER = 20 + 9 + MAGIC


class TooSlow(BaseException):
    """Reading took so long that people would think it hangs."""


@contextmanager
def patience(seconds: float) -> Iterator[None]:
    """Raises TooSlow when the body takes longer."""

    def ring(number: int, frame: FrameType | None) -> None:
        raise TooSlow(f"more than {seconds} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def spoiled(data: bytes, rng: random.Random) -> bytes:
    """One of many ways to spoil a file."""
    distances = (_bytes, _bytes, _cut, _moved, _numbers, _inside, _inside, _summary, _summary)
    return rng.choice(distances)(data, rng)


def _bytes(data: bytes, rng: random.Random) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 4, 40))):
        out[rng.randrange(len(out))] = rng.randrange(256)
    return bytes(out)


def _cut(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data))]


def _moved(data: bytes, rng: random.Random) -> bytes:
    """A piece left out, doubled, or put elsewhere."""
    a, b = sorted(rng.sample(range(len(data)), 2))
    b = min(b, a + 300)
    return rng.choice((data[:a] + data[b:], data[:b] + data[a:], data[:MAGIC] + data[a:b] + data[MAGIC:]))


def _numbers(data: bytes, rng: random.Random) -> bytes:
    """Numbers as they hurt: nothing, all bits, a little more than there is."""
    out = bytearray(data)
    place = rng.randrange(len(out) - 8)
    worst = rng.choice((0, 2**64 - 1, 2**63, 2**31, len(data) + 1, 1 << 40))
    struct.pack_into("<Q", out, place, worst)
    return bytes(out)


def _inside(data: bytes, rng: random.Random) -> bytes:
    """A chunk spoiled inside, packed again with a checksum that holds."""
    place, length = next((p, n) for opcode, p, n in records(data) if opcode == CHUNK)
    first, last, _, _, letters = struct.unpack_from("<QQQII", data, place + 9)
    at = place + 9 + 32 + letters
    (packed,) = struct.unpack_from("<Q", data, at)
    inner = zstandard.decompress(data[at + 8 : at + 8 + packed])
    inner = (_bytes if rng.random() < 0.7 else _numbers)(inner, rng)
    head = struct.pack("<QQQII", first, last, len(inner), zlib.crc32(inner), 4) + b"zstd"
    frame = zstandard.compress(inner)
    body = head + struct.pack("<Q", len(frame)) + frame
    if len(frame) != packed:  # places in the summary no longer hold, as after any edit: for `recover`
        return data[:place] + struct.pack("<BQ", CHUNK, len(body)) + body + data[place + 9 + length :]
    return data[: place + 9] + body + data[place + 9 + length :]


def _summary(data: bytes, rng: random.Random) -> bytes:
    """Summary and footer spoiled, with a checksum that holds."""
    start, offsets = struct.unpack_from("<QQ", data, len(data) - FOOTER + 9)
    summary = (_bytes if rng.random() < 0.6 else _numbers)(data[start : len(data) - FOOTER], rng)
    footer = struct.pack("<BQQQ", 2, 20, start, offsets)
    crc = zlib.crc32(footer, zlib.crc32(summary))
    return data[:start] + summary + footer + struct.pack("<I", crc) + data[-MAGIC:]


def records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """(opcode, place, length of the body) of the records of a whole file."""
    place = MAGIC
    while place < len(data) - MAGIC:
        opcode, length = struct.unpack_from("<BQ", data, place)
        yield opcode, place, length
        place += 9 + length


def read_in_all_ways(path: Path, whole: Path, folder: Path, pictures: bool = True) -> list[str]:
    """The sentences of all that reads a recording; anything but a RecordingError, and any hanging, is raised.

    Pictures take a hundred times as long as all the rest.
    """

    def everything() -> None:
        rec = Recording(path)
        rec.events()
        rec.load(rec.signals())
        rec._repr_html_()

    drawings: tuple[Callable[[], object], ...] = (
        lambda: plot(path, folder / "x.png"),
        lambda: storyboard(path, folder / "x.png"),
        lambda: curves(path, ["rope/*"], folder / "x.svg"),
        lambda: report(path, folder / "x.html"),
    )
    distances: tuple[Callable[[], object], ...] = (
        everything,
        lambda: info(path),
        lambda: info_data(path),
        lambda: export(path, folder / "x.csv"),
        lambda: compare(path, whole),
        lambda: content(Recording(path)),
        lambda: tables_of(facts(Recording(path))),
        lambda: curves(path, ["rope/*", "pose/block/?"], folder / "x.html"),
        lambda: overlay(path, whole, folder / "x.html"),
        lambda: recover(path, folder / "saved.mcap"),
        lambda: Recording(folder / "saved.mcap").events() if (folder / "saved.mcap").exists() else None,
        *(drawings if pictures else ()),
    )
    sentences = []
    with patience(PATIENCE_s + (PICTURES_s if pictures else 0.0)):
        for distance in distances:
            try:
                distance()
            except RecordingError as error:
                sentences.append(str(error))
    (folder / "saved.mcap").unlink(missing_ok=True)
    return sentences
