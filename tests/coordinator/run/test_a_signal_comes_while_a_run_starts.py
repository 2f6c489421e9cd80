"""Wherever the start of a run in processes is when a signal comes: no folder and no process is left of it."""

import json
import os
import re
import signal
import subprocess
import sys
import sysconfig
import time
from contextlib import suppress
from pathlib import Path
from random import Random

import heavylift
import pytest
from command import PATIENCE_s
from heavylift import kernel

POINTS = 40  # of each signal
STARTED = """
import os, signal, subprocess, sys, tempfile
from pathlib import Path
from heavylift.coordinator import cli
from heavylift.coordinator.run import conversation, models
from heavylift.coordinator.supervision import processes, failover as succession
from heavylift.coordinator.transport import exchange, hub, liveness as lookout, session

OURS = exchange, hub, conversation, lookout, processes, session, succession
LOOKED_AT = {module.__file__ for module in (*OURS, subprocess, tempfile)}
number, point = int(sys.argv[1]), sys.argv[2]
seen = {}  # lines, in the order in which they are reached
original_greet = models._greet


def strike():
    global point
    sys.settrace(None)
    point = ""
    signal.raise_signal(number)


def here(frame, event, argument):
    line = f"{frame.f_code.co_filename}:{frame.f_lineno}"
    if event == "line" and line not in seen:
        seen[line] = None
        if line == point:
            strike()
    return here


def greet(*arguments):
    original_greet(*arguments)
    sys.settrace(None)
    if point == "look":
        Path("lines").write_text("\\n".join(seen))
    elif point:
        strike()  # this start went another way


models._greet = greet
sys.argv = ["heavylift", "devs", "heavylift.nodes.zoo.token_ring:ring(2, 1, 500)", "--until", "1 ms"]
sys.settrace(lambda frame, event, argument: here if frame.f_code.co_filename in LOOKED_AT else None)
cli.main()
"""


def started(folder: Path, number: int, point: str) -> tuple[int, str]:
    """Exit code and standard error of a run that gets the signal at this line of its start, or tells all lines."""
    (folder / "tmp").mkdir(parents=True)
    (folder / "started.py").write_text(STARTED)
    done = subprocess.run(
        [sys.executable, "started.py", str(int(number)), point],
        cwd=folder,
        env={**os.environ, "TMPDIR": str(folder / "tmp"), "PYTHONHASHSEED": "0"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        timeout=PATIENCE_s,
    )
    return done.returncode, done.stderr


def left(folder: Path) -> list[str]:
    """What is there of the run: processes that have its folder in their environment, and files."""
    found = [str(path) for path in (folder / "tmp").iterdir()]
    for process in Path("/proc").iterdir():
        with suppress(OSError):
            if process.name.isdigit() and f"TMPDIR={folder / 'tmp'}".encode() in (process / "environ").read_bytes():
                found.append((process / "cmdline").read_text()[:200])
    return found


@pytest.fixture(scope="module")
def lines(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """The lines of a start, until all have joined."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    assert started(folder, signal.SIGTERM, "look") == (0, "")
    return (folder / "lines").read_text().splitlines()


CASES = [(number, i) for i in range(POINTS) for number in (signal.SIGINT, signal.SIGTERM)]


@pytest.mark.parametrize(("number", "case"), CASES, ids=[f"{number.name}-{i}" for number, i in CASES])
@pytest.mark.large(beyond=1)
def test_an_interrupt_during_the_start_of_a_run_leaves_no_files_behind(
    number: signal.Signals, case: int, lines: list[str], tmp_path: Path
) -> None:
    point = Random(f"{number.name} {case}").choice(lines)
    code, error = started(tmp_path / "run", number, point)
    assert (code, "Traceback" in error) == (128 + number, False), f"at {point}: {error}"
    deadline = time.monotonic() + PATIENCE_s
    while left(tmp_path / "run") and time.monotonic() < deadline:
        time.sleep(0.02)
    assert left(tmp_path / "run") == [], f"at {point}"


FIRST = """
import json, os, sys
import _signal
before = set(sys.modules)


def held(*arguments):
    print(json.dumps(sorted(set(sys.modules) - before)), flush=True)
    os._exit(0)


_signal.pthread_sigmask = held
from heavylift.coordinator.cli import main
main()
"""


def fresh() -> dict[str, str]:
    """An environment in which the command starts itself again."""
    return {k: v for k, v in os.environ.items() if k not in ("PYTHONHASHSEED", "PYTHONUTF8")}


def test_interrupt_signals_are_deferred_before_most_imports_of_a_command() -> None:
    done = subprocess.run([sys.executable, "-c", FIRST], env=fresh(), stdout=subprocess.PIPE, text=True, check=True)
    assert json.loads(done.stdout) == ["heavylift", "heavylift.coordinator", "heavylift.coordinator.cli"]


APART_s, CLEAN, MOST = 0.004, 12, 400  # moments; so many clean ends in a row are enough; moments at most
ROOMS = ("coordinator", "kernel", "nodes", "recordings")


@pytest.mark.large(beyond=1)
def test_an_early_ctrl_c_ends_the_command_with_one_line_of_heavylift_or_an_error_of_python_itself(
    tmp_path: Path,
) -> None:
    """Before our first line, Python dies of the signal in silence, or prints a traceback of its own files alone."""
    ours = [Path(heavylift.__file__), *(Path(kernel.__file__).parents[1] / room for room in ROOMS)]
    script = Path(sysconfig.get_path("scripts")) / "heavylift"
    clean = i = 0
    while clean < CLEAN and (i := i + 1) < MOST:
        command = [sys.executable, str(script), "run", "pendulum", "-o", f"{i}.mcap"]
        with subprocess.Popen(
            command, cwd=tmp_path, env=fresh(), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        ) as run:
            time.sleep(APART_s * i)
            run.send_signal(signal.SIGINT)
            _, error = run.communicate(timeout=PATIENCE_s)
        if (run.returncode, error) == (130, "heavylift: stopped\n"):
            clean += 1
            continue
        clean = 0
        named = [Path(name) for name in re.findall(r'File "(/[^"]*)"', error)]
        assert not [x for x in named for y in ours if x.is_relative_to(y)], error
        assert not error or "Traceback" in error, error
    assert clean == CLEAN
