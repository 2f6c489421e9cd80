"""A thousand runs in one process, and twenty at once: nothing grows, and every digest is that of the first run.

    python tests/full/soak.py [--short | --runs=N] [--json]

A thousand runs one after the other, of four kinds in turn: a mechanism and the small lift with recordings, a network of
DEVS models with and without one; every 25th has processes of its own.  After each tenth of the runs the resident set,
open files and threads are looked at, when the helpers of the bus have left that had nothing to do for a while; growth
is that of the least from the second to fifth tenth to the others.  Threads share one arena of the allocator here: how
the blocks of threads that have ended are spread over several moves the resident set by two per cent.  Then twenty runs
of the lift at once, in processes.
"""

from __future__ import annotations

import gc
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from heavylift import run_models
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load

SHORT = "--short" in sys.argv
RUNS, AT_ONCE = (60, 4) if SHORT else (1000, 20)
RUNS = next((int(arg.partition("=")[2]) for arg in sys.argv if arg.startswith("--runs=")), RUNS)
GROWTH = 1.0  # per cent of the resident set: target
QUEUE = f"{Path(__file__).parents[1] / 'bench' / 'shared' / 'queues.py'}:build"
IDLE_s = 11.0  # after which a helper of the bus has left
ALONE = "from pathlib import Path; from heavylift.coordinator.run import run; print(run('lift', Path('x.mcap')).digest)"


def scene(name: str, *changed: str) -> Callable[[Path, bool], str]:
    return lambda path, apart: run(load(name, list(changed)), path, in_process=not apart).digest


def queue(recorded: bool) -> Callable[[Path, bool], str]:
    return lambda path, apart: (
        run_models(QUEUE, until=20.0, output=path if recorded else None, in_process=not apart).digest
    )


KINDS = [scene("pendulum", "end=2 s"), queue(True), scene("lift", "end=5 s"), queue(False)]


def resident() -> float:
    """Resident set of this process [MB]."""
    gc.collect()
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS"))


def soaked() -> tuple[list[float], list[int], list[int], int]:
    """Resident sets, numbers of open files and of threads after each tenth, digests that differ."""
    message: dict[int, set[str]] = {}
    rss: list[float] = []
    files, threads = list[int](), list[int]()
    with tempfile.TemporaryDirectory() as folder:
        for i in range(RUNS):
            kind = i % len(KINDS)
            path = Path(folder) / f"{i}.mcap"
            apart = i % 25 == 24
            message.setdefault(kind, set()).add(KINDS[kind](path, apart))
            path.unlink(missing_ok=True)
            if (i + 1) % (RUNS // 10) == 0:
                time.sleep(IDLE_s)
                rss.append(resident())
                files.append(len(os.listdir("/proc/self/fd")))
                threads.append(len(os.listdir("/proc/self/task")))
                print(f"{i + 1} runs, {rss[-1]:.1f} MB, {files[-1]} files, {threads[-1]} threads", file=sys.stderr)
    return rss, files, threads, sum(len(digests) - 1 for digests in message.values())


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
        text = [process.communicate()[0] for process in started]
        return len(set(text)), sum(process.returncode != 0 for process in started)


def main() -> None:
    if "MALLOC_ARENA_MAX" not in os.environ:
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, "MALLOC_ARENA_MAX": "1"})
    rss, files, threads, differing = soaked()
    growth = 100 * (min(rss[5:]) / min(rss[1:5]) - 1)  # what is free again comes and goes; what is kept stays
    digests, failed = at_once()
    rows = [
        (f"growth of the resident set over {RUNS} runs", growth, "%", GROWTH),
        ("open files, most beyond fewest", max(files) - min(files), "", 0),
        ("threads, most beyond fewest", max(threads[1:]) - min(threads[1:]), "", 0),
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
