"""Starts a command under other conditions: on a file system of its own, or with fewer resources."""

from __future__ import annotations

import resource
import shlex
import subprocess
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path


@cache
def namespaces() -> bool:
    """Whether this user may have a file system of its own here."""
    try:
        tried = ["unshare", "--map-root-user", "--mount", "mount", "-t", "tmpfs", "none", "/mnt"]
        return subprocess.run(tried, capture_output=True, timeout=10, check=False).returncode == 0
    except FileNotFoundError:
        return False


def mounted(at: Path, options: str, command: Sequence[object], keep: Path | None = None) -> list[str]:
    """The command with a file system of its own `at` a folder, whose files are copied to `keep` at the end."""
    words = shlex.join(map(str, command))
    place = shlex.quote(str(at))
    script = f"mount -t tmpfs -o {options} none {place} || exit 125\n{words}\ncode=$?\n"
    if keep is not None:
        script += f"cp {place}/*.mcap* {shlex.quote(str(keep))}/ 2>/dev/null\n"
    return ["unshare", "--map-root-user", "--mount", "sh", "-c", f"{script}exit $code"]


def limited(what: int, most: int) -> Callable[[], None]:
    """For `preexec_fn`: a limit of the system."""
    return lambda: resource.setrlimit(what, (most, most))
