"""Faults of message transport on one host: corrupted, late or lost frames, and a removed socket."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Callable
from pathlib import Path

from . import processes
from .leftovers import processes as those_of
from .trial import RESUMED, SAME, SENTENCE, Kind, Trial
from .workloads import GRANTS, processes_of

FRAMES = ("cut", "damaged", "lost", "doubled")
LATE = ("delayed", "held back")
ENDED = f"{SAME}, or {SENTENCE} and {RESUMED}"


def frame(trial: Trial) -> None:
    """One of the frames that somebody sends; the moment says whom it is for."""
    scene = "lift" if trial.case.workload == "alone" else trial.case.workload
    to_node = trial.case.moment == "to a node"
    who = "coordinator" if to_node else trial.random.choice(processes_of(scene))
    grants = GRANTS[scene] if to_node else GRANTS[scene] // len(processes_of(scene)) // 2
    act = trial.case.kind.name.partition(": ")[2].removeprefix("a frame is ").removeprefix("frames are ")
    plan = {"who": who, "act": act, "phase": "frame", "folder": str(trial.folder), "late": False}
    plan |= {"point": trial.random.randrange(grants), "held_s": trial.random.choice([0.5, 2.5, 6.0])}
    ended = processes.run(trial, plan | {"late_s": trial.random.choice([0.001, 0.01])})
    trial.struck = act == "delayed" or (trial.folder / "struck").exists()
    if act in LATE or not trial.struck:
        return trial.same(ended)
    trial.same_or_sentence(ended)
    trial.resumed()


def _at_the_socket(do: Callable[[Path], object]) -> Callable[[Trial], None]:
    """Something happens to the private directory; then, at the moment of recovery, a process is lost."""

    def happens(trial: Trial) -> None:
        process = trial.start([*trial.command, "--deadline", "2 s"])
        if trial.case.moment != "start":
            trial.until(process, "lift off")  # all have joined
        trial.struck = trial.begun(trial.random.uniform(0.0, 0.3), process) is not None
        for private in trial.temporary.glob("heavylift-????????"):
            do(private)
        if trial.case.moment == "recovery" and (nodes := _nodes(trial)):
            os.kill(trial.random.choice(nodes), signal.SIGKILL)
        trial.same_or_sentence(trial.end(process))
        trial.resumed()

    return happens


def _nodes(trial: Trial) -> list[int]:
    return [pid for pid in those_of(trial.folder) if Path(f"/proc/{pid}/comm").read_text().startswith("hl ")]


def _emptied(private: Path) -> None:
    for path in private.iterdir():
        path.unlink()


HARM: dict[str, Callable[[Path], object]] = {
    "socket is removed": lambda private: (private / "hub.sock").unlink(missing_ok=True),
    "directory is emptied": _emptied,
    "directory is removed": lambda private: shutil.rmtree(private, ignore_errors=True),
    "directory is renamed": lambda private: private.rename(private.with_name("renamed")),
}
RUNS = ("lift", "alone", "network", "grouped")
KINDS = [
    *(
        Kind(f"bus: a frame is {act}", ENDED, frame, ("to a node", "from a node"), RUNS[:1] + RUNS[2:])
        for act in FRAMES
    ),
    Kind("bus: frames are delayed", SAME, frame, ("to a node",), RUNS),
    Kind("bus: a frame is held back", SAME, frame, ("to a node", "from a node"), RUNS[:1] + RUNS[2:]),
    *(
        Kind(
            f"bus: {name}",
            ENDED,
            _at_the_socket(do),
            ("start", "run", "recovery"),
            ("paced",),
        )
        for name, do in HARM.items()
    ),
]
