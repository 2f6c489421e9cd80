"""Append-only file of entries that stays readable up to its last entry if the process is killed; ticket files.

    length | crc32 | entry      little-endian, 4 bytes each; one `write` of the system per `append` or `extend`

Entries appended by a killed process are already in the system's buffers; only a power failure can lose them, unless
`sync` has written them to the disk. `read` returns the complete entries and stops at the first that is cut or damaged,
since entries after it cannot be separated. A run keeps several journals, so that each can be replaced on its own.

NAME.ticket, for an externally started process, is in the folder where the run was started; only its user can read it. A
ticket left by a killed run is replaced; a file that is no ticket, or that of a run in progress, is kept.
"""

import os
import secrets
from collections.abc import Iterable, Iterator
from contextlib import closing
from io import FileIO
from pathlib import Path
from struct import Struct
from zlib import crc32

import msgspec
from heavylift.coordinator.transport.session import Ticket
from heavylift.kernel.errors import UNREADABLE, OutputError, RecordingError

_HEAD = Struct("<II")
SEED = 0x486C4A31  # so that noughts are no entry
LIMIT = 1 << 30  # bytes of an entry: a longer one is damage


class Journal:
    """Writer of a new journal at `path`; an older journal is replaced, unless `exclusive` makes that an error."""

    def __init__(self, path: Path, exclusive: bool = False) -> None:
        self.path = path
        try:
            self._file = _new(path, os.O_EXCL if exclusive else os.O_TRUNC)
        except OSError as error:
            raise self._refused(error) from None

    def append(self, entry: bytes, sync: bool = False) -> None:
        """Append an entry to the journal; with `sync` the entry is on disk before this returns."""
        self.extend((entry,))
        if sync:
            try:
                os.fsync(self._file.fileno())
            except OSError as error:
                raise self._refused(error) from None

    def extend(self, entries: Iterable[bytes]) -> None:
        """Append several entries to the journal in one write."""
        try:
            _write(self._file, b"".join(map(_framed, entries)))
        except OSError as error:
            raise self._refused(error) from None

    def restart(self, entries: Iterable[bytes]) -> None:
        """Replace all entries of the journal by new ones, atomically."""
        fresh = self.path.with_name(self.path.name + ".new")
        try:
            file = _new(fresh)
            _write(file, b"".join(_framed(entry) for entry in entries))
            os.replace(fresh, self.path)
        except OSError as error:
            raise self._refused(error) from None
        self._file, before = file, self._file  # at once: a signal may end the run before the next line
        before.close()

    def close(self) -> None:
        """Close the journal; the file stays."""
        self._file.close()

    def delete(self) -> None:
        """Delete the journal after the run has ended without failure."""
        self.close()
        self.path.unlink(missing_ok=True)

    def _refused(self, error: OSError) -> RecordingError:
        return RecordingError(
            f"{self.path}: the journal cannot be written ({error.strerror}); make room or choose another place"
        )


def read(path: Path) -> Iterator[bytes]:
    """Yield the complete entries of a journal in order; no entries if the file does not exist."""
    try:
        with closing(JournalReader(path)) as follower:
            yield from follower
    except FileNotFoundError:
        return


class JournalReader:
    """Reader of a growing journal: each iteration returns the complete entries added since the last one."""

    def __init__(self, path: Path) -> None:
        self._stream = path.open("rb")

    def __iter__(self) -> Iterator[bytes]:
        stream = self._stream
        while True:
            place = stream.tell()
            head = stream.read(_HEAD.size)
            length, crc = _HEAD.unpack(head) if len(head) == _HEAD.size else (LIMIT + 1, 0)
            entry = stream.read(length) if length <= LIMIT else b""
            if len(entry) < length or _check(length, entry) != crc:
                stream.seek(place)
                return
            yield entry

    def close(self) -> None:
        """Close the journal file."""
        self._stream.close()


def _new(path: Path, how: int = os.O_TRUNC) -> FileIO:
    return FileIO(path, "ab", opener=lambda name, flags: os.open(name, flags | how, 0o600))


def _write(file: FileIO, data: bytes) -> None:
    written = file.write(data)
    while written < len(data):  # a full disk says so at the next write
        written += file.write(data[written:])


def _framed(entry: bytes) -> bytes:
    return _HEAD.pack(len(entry), _check(len(entry), entry)) + entry


def _check(length: int, entry: bytes) -> int:
    return crc32(entry, SEED ^ length)


class TicketFile:
    """The file `NAME.ticket`, which an externally started process needs to join."""

    def __init__(self, process: str) -> None:
        self.path = Path.cwd() / f"{process}.ticket"
        self._ours = False

    def write(self, ticket: Ticket) -> None:
        """Write the ticket, replacing that of an earlier process; raises OutputError if another file has its name."""
        fresh = self.path.with_name(f".{self.path.name}-{secrets.token_hex(4)}")
        try:
            with open(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
                file.write(ticket.to_text())
            if self._ours or _abandoned(self.path):
                os.replace(fresh, self.path)
            else:
                os.link(fresh, self.path)
            self._ours = True
        except FileExistsError:
            message = "exists and is not the ticket of an ended run; move it, or run in another folder"
            raise OutputError(f"{self.path} {message}") from None
        except OSError as error:
            raise OutputError(f"{self.path}: a ticket cannot be written there ({error.strerror})") from None
        finally:
            fresh.unlink(missing_ok=True)

    def remove(self) -> None:
        """Delete the ticket file, so that no further process can join the run."""
        if self._ours:
            self.path.unlink(missing_ok=True)
            self._ours = False


def _abandoned(path: Path) -> bool:
    """Return whether the ticket belongs to a run that has ended."""
    try:
        return not Path(msgspec.json.decode(path.read_bytes(), type=Ticket).socket).exists()
    except (OSError, *UNREADABLE):
        return False
