"""A service starts a run: standard streams closed, any locale, names that are no text, stopped before it is ready."""

import os
import signal
import subprocess
import sys
from itertools import combinations
from pathlib import Path
from random import Random

import pytest
from command import HEAVYLIFT, PATIENCE_s
from heavylift.nodes.scenes import bundled
from heavylift.recordings import Recording

SCENE = ("pendulum", "--set", "end=1 s")
CLOSED = [closed for n in (1, 2, 3) for closed in combinations((0, 1, 2), n)]
COMMANDS = {
    "processes": ("run", *SCENE),
    "in process": ("run", *SCENE, "--in-process"),
    "models": ("devs", "heavylift.nodes.zoo.token_ring:ring(2, 1, 500)", "--until", "1 ms"),
}
C = {"LC_ALL": "C", "PYTHONUTF8": "0"}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("closed", CLOSED, ids=str)
@pytest.mark.large(beyond=2)
def test_a_run_is_not_affected_by_closed_standard_streams(
    closed: tuple[int, ...], command: str, tmp_path: Path
) -> None:
    digests = []
    for name, which in ("open.mcap", ()), ("closed.mcap", closed):
        shell = " ".join(["exec", *(f"{fd}>&-" for fd in which)]) + '; exec "$@"'
        call = ["sh", "-c", shell, "sh", HEAVYLIFT, *COMMANDS[command], "-o", name]
        done = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_s)
        assert done.returncode == 0, done.stderr
        digests.append(Recording(tmp_path / name).result["digest"])
    assert digests[0] == digests[1]


def test_a_python_program_without_standard_streams_can_run_a_scene_in_several_processes(tmp_path: Path) -> None:
    code = "import os; [os.close(fd) for fd in (0, 1, 2)]; import heavylift; heavylift.run('pendulum', 'a.mcap')"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, timeout=PATIENCE_s)
    assert (done.returncode, Recording(tmp_path / "a.mcap").result["status"]) == (0, "finished")


@pytest.mark.parametrize("name", ["Kräne 吊".encode(), "Kräne".encode("latin-1")], ids=["utf-8", "latin-1"])
@pytest.mark.parametrize("environment", [C, {"LC_ALL": "C.UTF-8", "PYTHONUTF8": "0"}], ids=["C", "UTF-8"])
@pytest.mark.large(beyond=1)
def test_a_run_accepts_file_names_of_any_bytes_in_any_locale(
    environment: dict[str, str], name: bytes, tmp_path: Path
) -> None:
    text = os.fsdecode(name)
    folder = tmp_path / text
    folder.mkdir()
    (folder / f"{text}.yaml").write_bytes(bundled()["pendulum"].read_bytes())
    scene, recording = f"{text}.yaml", f"{text}.mcap"
    for command in (
        ("check", scene),
        ("run", scene, "--set", "end=1 s", "-o", recording),
        ("run", scene, "--set", "end=1 s", "--in-process"),
        ("info", recording, "--json"),
        ("report", recording),
        ("view", recording),
        ("export", recording, "-o", f"{text}.csv"),
        ("replay", recording, "--verify"),
        ("branch", recording, "--at", "0.5 s", "--set", "end=2 s"),
    ):
        call, message = [HEAVYLIFT, *command], {**os.environ, **environment}
        done = subprocess.run(call, cwd=folder, env=message, capture_output=True, timeout=PATIENCE_s)
        assert done.returncode == 0, (command, done.stdout, done.stderr)


def test_functions_called_from_python_write_text_files_in_any_locale(tmp_path: Path) -> None:
    folder = tmp_path / "Kräne"
    folder.mkdir()
    code = "import heavylift; heavylift.run('pendulum', 'a.mcap'); heavylift.sweep('pendulum', ['end=1 s'], into='s')"
    subprocess.run([sys.executable, "-c", code], cwd=folder, env={**os.environ, **C}, timeout=PATIENCE_s, check=True)
    assert Recording(folder / "a.mcap").result["status"] == "finished"


STRUCK = """
import os, signal, sys
number, point, seen = int(os.environ["NUMBER"]), os.environ["POINT"], []

def imported(event, arguments):
    if event == "import" and arguments[0] != "heavylift.coordinator.cli":
        if arguments[0] == point:
            signal.raise_signal(number)
        seen.append(arguments[0])

from heavylift.coordinator import cli
sys.addaudithook(imported)
try:
    cli.main()
finally:
    if not point:
        print(*seen)
"""


def struck(folder: Path, number: int, point: str) -> subprocess.CompletedProcess[str]:
    """The command, which gets the signal when it imports the module `point`; it tells which it imports without."""
    (folder / "struck.py").write_text(STRUCK)
    call = [sys.executable, "struck.py", "info", "no.mcap"]
    message = {**os.environ, "NUMBER": str(int(number)), "POINT": point}
    return subprocess.run(call, cwd=folder, env=message, capture_output=True, text=True, timeout=PATIENCE_s)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda x: x.name)
def test_an_interrupt_during_the_imports_of_a_command_ends_the_command_with_one_line(
    number: signal.Signals, tmp_path: Path
) -> None:
    points = [name for name in struck(tmp_path, number, "").stdout.split() if "." in name]
    assert len(points) > 50
    for point in [points[0], *Random(1).sample(points, 8)]:
        done = struck(tmp_path, number, point)
        assert (done.returncode, done.stderr) == (128 + number, "heavylift: stopped\n"), point
