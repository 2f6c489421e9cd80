"""Who calls heavylift from Python hears what it says from `logging`, and nothing on the streams of the process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

CALLS = """
from heavylift import Recording, load, replicate, run, run_models, simulate, sweep
from heavylift.coordinator.run.branch import Branch, branch
from heavylift.coordinator.sweeps.limiting import limits_of_all
from heavylift.coordinator.sweeps.planning import planned
from heavylift.coordinator.ladder.sensitivities import sensitivities
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
    branch(Branch.of("run.mcap", "1 s", ["end=1.5 s"]))
    run_models("heavylift.nodes.zoo.token_ring:ring(2, 2, 5000000)", until=0.01)
    replicate("heavylift.nodes.zoo.multi_server_queue:mmc()", 2, until=10.0)
    try:
        run(load("pendulum", ["end=1 s"]), "no/such/folder/run.mcap")
    except HeavyliftError:
        pass
"""
LISTENING = "import logging\nlogging.basicConfig(level=logging.INFO, format='%(name)s: %(message)s')\n"


def said(tmp_path: Path, script: str) -> str:
    """On both streams."""
    file = tmp_path / "calls.py"
    file.write_text(script)
    done = subprocess.run([sys.executable, file.name], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == 0, done.stdout.decode()
    return done.stdout.decode()


def test_nothing_is_printed(tmp_path: Path) -> None:
    assert said(tmp_path, CALLS) == ""


def test_a_script_that_listens_receives_it(tmp_path: Path) -> None:
    heard = said(tmp_path, LISTENING + CALLS).splitlines()
    assert "heavylift.run: run.mcap is there already and stays; this run writes run-2.mcap" in heard
    assert any(line.startswith("heavylift.sweeps:   mechanism.bodies.load.mass ") for line in heard)
    assert any(line.startswith("heavylift.ladder: 2 runs of about ") for line in heard)
