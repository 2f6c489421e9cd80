"""Processes started and observed by a bench: forked measurements, process families, data lost by a kill."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from heavylift.coordinator.run import RunObserver
from heavylift.recordings import recover

FORK = multiprocessing.get_context("fork")
PATIENCE_s = 300.0


class Forked:
    """A call in a process of its own, which has the imports of this one and none of its sessions."""

    def __init__(self, work: Callable[..., Any], *arguments: Any, cores: int = 0) -> None:
        self._ours, theirs = FORK.Pipe(duplex=False)
        self._process = FORK.Process(target=self._work, args=(theirs, cores, work, arguments))
        self._process.start()
        theirs.close()

    @staticmethod
    def _work(answer: Any, cores: int, work: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        if cores:  # of those that we may use
            os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[-cores:])
        answer.send(work(*arguments))

    def result(self) -> Any:
        """What the call returned; EOFError after the traceback of one that failed, TimeoutError of one that hangs."""
        try:
            if not self._ours.poll(PATIENCE_s):
                raise TimeoutError(f"a measurement has not ended within {PATIENCE_s:g} s")
            return self._ours.recv()
        finally:
            self._process.terminate()
            self._process.join()


class Told(RunObserver):
    """Says on standard output which simulation time [ns] was reached."""

    def progress(self, t_ns: int) -> None:
        print(t_ns, flush=True)


def lost(process: subprocess.Popen[str], folder: Path, after: float) -> float:
    """Wall seconds of a run that a kill takes away, so many seconds after the first samples; it is `Told` of."""
    reached: list[tuple[float, int]] = []
    assert process.stdout is not None
    while not reached or reached[-1][0] - reached[0][0] < after:
        line = process.stdout.readline()
        if not line.strip().isdigit():
            raise RuntimeError(f"the run ended before it could be killed: {line!r}")
        if t_ns := int(line):
            reached.append((time.monotonic(), t_ns))
    os.kill(process.pid, signal.SIGKILL)
    killed = time.monotonic()
    process.communicate()
    saved = round(recover(folder / "run.mcap.part", folder / "saved.mcap").sim_s * 1e9)
    return killed - max((wall for wall, t_ns in reached if t_ns <= saved), default=reached[0][0])


def family(pid: int) -> dict[int, list[str]]:
    """This process and all that descend from it, with their fields of /proc/PID/stat from the state on."""
    stats = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            with suppress(OSError):
                stats[int(entry.name)] = (entry / "stat").read_text().rpartition(")")[2].split()
    found = [pid]
    for each in found:
        found += [p for p, fields in stats.items() if int(fields[1]) == each]
    return {p: stats[p] for p in found if p in stats}
