"""Who calls heavylift from Python hears what it says from `logging`, and nothing on the streams of the process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

CALLS = """
from heavylift import Recording, load, replicate, run, run_models, simulate, sweep
from heavylift.coordinator.run.branch import RunBranch, branch
from heavylift.coordinator.sweeps.limiting import limits_of_all
from heavylift.coordinator.sweeps.planning import planned
from heavylift.coordinator.uncertainty.sensitivities import sensitivities
from heavylift.kernel.errors import HeavyliftError

if __name__ == "__main__":
    scene = load("snatch", ["end=2 s"])
    simulate(scene)
    for in_process in (True, False):
        run(scene, "run.mcap", in_process=in_process)  # the second time another name is taken
    sweep(scene, ["mechanism.bodies.load.mass=9..10 t by 1 t"], into="study", workers=1)
    sensitivities(scene, ["mechanism.bodies.load.mass +- 1 %"], at_once=0)
    planned(scene, 1.0)
    limits_of_all(scene, ["mechanism.bodies.load.mass=9..10 t"])
    branch(RunBranch.of("run.mcap", "1 s", ["end=1.5 s"]))
    run_models("heavylift.nodes.zoo.token_ring:ring(2, 2, 5000000)", until=0.01)
    replicate("heavylift.nodes.zoo.multi_server_queue:mmc()", 2, until=10.0)
    try:
        run(load("pendulum", ["end=1 s"]), "no/such/folder/run.mcap")
    except HeavyliftError:
        pass
"""
LISTENING = """
import logging
logging.getLogger("heavylift").addHandler(logging.FileHandler("heard.txt"))
logging.getLogger("heavylift").setLevel(logging.INFO)
"""
SILENT = """
from heavylift import load, run

if __name__ == "__main__":
    for _ in range(2):
        run(load("snatch", ["end=1 s"]), "run.mcap", in_process=True)
"""


def said(tmp_path: Path, script: str) -> str:
    """Everything that a script prints on both streams."""
    file = tmp_path / "calls.py"
    file.write_text(script)
    done = subprocess.run([sys.executable, file.name], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == 0, done.stdout.decode()
    return done.stdout.decode()


def test_functions_called_from_python_print_nothing_without_a_log_handler(tmp_path: Path) -> None:
    assert said(tmp_path, SILENT) == ""


def test_a_python_log_handler_receives_the_messages_of_functions_called_from_python(tmp_path: Path) -> None:
    assert said(tmp_path, LISTENING + CALLS) == ""
    heard = (tmp_path / "heard.txt").read_text().splitlines()
    assert "run.mcap exists; writing run-2.mcap" in heard
    assert any(line.startswith("  mechanism.bodies.load.mass ") for line in heard)
    assert any(line.startswith("2 runs of about ") for line in heard)
