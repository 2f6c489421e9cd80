"""File cache of machine code, modes, equilibrium paths, plans and modelling decisions; used only if no other user can
write to it.

The folder belongs to this user, has mode 0700 and is not a link; a file in it is regular and belongs to this user.
Otherwise the cache counts as empty. Files appear by atomic rename and begin with a checksum, which detects damage, not
forgery; a damaged one is replaced.

The size is bounded: a process that has written much removes the entries that have been unused for longest. Any number
of processes may read, write and remove at once: a file being read stays readable, a folder in use is locked and stays.
"""

import fcntl
import hashlib
import math
import os
import re
import shutil
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple, TypeVar
from uuid import uuid4

import msgspec

from .errors import OutputError
from .trust import others_write

T = TypeVar("T")

CHECKSUM = 32  # bytes of a SHA-256
MOST = 1 << 28  # of a file [bytes]
USUAL_MB = 512.0  # of all that is kept
CHECK_EVERY, LEFT = 1 / 32, 0.8  # of the bound: what a process writes before it looks again; what is left of too much
BLOCK = 4096  # that the smallest file takes [bytes]
OURS = re.compile(r"[0-9a-f]{64}\.[a-z]+(\.\d+)?|(fmu|gone)-[0-9a-f]{32}(-[0-9a-f]{32})?")  # all else is of others
ONLY_THERE = os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC  # no link, and no waiting for the other end of a pipe
_unseen = math.inf  # bytes that this process has written since it looked what there is


def cache_folder() -> Path:
    """Return the cache folder: $HEAVYLIFT_CACHE if set, otherwise a folder in the user's cache directory."""
    if own := os.environ.get("HEAVYLIFT_CACHE"):
        return Path(own).expanduser()
    from platformdirs import user_cache_path

    return user_cache_path("heavylift")


def cache_bound() -> int:
    """Return the maximum size of the cache [bytes]: $HEAVYLIFT_CACHE_MB if set, otherwise 512 MB; raises OutputError
    for an invalid value."""
    given = os.environ.get("HEAVYLIFT_CACHE_MB", "")
    try:
        megabytes = float(given or USUAL_MB)
    except ValueError:
        megabytes = math.nan
    if not 0.0 <= megabytes < math.inf:
        raise OutputError(f"HEAVYLIFT_CACHE_MB={given!r} is not a valid size; give megabytes, such as 512, or unset it")
    return int(megabytes * 1e6)


def unsafe_cache() -> str:
    """Return why the cache cannot be used, with the remedy; "" if it can be used."""
    try:
        with _opened():
            return ""
    except OSError as error:
        return f"cannot be used ({error.strerror})" if error.errno else str(error.strerror)


def read_cached(name: str) -> bytes:
    """Return the content of a cache file; empty if the file is missing or damaged or the cache is unsafe."""
    try:
        with _opened() as folder, open(os.open(name, os.O_RDONLY | ONLY_THERE, dir_fd=folder), "rb") as file:
            found = os.fstat(file.fileno())
            safe = stat.S_ISREG(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022
            whole = file.read() if safe and found.st_size <= MOST else b""
            with suppress(OSError):
                os.utime(file.fileno())  # used now
    except OSError:
        return b""
    checksum, content = whole[:CHECKSUM], whole[CHECKSUM:]
    return content if checksum == hashlib.sha256(content).digest() else b""


def write_cached(name: str, content: bytes) -> None:
    """Write a cache file atomically; failures are ignored."""
    global _unseen
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
    _unseen += max(len(content), BLOCK)
    if _unseen > CHECK_EVERY * cache_bound():
        prune_cache()


def kept_folder(name: str, fill: Callable[[Path], object]) -> Path:
    """Return the path of a cache folder, filled by `fill` if missing and protected while this process runs."""
    there = cache_folder() / name
    while True:
        try:
            held = _held(there)
        except FileNotFoundError:
            _filled(there, fill)
            continue
        with suppress(FileNotFoundError):
            if os.path.samestat(os.stat(there), os.fstat(held)):
                os.utime(held)
                prune_cache()
                return there
        os.close(held)  # let go of by another process just now


def _held(folder: Path) -> int:
    """Open a folder with a shared lock, so that no process removes it; return the descriptor."""
    held = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | ONLY_THERE)
    fcntl.flock(held, fcntl.LOCK_SH)
    return held


def _filled(there: Path, fill: Callable[[Path], object]) -> None:
    fresh = there.with_name(f"{there.name}-{uuid4().hex}")
    fresh.mkdir(mode=0o700)
    held = _held(fresh)
    try:
        fill(fresh)
        try:
            os.rename(fresh, there)
        except OSError:
            if not there.is_dir():  # no other process was quicker
                raise
    finally:
        os.close(held)
        shutil.rmtree(fresh, ignore_errors=True)


class CacheEntry(NamedTuple):
    """A file or folder of the cache: time of last use [ns], name, size on disk."""

    used_ns: int
    name: str
    size: int
    is_folder: bool


def kept() -> list[CacheEntry]:
    """Return all cache entries of heavylift, most recently used last; files of other programs are ignored."""
    found = []
    with suppress(OSError), _opened() as folder, os.scandir(folder) as entries:
        for entry in entries:
            with suppress(FileNotFoundError):
                if OURS.fullmatch(entry.name):
                    at, is_folder = entry.stat(follow_symlinks=False), entry.is_dir(follow_symlinks=False)
                    size = _size(folder, entry.name) if is_folder else at.st_size
                    found.append(CacheEntry(at.st_mtime_ns, entry.name, max(size, BLOCK), is_folder))
    return sorted(found)


def prune_cache(bound: int | None = None) -> int:
    """Remove the least recently used cache entries beyond `bound` [bytes]; return the number of bytes removed."""
    global _unseen
    _unseen, bound = 0.0, cache_bound() if bound is None else bound
    there = kept()
    whole = left = sum(x.size for x in there)
    with suppress(OSError), _opened() as folder:
        for x in there:
            if left <= (LEFT * bound if whole > bound else bound):
                break
            left -= x.size if _let_go(folder, x) else 0
    return whole - left


def _let_go(folder: int, x: CacheEntry) -> bool:
    """Remove a cache entry unless a process uses it; return whether it was removed."""
    try:
        if not x.is_folder:
            os.unlink(x.name, dir_fd=folder)
            return True
        held = os.open(x.name, os.O_RDONLY | os.O_DIRECTORY | ONLY_THERE, dir_fd=folder)
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
            gone = f"gone-{uuid4().hex}"
            os.rename(x.name, gone, src_dir_fd=folder, dst_dir_fd=folder)
            shutil.rmtree(gone, dir_fd=folder)
        finally:
            os.close(held)
    except FileNotFoundError:  # another process was quicker
        return True
    except OSError:
        return False
    return True


def _size(folder: int, name: str) -> int:
    """Return the total size on disk of all files in a folder of the cache [bytes]."""
    return sum(
        max(os.stat(file, dir_fd=at, follow_symlinks=False).st_size, BLOCK)
        for _, _, files, at in os.fwalk(name, dir_fd=folder)
        for file in files
    )


@cache
def sources() -> bytes:
    """Return the hash of all source files of the kernel."""
    return contents(Path(__file__).parent, ".py")


def contents(folder: Path, *endings: str) -> bytes:
    """Return a hash of the contents of all files below a folder that have one of these suffixes, sorted by path."""
    found = (f"{at}/{name}" for at, _, names in os.walk(folder) for name in names if name.endswith(endings))
    return hashlib.sha256(b"".join(Path(path).read_bytes() for path in sorted(found))).digest()


def remembered(name: str, kind: type[T], make: Callable[[], T]) -> T:
    """Return the cached data of type `kind` stored under `name`; compute and cache them by `make` if missing."""
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
    """Yield a descriptor of the cache folder, created if needed. Raises OSError with the reason in `strerror` if the
    folder is unsafe."""
    cache_bound()  # says so at once if it is none
    path = cache_folder()
    path.parent.mkdir(parents=True, exist_ok=True)
    with suppress(FileExistsError):
        path.mkdir(mode=0o700)
    if path.is_symlink():
        raise OSError(0, f"is a symbolic link to {path.resolve()}; use the target folder itself, or remove the link")
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
