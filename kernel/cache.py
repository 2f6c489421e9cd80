"""What was computed before, kept in files: machine code, modes, paths at rest, plans, what is modelled; used only if
this user alone can write it.

The folder is this user's own, with mode 0700, and no link; a file in it is regular and nobody else's.  Anything else is
passed over as if nothing were kept.  Files appear by atomic rename and begin with a checksum, which tells damage, not
forgery; a broken one is replaced.
"""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import TypeVar

import msgspec

from .trust import others_write

T = TypeVar("T")

CHECKSUM = 32  # bytes of a SHA-256
MOST = 1 << 28  # of a file [bytes]
ONLY_THERE = os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC  # no link, and no waiting for the other end of a pipe


def cache_folder() -> Path:
    """Where files are kept: $HEAVYLIFT_CACHE, else the user's cache folder."""
    own = os.environ.get("HEAVYLIFT_CACHE")
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(own).expanduser() if own else Path(base).expanduser() / "heavylift"


def unsafe_cache() -> str:
    """Why nothing is kept, with what to do about it; "" where the cache is used."""
    try:
        with _opened():
            return ""
    except OSError as error:
        return f"cannot be used ({error.strerror})" if error.errno else str(error.strerror)


def read_cached(name: str) -> bytes:
    """What a file of the cache holds, empty if there is none, or it is damaged or not safe."""
    try:
        with _opened() as folder, open(os.open(name, os.O_RDONLY | ONLY_THERE, dir_fd=folder), "rb") as file:
            found = os.fstat(file.fileno())
            safe = stat.S_ISREG(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022
            whole = file.read() if safe and found.st_size <= MOST else b""
    except OSError:
        return b""
    checksum, content = whole[:CHECKSUM], whole[CHECKSUM:]
    return content if checksum == hashlib.sha256(content).digest() else b""


def write_cached(name: str, content: bytes) -> None:
    """Atomic; a cache that cannot be written is no error, only slower starts."""
    part = f"{name}.{os.getpid()}"
    with suppress(OSError), _opened() as folder:
        try:
            how = os.O_WRONLY | os.O_CREAT | os.O_EXCL | ONLY_THERE
            with open(os.open(part, how, 0o600, dir_fd=folder), "wb") as file:
                file.write(hashlib.sha256(content).digest() + content)
            os.rename(part, name, src_dir_fd=folder, dst_dir_fd=folder)
        except OSError:
            with suppress(OSError):
                os.unlink(part, dir_fd=folder)


@cache
def sources() -> bytes:
    """All of the kernel that what is kept depends on, as it was when it was first asked for."""
    return contents(Path(__file__).parent, ".py")


def contents(folder: Path, *endings: str) -> bytes:
    """Of all files in a folder, and in those below, whose names end so; in the order of their paths."""
    found = (f"{at}/{name}" for at, _, names in os.walk(folder) for name in names if name.endswith(endings))
    return b"".join(Path(path).read_bytes() for path in sorted(found))


def remembered(name: str, kind: type[T], make: Callable[[], T]) -> T:
    """What `make` returns, plain data of a kind; from the cache if it was made before under this name."""
    if data := read_cached(name):
        try:
            return msgspec.msgpack.decode(data, type=kind)
        except msgspec.MsgspecError:
            pass
    found = make()
    write_cached(name, msgspec.msgpack.encode(found))
    return found


@contextmanager
def _opened() -> Iterator[int]:
    """A descriptor of the folder, which is made if need be; OSError, whose `strerror` tells why, if it is not safe."""
    path = cache_folder()
    path.parent.mkdir(parents=True, exist_ok=True)
    with suppress(FileExistsError):
        path.mkdir(mode=0o700)
    if path.is_symlink():
        raise OSError(0, f"is a link to {path.resolve()}; name that folder itself, or remove the link")
    folder = os.open(path, os.O_RDONLY | os.O_DIRECTORY | ONLY_THERE)
    try:
        found = os.fstat(folder)
        why = others_write(path, found) or ("" if found.st_uid == os.getuid() else "belongs to another user")
        if why:
            raise OSError(0, why)
        if found.st_mode & 0o077:
            os.fchmod(folder, 0o700)
        yield folder
    finally:
        os.close(folder)
