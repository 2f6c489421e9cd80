"""`--external s1`: a program without heavylift joins with a ticket, and no byte of the digest changes."""

from __future__ import annotations

import ast
import os
import signal
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from heavylift import run_models
from heavylift.coordinator.cli import main
from heavylift.coordinator.run import RunObserver
from heavylift.kernel import OutputError
from heavylift.nodes.devs import ms

NODE = Path(__file__).with_name("reference_node.py")
RING = "heavylift.nodes.zoo.token_ring:ring(2, 1, 5_000_000)"
modes: list[int] = []


def reference(ticket: Path) -> subprocess.Popen[bytes]:
    """The program, which finds no module but those that are installed."""
    modes.append(stat.S_IMODE(ticket.stat().st_mode))
    return subprocess.Popen([sys.executable, "-I", NODE, ticket])


def test_the_example_program_is_short_and_imports_only_zenoh_and_msgpack() -> None:
    text = NODE.read_text()
    found = [x for x in ast.walk(ast.parse(text)) if isinstance(x, ast.Import | ast.ImportFrom)]
    names = {alias.name for x in found if isinstance(x, ast.Import) for alias in x.names}
    assert names - sys.stdlib_module_names == {"zenoh", "msgpack"}
    assert {x.module for x in found if isinstance(x, ast.ImportFrom)} == {"pathlib"}
    assert len(text.splitlines()) <= 80


def test_running_a_node_in_an_external_program_does_not_change_the_digest(guest, tmp_path: Path) -> None:
    ended = []
    with guest(lambda ticket: ended.append(reference(ticket).wait(60))):
        run = run_models(RING, until=0.101, external=["s1"])
    assert run.digest == run_models(RING, until=0.101, in_process=True).digest
    assert ended == [0]
    assert modes.pop() == 0o600
    assert list(tmp_path.iterdir()) == []  # the ticket has gone with the run


def test_a_run_whose_external_node_is_missing_ends_with_a_clear_message(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["heavylift", "devs", RING, "--external", "s1", "--deadline", "1 s"])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 1
    path = tmp_path / "s1.ticket"
    assert capsys.readouterr().err.splitlines() == [
        f"waiting for process s1; its ticket is {path}, good for 1 s",
        f"heavylift: process s1: nobody has joined with {path} within 1 s; start its program while the run waits, or "
        "let it wait longer (--deadline)",
    ]
    assert list(tmp_path.iterdir()) == []


def test_a_run_does_not_overwrite_an_existing_file_with_the_name_of_its_ticket(
    tmp_path: Path, monkeypatch, guest
) -> None:
    path = tmp_path / "s1.ticket"
    path.write_text("a ticket for the theatre")
    with pytest.raises(OutputError, match="is not the ticket of an ended run; move it"):
        run_models(RING, until=0.101, external=["s1"])
    assert path.read_text() == "a ticket for the theatre"


@pytest.mark.parametrize(
    ("more", "said"),
    {
        "--external s7": "--external 's7': there is no process 's7'; the processes are s0, s1",
        "--external s1 --in-process": "--in-process: process s1 is an external program; "
        "leave out --in-process or --external",
    }.items(),
)
def test_models_that_an_external_program_cannot_run_are_refused_before_the_run(
    monkeypatch, capsys, more: str, said: str
) -> None:
    monkeypatch.setattr(sys, "argv", ["heavylift", "devs", RING, *more.split()])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 1
    assert capsys.readouterr().err == f"heavylift: {said}\n"


@pytest.mark.large
def test_a_program_that_replaces_a_killed_external_program_receives_all_earlier_messages(guest, tmp_path: Path) -> None:
    message: list[str] = []

    class Listening(RunObserver):
        def say(self, sentence: str) -> None:
            message.append(sentence)

        def event(self, event: object) -> None:
            if len(pids) == 1 and getattr(event, "t", 0) >= ms(50):
                os.kill(pids[0], signal.SIGKILL)
                pids.append(0)
                threading.Thread(target=again).start()

    pids: list[int] = []

    def again() -> None:
        while len(message) < 3:
            time.sleep(0.01)
        reference(tmp_path / "s1.ticket")

    with guest(lambda ticket: pids.append(reference(ticket).pid)):
        run = run_models(RING, until=2.001, external=["s1"], watch=Listening())
    assert run.digest == run_models(RING, until=2.001, in_process=True).digest
    assert [sentence[:7] for sentence in message] == ["waiting", "node s1", "waiting"]
