"""The private directory of a run, where its processes meet; it goes with the run, also if that is killed."""

import fcntl
import os
import secrets
import shutil
import tempfile
import weakref
from contextlib import suppress
from pathlib import Path
from typing import Self

from heavylift.kernel.errors import ProtocolError

from .frame import OBSERVER, OPERATOR

PREFIX = "heavylift-"  # of the private directory of a run
SOCKET_PATH_LIMIT = 104  # bytes with the closing zero: the smaller of Linux (108) and macOS (104)


class RunDirectory:
    """A directory of mode 0700 for one run: socket, guests' passwords, output of nodes.

    It is locked while its coordinator lives; what a killed one could not remove goes when the next run begins.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.socket = str(path / "hub.sock")
        self._lock = -1
        self._removal = weakref.finalize(self, _remove, path, os.getpid())  # a signal may come before anybody owns it

    @classmethod
    def chosen(cls) -> Self:
        """A new unique path; `make` creates the directory."""
        for place in places():
            path = Path(place) / f"{PREFIX}{secrets.token_hex(4)}"
            if len(os.fsencode(path / "hub.sock")) < SOCKET_PATH_LIMIT and os.access(place, os.W_OK | os.X_OK):
                return cls(path)
        raise ProtocolError(
            "no temporary directory is writable and short enough for a unix socket "
            f"({tempfile.gettempdir()} is not), set TMPDIR to a shorter path"
        )

    def make(self) -> Self:
        """Make the directory."""
        _sweep(self.path.parent)
        try:
            made = self.path.with_name(f".{self.path.name}")  # nobody sweeps it before it is locked
            os.mkdir(made, 0o700)
            self._lock = os.open(made, os.O_RDONLY | os.O_CLOEXEC)
            fcntl.flock(self._lock, fcntl.LOCK_EX)
            os.rename(made, self.path)
        except OSError as error:
            raise ProtocolError(
                f"{self.path}: the run's directory cannot be made ({error.strerror}); set TMPDIR to another place"
            ) from None
        return self

    def write(self, name: str, text: str) -> Path:
        """Write a file that only this user can read."""
        path = self.path / name
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def log(self, node: str) -> Path:
        """Path of the file for a node's standard output and error."""
        return self.path / f"{node}.log"

    def remove(self) -> None:
        """Delete the directory with its contents."""
        self._removal()
        lock, self._lock = self._lock, -1  # before it is closed: what a signal interrupts may come here again
        if lock >= 0:
            os.close(lock)


def _remove(path: Path, maker: int) -> None:
    if os.getpid() == maker:  # not a fork of it
        shutil.rmtree(path, ignore_errors=True)


def _sweep(place: Path) -> None:
    """Remove directories of killed runs of this user."""
    for left in place.glob(f"{PREFIX}{'[0-9a-f]' * 8}"):
        try:
            lock = os.open(left, os.O_RDONLY | os.O_NOFOLLOW | os.O_DIRECTORY | os.O_CLOEXEC)
        except OSError:
            continue
        with suppress(OSError):  # locked: it lives
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            names = set(os.listdir(lock))
            ours = "hub.sock" in names or names <= {"users", OBSERVER, OPERATOR}  # ended before it could listen
            if ours and os.fstat(lock).st_uid == os.getuid():
                shutil.rmtree(left, ignore_errors=True)
        os.close(lock)


def places() -> list[str]:
    """Folders for run directories, preferred one first."""
    return list(dict.fromkeys((tempfile.gettempdir(), os.environ.get("XDG_RUNTIME_DIR", "/tmp"), "/tmp")))
