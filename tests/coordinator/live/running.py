"""Runs of the command `heavylift` that go on while a test looks at them."""

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from heavylift.coordinator.live import AnnouncedRun, running

HEAVYLIFT = Path(sys.executable).parent / "heavylift"
PATIENCE_s = 60.0


def command(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    """The command in a folder, its output in pipes."""
    pipe = subprocess.PIPE
    return subprocess.Popen([HEAVYLIFT, *arguments], cwd=folder, stdout=pipe, stderr=pipe, text=True)


def said(folder: Path, *arguments: str) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of the whole command."""
    with command(folder, *arguments) as process:
        out, err = process.communicate(timeout=PATIENCE_s)
    return process.returncode, out, err


def found(recording: Path) -> AnnouncedRun:
    """The run that writes this recording, as soon as it can be found."""
    deadline = time.monotonic() + PATIENCE_s
    while time.monotonic() < deadline:
        for run in running():
            if run.notice.recording == str(recording):
                return run
        time.sleep(0.01)
    raise AssertionError(f"no run writes {recording}")


@contextmanager
def going(folder: Path, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A command that is killed if the test ends before it does."""
    process = command(folder, *arguments)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()
