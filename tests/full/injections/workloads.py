"""The runs into which faults are injected, and their results without faults."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from heavylift.nodes.models import node_names
from heavylift.nodes.scene import load
from heavylift.recordings import Recording

HEAVYLIFT = str(Path(sys.executable).with_name("heavylift"))
DOOMED = Path(__file__).parents[2] / "coordinator" / "supervision"
NETWORK = f"{DOOMED / 'doomed_models.py'}:build"
RINGS = {"network": ("north", "east", "south"), "grouped": ("yard", "south")}
COMMANDS = {
    "lift": ["run", "lift"],
    "alone": ["run", "lift", "--in-process"],
    "paced": ["run", "lift", "--rate", "60"],  # takes a second, in which others can do something
    "turnover": ["run", "turnover"],
    "network": ["devs", NETWORK],
    "grouped": ["devs", NETWORK, "--place", "north,east=yard"],
}
GRANTS = {"lift": 60, "network": 118, "grouped": 78, "turnover": 250}  # of an undisturbed run, about


@cache
def processes_of(workload: str) -> tuple[str, ...]:
    """The processes of a run, of a scene called like their only nodes."""
    return RINGS[workload] if workload in RINGS else tuple(node_names(load(workload).plan))


def possible(moment: str, workload: str) -> bool:
    """Whether such a run comes to this moment: networks have no machine code, one process has no successor; that of
    `turnover` takes longer than the deadline."""
    return (moment, workload) != ("recovery", "alone") and not (
        moment == "compile" and workload in (*RINGS, "turnover")
    )


@cache
def undisturbed(workload: str) -> tuple[str, bytes]:
    """The digest of a run that nobody disturbs, and its recording."""
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "run.mcap"
        subprocess.run([HEAVYLIFT, *COMMANDS[workload], "-o", output], check=True, capture_output=True)
        return str(Recording(output).result["digest"]), output.read_bytes()
