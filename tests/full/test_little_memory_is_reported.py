"""A run without enough memory ends in one sentence, or completes; no process of it remains."""

from __future__ import annotations

import errno
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from heavylift.coordinator.transport import RunDirectory
from heavylift.kernel import out_of_memory

HEAVYLIFT = Path(sys.executable).with_name("heavylift")
MB = 1 << 20
RUNS = ("run pendulum -o x.mcap --deadline 5s", "run lift --set end=3s -o x.mcap --deadline 5s")
LIMITS = (64, 128, *range(200, 1000, 50))  # MB


def test_errors_caused_by_a_lack_of_memory_are_recognised() -> None:
    unmapped = "libscipy_openblas.so: failed to map segment from shared object"
    hidden = OSError("Could not find/load shared object file 'libllvmlite.so'")
    hidden.__context__ = OSError(unmapped)
    thread = RuntimeError("can't start new thread")
    for lack in (MemoryError(), ImportError(unmapped), hidden, OSError(errno.ENOMEM, "Cannot allocate memory"), thread):
        assert out_of_memory(lack)
    circle = ValueError("raised from itself")
    circle.__cause__ = circle
    for other in (circle, ImportError("no module"), OSError(errno.ENOSPC, "No space left on device"), KeyError("x")):
        assert not out_of_memory(other)


@pytest.mark.large
@pytest.mark.parametrize("line", [*RUNS, *(f"{line} --in-process" for line in RUNS)])
@pytest.mark.parametrize("limit_MB", LIMITS)
def test_a_run_without_enough_memory_ends_with_one_sentence(tmp_path: Path, line: str, limit_MB: int) -> None:
    def bounded() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (limit_MB * MB, limit_MB * MB))

    ended = subprocess.run(
        [HEAVYLIFT, *line.split()],
        cwd=tmp_path,
        env={**os.environ, "TMPDIR": str(tmp_path)},
        preexec_fn=bounded,
        capture_output=True,
        text=True,
        timeout=120.0,
    )
    assert "internal error" not in ended.stderr
    assert "Traceback" not in ended.stderr
    assert ended.returncode == 0 or ended.stderr.splitlines()[-1].startswith("heavylift: ")
    RunDirectory(tmp_path / "heavylift-0123abcd").make().remove()  # sweeps, should even the keeper have been lost
    assert {path.name for path in tmp_path.iterdir()} <= {"x.mcap", "x.mcap.part"}
