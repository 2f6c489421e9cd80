"""The file under construction: `<name>.part`, locked by its run, renamed when it is finished.

So a file that bears its final name is always whole, and two runs cannot write into one another.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from heavylift.kernel.errors import RecordingError

__all__ = ["PartFile", "beside", "file_path", "output_path", "writing"]


def file_path(path: object) -> Path:
    """The path of what names a file: text or a Path; RecordingError for anything else."""
    named = os.fspath(path) if isinstance(path, str | os.PathLike) else b""
    if isinstance(named, bytes) or "\0" in named:
        raise RecordingError(f"{path!r} names no file; give its path as text or as a Path, such as 'run.mcap'")
    return Path(named)


def output_path(path: str | Path, what: str = "", endings: Sequence[str] = ()) -> Path:
    """The path if a file can have it, else a RecordingError: it is a folder, its folder is missing, or it has none of
    the endings of what is written, so that no table or picture is written over a recording.
    """
    path = file_path(path)
    if path.is_dir():
        raise RecordingError(f"{path}: is a folder; give the name of a file in it, such as {path / 'run.mcap'}")
    if not path.parent.is_dir():
        raise RecordingError(
            f"{path}: the folder {path.parent} does not exist; make it or choose another place with -o"
        )
    if endings and path.suffix.lower() not in endings:
        these = f"{', '.join(endings[:-1])} or {endings[-1]}" if len(endings) > 1 else endings[0]
        give = "one of these endings" if len(endings) > 1 else "this ending"
        raise RecordingError(f"{path}: {what} is written as {these}; give it {give}")
    return path


def beside(path: Path, ending: str) -> Path:
    """The file that is made of this one if no other name is given: run.mcap and -report.html give run-report.html."""
    return path.parent / f"{path.stem}{ending}"


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turns the system's refusals into a sentence about this file."""
    try:
        yield
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written ({error.strerror}); choose another place with -o") from None


class PartFile:
    """`stream` writes to `<path>.part`; `finish()` gives the file its name."""

    def __init__(self, path: str | Path) -> None:
        self.path = output_path(path)
        self.part = self.path.with_name(self.path.name + ".part")
        with self.writing():
            descriptor = os.open(self.part, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            mine = os.path.samestat(os.fstat(descriptor), os.stat(self.part))  # not just renamed by its run
        except OSError:
            mine = False
        if not mine:
            os.close(descriptor)
            raise RecordingError(
                f"{self.part}: another run is writing this file; wait for it or choose another name with -o"
            )
        with self.writing():
            os.ftruncate(descriptor, 0)
        self.stream: BinaryIO = open(descriptor, "wb", buffering=1 << 18)  # noqa: SIM115 - closed by finish()

    def writing(self) -> AbstractContextManager[None]:
        """Turns the system's refusals into a sentence."""
        return writing(self.part)

    def finish(self) -> Path:
        """Close the file and give it its final name."""
        with self.writing():
            self.stream.flush()
            os.replace(self.part, self.path)  # while still locked
            self.stream.close()
        return self.path

    def abandon(self) -> None:
        """Close what cannot be finished; the part stays for whoever wants to read it."""
        with suppress(OSError):
            self.stream.close()
