"""Finds processes and private directories of a case that still exist after it."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path

SOON_s = 20.0  # in which what a run leaves behind goes
MARK = "HEAVYLIFT_CASE"  # in the environment of all processes of a case: its folder


def state(pid: int) -> str:
    """The letter of a process, as `ps` prints it; "" if it is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return ""


def processes(folder: Path) -> list[int]:
    """Processes of the case in this folder that are still there."""
    return [pid for pid, environment in _all() if f"{MARK}={folder}\0".encode() in environment]


def left(folder: Path, temporary: Path) -> list[str]:
    """What is still there of the runs of a case, after a while in which it may go."""
    until = time.monotonic() + SOON_s
    while (found := [*map(_told, processes(folder)), *_folders(temporary)]) and (time.monotonic() < until):
        time.sleep(0.05)
    return found


def _folders(temporary: Path) -> list[str]:
    return [str(path) for path in temporary.glob("*heavylift-*") if path.is_dir()]


def _told(pid: int) -> str:
    try:
        return f"process {pid} ({Path(f'/proc/{pid}/comm').read_text().strip()}, {state(pid)})"
    except OSError:
        return f"process {pid}"


def _all() -> Iterator[tuple[int, bytes]]:
    for entry in os.listdir("/proc"):
        if entry.isdigit() and int(entry) != os.getpid() and state(int(entry)) not in ("", "Z"):
            try:
                yield int(entry), Path(f"/proc/{entry}/environ").read_bytes()
            except OSError:
                continue
