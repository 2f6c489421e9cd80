"""A yard for the stories of several hosts: its certificates, its commands, and the digest that every run must have."""

import os
import socket
import subprocess
import sys
from pathlib import Path

from heavylift.coordinator.run import run
from heavylift.nodes.scene import load

HEAVYLIFT = str(Path(sys.executable).with_name("heavylift"))
PATIENCE_s = 60.0


def free_port() -> int:
    """A port of the loopback interface that nobody uses now."""
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


def start(folder: Path, *arguments: object, inside: str = "") -> "subprocess.Popen[str]":
    """The command in a folder, its output in pipes; `inside`: name of a network namespace."""
    enter = ["ip", "netns", "exec", inside] if inside else []
    return subprocess.Popen(
        [*enter, HEAVYLIFT, *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "COLUMNS": "1000"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finish(folder: Path, *arguments: object, inside: str = "") -> tuple[int, str]:
    """Exit code and standard error of the whole command."""
    process = start(folder, *arguments, inside=inside)
    _, error = process.communicate(timeout=PATIENCE_s)
    return process.returncode, error


def until(process: "subprocess.Popen[str]", words: str) -> str:
    """The first line of standard error that holds the words."""
    assert process.stderr is not None
    text = []
    for line in process.stderr:
        text.append(line)
        if words in line:
            return line
    raise AssertionError(f"the command ended without saying {words!r}: {''.join(text)}")


def ended(process: "subprocess.Popen[str]") -> tuple[int, str]:
    """Exit code, and what the command still says on standard error."""
    _, error = process.communicate(timeout=PATIENCE_s)
    return process.returncode, error


def digest_in_one_process(folder: Path) -> str:
    """Digest of `lift` without any transport."""
    return run(load("lift"), folder / "alone.mcap", in_process=True).digest
