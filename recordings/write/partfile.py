"""The file under construction: without name until it is worth keeping, `PATH.part` while a run writes it, renamed when
it is complete.

So a file with its final name is always complete, two runs cannot write into one file, and no existing file is lost:
names are given by system calls that never replace a file (outputs.py has the rule). Changes by others are detected: a
name that points elsewhere, a size other than written, and, if another program has written to the file, other bytes.
"""

import ctypes
import errno
import fcntl
import io
import os
import secrets
import zlib
from collections.abc import Sequence
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from typing import Any

from heavylift.kernel.errors import OutputError, RecordingError

from .outputs import PART, left_by_a_run, names, output_path, remains, writing

AT_FDCWD, RENAME_NOREPLACE = -100, 1  # of linux/fcntl.h and linux/fs.h
OPENED = "/proc/self/fd"  # where Linux has names for open files
BLOCK = 1 << 20  # [bytes] read at once


class PartFile(AbstractContextManager["PartFile"]):
    """A file under construction: `stream` writes to it, `show()` or `finish()` gives it a name; `path`: its final name.

    If `force`, an earlier output of heavylift with this name is replaced; otherwise the next free name is used. As a
    context manager it finishes the file at its end, or leaves no file if the body raises.
    """

    def __init__(
        self, path: str | Path, what: str = "a recording", endings: Sequence[str] = (".mcap",), force: bool = False
    ) -> None:
        self.path = output_path(path, what, endings)
        self._force, self._finished = force, False
        self._at: Path | None = None
        with self.writing():
            self._at, descriptor = _unnamed(self.path)
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        self._raw = _Guarded(descriptor, self)
        self.stream = io.BufferedWriter(self._raw, 1 << 18)

    @property
    def part(self) -> Path:
        """Temporary path of the file until it is complete."""
        return self.path.with_name(self.path.name + PART)

    def writing(self) -> AbstractContextManager[None]:
        """Return a context that converts errors of the operating system into a RecordingError."""
        return writing(self._at or self.path)

    def show(self) -> None:
        """Give the temporary file, which has no name so far, the name `PATH.part` or the next free name."""
        with self.writing():
            self.stream.flush()
            for path in names(self.path):
                forced = self._force and path == self.path
                if forced:
                    self._clear()
                elif remains(path):
                    continue
                part = path.with_name(path.name + PART)
                try:
                    self._name(part)
                except FileExistsError:
                    if forced:
                        raise _written(part) from None
                    continue
                self.path = path
                return

    def check(self, whole: bool = False) -> None:
        """Raise RecordingError if another program deleted, replaced or changed the file; `whole`: compare all bytes."""
        if self._at is not None:
            try:
                there = os.stat(self._at, follow_symlinks=False)
            except FileNotFoundError:
                raise self._lost("deleted or renamed") from None
            if not os.path.samestat(os.fstat(self._raw.fileno()), there):
                raise self._lost("replaced by another file")
        self._raw.check(whole)

    def finish(self) -> Path:
        """Close the file and give it its final name while it is still locked; return its path."""
        with self.writing():
            self.stream.flush()
            self.check(whole=True)
            if self._force and os.path.lexists(self.path):
                output_path(self.path)  # still nothing but an earlier output
                if self._at is None:
                    self._name(_beside(self.path))
                assert self._at is not None
                os.replace(self._at, self.path)
            else:
                self._name_free()
            self._at, self._finished = self.path, True
            self.stream.close()
        return self.path

    def abandon(self, keep: bool = True) -> None:
        """Close a file that cannot be finished; `keep`: do not delete the incomplete file."""
        with suppress(OSError, RecordingError):
            self.stream.close()
        with suppress(OSError):
            self._raw.close()
        if self._at is not None and not keep and not self._finished:
            self._at.unlink(missing_ok=True)

    def _name_free(self) -> None:
        """Give the file the intended name, or the next free one if another file has taken it."""
        for path in names(self.path):
            if path != self.path and remains(path):
                continue
            try:
                self._name(path)
            except FileExistsError:
                continue
            self.path = path
            return

    def _name(self, path: Path) -> None:
        """Give the file a name; raises FileExistsError if the name is taken."""
        if self._at is None:  # with a descriptor of a folder `link` is `linkat`, which follows the name of an open file
            opened = f"{OPENED}/{self._raw.fileno()}"
            os.link(opened, path, src_dir_fd=self._raw.fileno(), follow_symlinks=True)
        else:
            _rename(self._at, path)
        self._at = path

    def _clear(self) -> None:
        """Remove the remains of a run of this name, unless they are being written or can be resumed."""
        for path in remains(self.path):
            if path == self.path:
                continue
            file = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if path.suffix == PART and left_by_a_run(path):
                    raise OutputError(
                        f"{path}: this file was left by a run that was cut off and will not be "
                        f"overwritten; `heavylift resume {path}` completes "
                        "that run, `heavylift recover` saves what can be read; then delete it, or choose another name "
                        "with -o"
                    )
                path.unlink()
            except BlockingIOError:
                raise _written(path) from None
            finally:
                os.close(file)

    def _lost(self, how: str) -> RecordingError:
        return RecordingError(
            f"{self._at or self.path}: was {how} while it was written; leave the file alone until it is complete, and "
            "start again"
        )

    def __exit__(self, kind: object, *_: object) -> None:
        try:
            if kind is None:
                self.finish()
        finally:
            self.abandon(keep=False)


def written(data: str | bytes, path: str | Path, what: str, endings: Sequence[str], force: bool = False) -> Path:
    """Write data to a complete file and return its path."""
    with PartFile(path, what, endings, force) as file:
        file.stream.write(data.encode() if isinstance(data, str) else data)
    return file.path


class _Guarded(io.FileIO):
    """A file that must contain exactly the bytes written here."""

    def __init__(self, descriptor: int, owner: PartFile) -> None:
        super().__init__(descriptor, "wb")
        self._owner, self._size, self._crc = owner, 0, 0
        self._written_ns = os.fstat(descriptor).st_mtime_ns

    def write(self, data: Any) -> int:
        """Append data to the incomplete file; raises RecordingError if another program has changed the file."""
        self.check()
        n = super().write(data)
        self._crc = zlib.crc32(memoryview(data)[:n], self._crc)
        self._size += n
        self._written_ns = os.fstat(self.fileno()).st_mtime_ns
        return n

    def check(self, whole: bool = False) -> None:
        """Raise RecordingError if another program has changed the file.

        All bytes are compared only if `whole` or if size or time of the file have changed.
        """
        now = os.fstat(self.fileno())
        if now.st_size < self._size:
            raise self._owner._lost("cut")
        if whole or now.st_mtime_ns != self._written_ns or now.st_size != self._size:
            if now.st_size != self._size or self._read() != self._crc:
                raise self._owner._lost("changed by another program")
            self._written_ns = now.st_mtime_ns

    def _read(self) -> int:
        crc = place = 0
        while place < self._size and (data := os.pread(self.fileno(), BLOCK, place)):
            crc, place = zlib.crc32(data, crc), place + len(data)
        return crc


def _written(part: Path) -> OutputError:
    return OutputError(f"{part}: another run is writing this file; wait for it or choose another name with -o")


def _unnamed(path: Path) -> tuple[Path | None, int]:
    """Create a new file in the folder of this path: without name if possible, else with a unique one."""
    if hasattr(os, "O_TMPFILE") and os.path.isdir(OPENED):
        try:
            return None, os.open(path.parent, os.O_RDWR | os.O_TMPFILE | os.O_CLOEXEC, 0o644)
        except OSError as error:
            if error.errno not in (errno.EOPNOTSUPP, errno.EISDIR, errno.ENOENT, errno.EINVAL):
                raise
    at = _beside(path)
    return at, os.open(at, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o644)


def _beside(path: Path) -> Path:
    return path.with_name(f".{secrets.token_hex(6)}{PART}")


def _rename(old: Path, new: Path) -> None:
    """Rename a file; raises FileExistsError if the new name is taken."""
    if rename := getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None):
        if not rename(AT_FDCWD, os.fsencode(old), AT_FDCWD, os.fsencode(new), RENAME_NOREPLACE):
            return
        if (code := ctypes.get_errno()) not in (errno.EINVAL, errno.ENOSYS):  # a file system that cannot do it
            raise OSError(code, os.strerror(code), str(new))
    if os.path.lexists(new):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(new))
    os.rename(old, new)
