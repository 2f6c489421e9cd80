"""Runs without end in one process, and many at once: nothing grows, and every digest is that of the first run.

    python tests/full/soak.py [--short | --runs=N] [--json]

A thousand runs one after the other, of four kinds in turn: a mechanism and the small lift with recordings, a network of
DEVS models with and without one; every 25th has processes of its own.  The resident set is looked at after each
tenth of the runs; growth counts from the end of the second.  Then twenty runs of the lift at once, in processes.
"""

from __future__ import annotations

import gc
import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from statistics import median

from heavylift.coordinator import run_models
from heavylift.coordinator.run import run
from heavylift.nodes.devs import ns
from heavylift.nodes.scene import load

SHORT = "--short" in sys.argv
RUNS, AT_ONCE = (60, 4) if SHORT else (1000, 20)
RUNS = next((int(arg.partition("=")[2]) for arg in sys.argv if arg.startswith("--runs=")), RUNS)
GROWTH = 1.0  # per cent of the resident set: target
QUEUE = f"{Path(__file__).parents[1] / 'bench' / 'shared' / 'queues.py'}:build"
ALONE = "from pathlib import Path; from heavylift.coordinator.run import run; print(run('lift', Path('x.mcap')).digest)"


def scene(name: str, *changed: str) -> Callable[[Path, bool], str]:
    return lambda path, apart: run(load(name, list(changed)), path, in_process=not apart).digest


def queue(recorded: bool) -> Callable[[Path, bool], str]:
    return lambda path, apart: (
        run_models(QUEUE, until=ns(20), output=path if recorded else None, in_process=not apart).digest
    )


KINDS = [scene("pendulum", "end=2 s"), queue(True), scene("lift", "end=5 s"), queue(False)]


def resident() -> float:
    """Resident set of this process [MB]."""
    gc.collect()
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS"))


def soaked() -> tuple[list[float], list[int], list[int], int]:
    """Resident sets of each tenth, numbers of open files and of threads after each run, digests that differ."""
    told: dict[int, set[str]] = {}
    rss: list[float] = []
    files, threads = list[int](), list[int]()
    with tempfile.TemporaryDirectory() as folder:
        for i in range(RUNS):
            kind = i % len(KINDS)
            path = Path(folder) / f"{i}.mcap"
            apart = i % 25 == 24
            told.setdefault(kind, set()).add(KINDS[kind](path, apart))
            path.unlink(missing_ok=True)
            files.append(len(os.listdir("/proc/self/fd")))
            threads.append(len(os.listdir("/proc/self/task")))
            if (i + 1) % (RUNS // 10) == 0:
                rss.append(resident())
                print(f"{i + 1} runs, {rss[-1]:.1f} MB, {threading.active_count()} threads", file=sys.stderr)
    return rss, files, threads, sum(len(digests) - 1 for digests in told.values())


def at_once() -> tuple[int, int]:
    """Digests of runs at once, and how many of them ended otherwise than in order."""
    with tempfile.TemporaryDirectory() as name:
        folders = [Path(name) / str(i) for i in range(AT_ONCE)]
        for folder in folders:
            folder.mkdir()
        started = [
            subprocess.Popen([sys.executable, "-c", ALONE], cwd=folder, stdout=subprocess.PIPE, text=True)
            for folder in folders
        ]
        said = [process.communicate()[0] for process in started]
        return len(set(said)), sum(process.returncode != 0 for process in started)


def main() -> None:
    rss, files, threads, differing = soaked()
    fifth = RUNS // 5
    growth = 100 * (median(rss[-2:]) / median(rss[1:3]) - 1)
    digests, failed = at_once()
    rows = [
        (f"growth of the resident set over {RUNS} runs", growth, "%", GROWTH),
        (
            "more open files after the last fifth than after the first",
            median(files[-fifth:]) - median(files[:fifth]),
            "",
            0,
        ),
        (
            "more threads after the last fifth than after the first",
            median(threads[-fifth:]) - median(threads[:fifth]),
            "",
            0,
        ),
        ("digests that differ from the first of their kind", differing, "", 0),
        (f"digests of {AT_ONCE} runs at once, beside the first", digests - 1, "", 0),
        (f"of {AT_ONCE} runs at once, ended otherwise than in order", failed, "", 0),
    ]
    for title, value, unit, target in rows:
        row = {"name": title, "value": round(value, 3), "unit": unit, "target": target, "met": value <= target}
        print(json.dumps(row) if "--json" in sys.argv else f"{title:<56} {value:8.2f} {unit}   target {target:g}")
    sys.exit(any(value > target for _, value, _, target in rows))


if __name__ == "__main__":
    main()
