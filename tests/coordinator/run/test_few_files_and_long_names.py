"""A run that may open few files, or whose names are very long, works or ends in one sentence, and leaves nothing."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from heavylift import run_models
from heavylift.coordinator.supervision import LIMITS
from heavylift.kernel import ProtocolError
from heavylift.nodes.devs import Atomic, Coupled, Message, Out, Simulator, ms
from heavylift.nodes.scene import bundled

HEAVYLIFT = Path(sys.executable).with_name("heavylift")
FILES = LIMITS[0][1]
LONG = 300  # characters: more than a file name may have


def play(folder: Path, words: str, files: int = 256) -> tuple[int, list[str], list[str]]:
    """Exit code, lines of standard error, and what a run leaves in its folder for temporary files."""
    spare = folder / "tmp"
    spare.mkdir()
    ended = subprocess.run(
        [HEAVYLIFT, *words.split()],
        cwd=folder,
        env={**os.environ, "TMPDIR": str(spare)},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (files, files)),
        capture_output=True,
        text=True,
        timeout=60.0,
    )
    return ended.returncode, ended.stderr.splitlines(), [each.name for each in spare.iterdir()]


@pytest.mark.parametrize("files", [20, 33, 64, 12, 26, 32, 36, 40, 48])
@pytest.mark.parametrize("where", ["", " --in-process"])
@pytest.mark.large(beyond=2)
def test_a_run_completes_with_a_low_limit_of_open_files(tmp_path: Path, files: int, where: str) -> None:
    code, text, left = play(tmp_path, f"run pendulum --set end=1s -o x.mcap{where}", files)
    refused = not where and files < FILES
    assert (code, left) == (int(refused), [])
    assert not refused or text == [
        f"heavylift: only {files} files may be open at once, and a run in processes needs at least {FILES}; raise the "
        "limit (`ulimit -n 256`) or run --in-process"
    ]


def test_a_scene_with_a_very_long_name_runs(tmp_path: Path) -> None:
    text = bundled()["pendulum"].read_text().replace("name: pendulum", f"name: {'n' * LONG}")
    (tmp_path / "long.yaml").write_text(text)
    code, answer, left = play(tmp_path, "run long.yaml --set end=1s --in-process")
    assert (code, len(answer), left) == (1, 1, [])
    assert answer[0].endswith("cannot be written (File name too long); choose another folder with -o")


@pytest.mark.parametrize("words", ["run pendulum", f"devs {__file__}:long_60 --until 3ms", "check pendulum"])
def test_a_command_in_a_deleted_folder_succeeds_or_ends_with_one_sentence(words: str, tmp_path: Path) -> None:
    (tmp_path / "gone").mkdir()
    ended = subprocess.run(
        ["sh", "-c", 'rmdir "$PWD" && exec "$@"', "sh", HEAVYLIFT, *words.split()],
        cwd=tmp_path / "gone",
        capture_output=True,
        text=True,
        timeout=60.0,
    )
    text = [line for line in ended.stderr.splitlines() if line.startswith("heavylift: ")]
    assert (ended.returncode == 0) == (not text)
    assert "internal error" not in ended.stderr


class Knock(Message):
    """Something."""


def clock(name: str, port: str) -> Coupled:
    """One model that says something each millisecond, and hears nothing."""

    class Clock(Atomic):
        def start(self) -> None:
            self.hold_in(ms(1))

        def output(self) -> None:
            getattr(self, port).send(Knock())

        def internal(self) -> None:
            self.hold_in(ms(1))

    setattr(Clock, port, Out(Knock))
    Clock.__init_subclass__()
    root = Coupled("root")
    root.add(Clock(name))
    root.add(Clock("other"))
    return root


@pytest.mark.parametrize("length", [60, LONG])
def test_a_model_name_of_60_characters_runs_in_processes_and_one_of_300_is_refused(length: int) -> None:
    name = "n" * length
    simulator = Simulator(clock(name, "tick"))
    simulator.start()
    simulator.run(ms(3))
    if length == LONG:
        with pytest.raises(ProtocolError, match=r"^node name 'n+' "):
            run_models(f"{__file__}:long_{length}", until=0.003)
    else:
        assert run_models(f"{__file__}:long_{length}", until=0.003).outcome.name == "BOUND"


def long_60() -> Coupled:
    """For a process of its own."""
    return clock("n" * 60, "tick")


def long_300() -> Coupled:
    """For a process of its own."""
    return clock("n" * LONG, "tick")
