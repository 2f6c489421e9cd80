"""Faults of observers: the run is not affected, and the observer ends as promised."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from .inside.striking import NUMBERS, SIGNALS
from .leftovers import state
from .trial import SAME, Kind, NotAsPromised, Trial, clean
from .workloads import HEAVYLIFT

ACTS = ("KILL", "STOP", "STOP, CONT", "SEGV", *SIGNALS, "standard output is closed")
BEGINS_s = {"start": (0.0, 0.02), "import": (0.0, 0.2), "run": (0.2, 0.6), "exit": (0.6, 1.2)}
CATCHES = 1 << signal.SIGTERM - 1  # in the mask of signals that a process catches


def watch(trial: Trial) -> None:
    run = trial.start()
    if trial.begun(0.0, run) is None:
        raise NotAsPromised(f"the run did not begin: {trial.end(run).said[-600:]}")
    act = trial.case.kind.name.partition(": ")[2]
    given = {"stdout": _nobody()} if act == "standard output is closed" else {}
    observer = trial.start([HEAVYLIFT, "watch"], to="observer", **given)
    starting = trial.case.moment == "start"  # within the interpreter's own
    while not starting and observer.poll() is None and not _catches(observer.pid) & CATCHES:
        time.sleep(0.005)
    time.sleep(trial.random.uniform(*BEGINS_s[trial.case.moment]))
    trial.struck = observer.poll() is None
    if trial.struck and act in NUMBERS:
        observer.send_signal(NUMBERS[act])
    trial.same(trial.end(run))
    if state(observer.pid) == "T":
        observer.send_signal(signal.SIGCONT if act == "STOP, CONT" else signal.SIGKILL)
    ended = trial.end(observer, "observer")
    if not trial.struck:
        return
    if act in SIGNALS:
        codes = (0, 128 + NUMBERS[act], *((-NUMBERS[act], 1) if starting else ()))
    else:
        codes = {"STOP, CONT": (0, 1), "standard output is closed": (0, 1, 141)}.get(act, (0, 1, -9, -11))
    if not starting:
        clean(ended)
    if ended.code not in codes:
        raise NotAsPromised(f"the observer's exit code {ended.code}: {ended.said[-600:]}")


def _catches(pid: int) -> int:
    """The mask of signals that a process catches."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return next((int(line.split()[1], 16) for line in lines if line.startswith("SigCgt:")), 0)


def _nobody() -> int:
    """The end for writing of a pipe that nobody reads."""
    reading, writing = os.pipe()
    os.close(reading)
    return writing


KINDS = [Kind(f"observer: {act}", f"{SAME}; no traceback", watch, tuple(BEGINS_s), ("paced",)) for act in ACTS]
