"""The files of a scene, its own or a bundled one, and safe reading of files.

Only regular files of limited size are read; files that a scene refers to must be in its own folder.
"""

import hashlib
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from heavylift.kernel.errors import SceneError, closest
from heavylift.nodes.scenes import bundled

MCAP = b"\x89MCAP0\r\n"  # how a recording begins
LARGEST = 1 << 19  # of a scene [bytes]
_named: ContextVar[dict[str, str] | None] = ContextVar("_named", default=None)


def content(path: Path, most: int = LARGEST) -> bytes:
    """Return the content of a file; raises OSError if it is not a regular file or larger than `most` bytes.

    The error has a sentence as `strerror`."""
    with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise OSError(0, "it is a pipe or a device, not a file")
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(0, f"it has more than {most} bytes")
    return data


def within(root: Path, path: Path) -> Path:
    """Return a path, resolved; raises ValueError if it is outside the folder `root` or has unprintable characters."""
    try:
        found = path.resolve()
        if found.is_relative_to(root.resolve()):
            if (named := _named.get()) is not None:
                named[str(found)] = state(str(found))
            return found
    except (OSError, RuntimeError, ValueError):
        raise ValueError("this is not a valid path of a file") from None
    raise ValueError(
        f"{path.name!r} is outside of the scene's folder, but a scene may use only files in its own folder; "
        "copy the file there"
    )


@contextmanager
def files_read() -> Iterator[dict[str, str]]:
    """Record in a dict the files that scenes read within this context, each with its hash before it is read."""
    named: dict[str, str] = {}
    token = _named.set(named)
    try:
        yield named
    finally:
        _named.reset(token)


def state(path: str) -> str:
    """Return a hash of the content of a file; "" if there is no file."""
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest() if Path(path).is_file() else ""
    except OSError:
        return ""


def scene_file(scene: str) -> Path:
    """Return the path of a scene file, or of the bundled scene with this name; raises SceneError if neither exists."""
    path = Path(scene)
    known = bundled()
    if path.is_file() or scene not in known:
        if not path.is_file() and not path.suffix and "/" not in scene and "\\" not in scene:
            message = f"there is no scene '{scene}', neither a file nor a bundled one: {closest(scene, known)}"
            raise SceneError(message)
        return path
    return known[scene]


def scene_text(path: Path, name: str) -> str:
    """Return the text of a scene file; raises SceneError if it cannot be read, for example if it is a recording."""
    try:
        return content(path).decode("utf-8")
    except FileNotFoundError:
        raise SceneError(f"there is no scene file '{name}'") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        if _is_recording(path):
            reason = (
                f"it is a recording, not a scene; `heavylift info {name}` lists its contents, `heavylift view` shows it"
            )
        raise SceneError(f"the scene file '{name}' cannot be read: {reason}") from None


def _is_recording(path: Path) -> bool:
    try:
        return path.is_file() and path.open("rb").read(len(MCAP)) == MCAP
    except OSError:
        return False
