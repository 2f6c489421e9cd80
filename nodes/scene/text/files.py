"""How a scene's files are read: regular files of bounded size, those that a scene names from its own folder only."""

from __future__ import annotations

import os
import stat
from itertools import count
from pathlib import Path

LARGEST = 1 << 19  # of a scene [bytes]
_named = count()


def content(path: Path, most: int = LARGEST) -> bytes:
    """All that a file holds; OSError, with a sentence as `strerror`, if it is no regular file or holds more."""
    with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise OSError(0, "it is a pipe or a device, no file")
        data = file.read(most + 1)
    if len(data) > most:
        raise OSError(0, f"it has more than {most} bytes")
    return data


def within(root: Path, path: Path) -> Path:
    """What a path leads to; ValueError if that is outside of the folder `root` or cannot be said."""
    next(_named)
    try:
        found = path.resolve()
        if found.is_relative_to(root.resolve()):
            return found
    except (OSError, RuntimeError, ValueError):
        raise ValueError("this is no path of a file") from None
    raise ValueError(f"{path.name!r} is outside of the scene's folder, whose files alone it may use; copy it there")


def named_so_far() -> str:
    """Changes whenever a scene leads to another file."""
    return repr(_named)
