"""The digest of a run: SHA-256 over the sorted events, the sample rows and the notes of the sampler; identical runs
have identical digests.

Events are those on the ports of coupled models, keyed by (t, microstep, source path, port, index), with type and
canonical bytes. Rows are keyed by their number and are the recorded numbers of `/samples` and then of `/poses` (for a
single lift of `/samples/NAME` and `/poses/NAME`); notes are those of `/log`. So a reader of the file can compute the
digest again. The order in which data are added does not matter: events are sorted at the end, and of each row only a
hash is kept. The numbers of events and rows are hashed first, so all data wait for the end; data added in order, as in
any run, go to a temporary file once there is much of it. Attachments, facts and results derived from samples (verdicts,
clearances, collisions) are not part of the digest; no message contains a file name or a line number (DIGEST.md has the
table).

Also a temporary store for the waiting data of a long run: in memory while it is small, then in a file that is deleted
after the run.
"""

import hashlib
import struct
import tempfile
import weakref
from collections.abc import Iterator
from heapq import merge
from typing import Any

import msgspec
from heavylift.kernel.errors import RecordingError

IN_MEMORY = 1 << 20  # bytes; what is more goes into a file


class Spool:
    """Temporary storage to which data can only be appended; `what`: name of the data for error messages."""

    def __init__(self, what: str) -> None:
        self._file = tempfile.SpooledTemporaryFile(IN_MEMORY)  # noqa: SIM115 - closed with its last reference
        weakref.finalize(self, self._file.close)  # which Python would warn of
        self._what = what
        self._size, self._end = 0, True  # whether the file stands at its end

    def write(self, data: bytes) -> None:
        """Append data to the temporary storage; raises RecordingError if the disk is full."""
        try:
            if not self._end:
                self._file.seek(self._size)
                self._end = True
            self._file.write(data)
        except OSError as error:
            raise RecordingError(
                f"{tempfile.gettempdir()}: {self._what} cannot be written ({error.strerror}); make room or set TMPDIR"
            ) from None
        self._size += len(data)

    def read(self, size: int, at: int | None = None) -> bytes:
        """Read `size` bytes of the temporary storage from the position `at`; fewer bytes at the end of the data.

        `at` None: from the end of the last read.
        """
        self._end = False
        if at is not None:
            self._file.seek(at)
        return self._file.read(size)


_LENGTH = struct.Struct("<I")
_NUMBERS = struct.Struct("<qq")
_ROW = struct.Struct("<q32s")  # number and hash
_BLOCK = 4096  # rows that are read back at once


class Digest:
    """Digest of a run, computed step by step; events, samples and notes may be added in any order."""

    def __init__(self) -> None:
        self._events, self._rows = _Sorted(), _RowHashes()
        self._lifts: dict[str, _RowHashes] = {}
        self._notes: dict[int, bytes] = {}
        self._total = ""

    def event(self, t_ns: int, k: int, source: str, port: str, index: int, type: str, payload: bytes) -> None:
        """Add an event, given as canonical bytes, to the digest of the run."""
        self._total = ""
        self._events.add((t_ns, k, source, port, index, type, payload))

    def samples(self, number: int, t_ns: int, row: bytes, lift: str = "") -> None:
        """Add a sample row to the digest of the run: its number, simulation time [ns] and float64 bytes.

        `lift`: the single lift to which the row belongs, "" for rows of all lifts.
        """
        self._total = ""
        rows = self._lifts.setdefault(lift, _RowHashes()) if lift else self._rows
        rows.add(number, hashlib.sha256(_NUMBERS.pack(number, t_ns) + row).digest())

    def note(self, number: int, t_ns: int, sentence: str) -> None:
        """Add a note of the sampling node to the digest: its number, simulation time [ns] and sentence."""
        self._total = ""
        self._notes[number] = hashlib.sha256(msgspec.msgpack.encode((number, t_ns, sentence))).digest()

    def hexdigest(self) -> str:
        """Return the digest of everything added so far: its SHA-256 hash as hexadecimal text."""
        if self._total:
            return self._total
        total = hashlib.sha256(_NUMBERS.pack(self._events.count, self._rows.count))
        for event in self._events.all():
            total.update(msgspec.msgpack.encode(event))
        for _, row in self._rows.all():
            total.update(row)
        for lift, rows in sorted(self._lifts.items()):
            total.update(msgspec.msgpack.encode((lift, rows.count)))
            for _, row in rows.all():
                total.update(row)
        for number in sorted(self._notes):
            total.update(self._notes[number])
        self._total = total.hexdigest()
        return self._total


class _Sorted:
    """Sorted collection of tuples; tuples that are added in order are stored on disk."""

    def __init__(self) -> None:
        self._file = Spool("what the digest is made of")
        self._last: tuple[object, ...] = ()
        self._late: list[tuple[object, ...]] = []
        self.count = 0

    def add(self, entry: tuple[object, ...]) -> None:
        self.count += 1
        if entry < self._last:
            self._late.append(entry)
            return
        self._last = entry
        data = msgspec.msgpack.encode(entry)
        self._file.write(_LENGTH.pack(len(data)) + data)

    def all(self) -> Iterator[tuple[Any, ...]]:
        return merge(self._written(), sorted(self._late))

    def _written(self) -> Iterator[tuple[object, ...]]:
        head = self._file.read(_LENGTH.size, at=0)
        while head:
            yield msgspec.msgpack.decode(self._file.read(*_LENGTH.unpack(head)), type=tuple)
            head = self._file.read(_LENGTH.size)


class _RowHashes:
    """Hashes of rows by number; hashes that are added in order are stored on disk."""

    def __init__(self) -> None:
        self._file = Spool("what the digest is made of")
        self._last = -1
        self._late: list[tuple[int, bytes]] = []
        self.count = 0

    def add(self, number: int, row: bytes) -> None:
        self.count += 1
        if number < self._last:
            self._late.append((number, row))
            return
        self._last = number
        self._file.write(_ROW.pack(number, row))

    def all(self) -> Iterator[tuple[int, bytes]]:
        return merge(self._written(), sorted(self._late))

    def _written(self) -> Iterator[tuple[int, bytes]]:
        block = self._file.read(_BLOCK * _ROW.size, at=0)
        while block:
            yield from _ROW.iter_unpack(block)
            block = self._file.read(_BLOCK * _ROW.size)
