"""Some random cases of each kind in `tests/full/fuzz.py`: each gives a result or an error sentence."""

import os
import signal
import sys
import time
from pathlib import Path
from random import Random
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "full"))
import fuzz as fuzz_module
from fuzz import fuzz, guarded
from fuzzed import KINDS

CASES = {"scenes": 15, "recordings": 3, "frames": 300, "commands": 500, "resume": 30}


@pytest.mark.parametrize("kind", KINDS)
def test_random_bytes_in_files_written_by_others_cause_no_crash_and_no_traceback(kind: str) -> None:
    result = fuzz(kind, seed=7, most=CASES[kind])
    assert (result.cases, dict(result.found)) == (CASES[kind], {})
    assert result.sentences or kind in ("frames", "recordings")


def broken(folder: Path) -> Any:
    """Cases that end in an exception, in a crash, in a hang, and well."""

    def draw(rng: Random) -> bytes:
        with (folder / "drawn").open("ab") as drawn:
            drawn.write(b"x")
        return b"%d" % (folder / "drawn").stat().st_size

    def play(case: bytes) -> None:
        if case == b"1":
            raise KeyError("no sentence")
        if case == b"2":
            os.kill(os.getpid(), signal.SIGKILL)
        if case == b"3":
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGALRM})  # as in code that never comes back to Python
            signal.pause()
        while case == b"4" and time.process_time() < until:
            pass

    until = time.process_time() + 0.1
    return draw, play


@pytest.mark.large
def test_the_fuzz_test_detects_an_input_that_crashes_native_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(KINDS, "broken", broken)
    monkeypatch.setattr(fuzz_module, "HARD_s", 3.0)
    result = guarded("broken", seed=1, cpu_s=0.1)
    assert result.cases == 4
    assert [(case, what.partition(" at ")[0]) for what, case in result.first.items()] == [
        (b"1", "KeyError"),
        (b"2", "end of the process with -9"),
        (b"3", "hang that no signal ends"),
    ]
