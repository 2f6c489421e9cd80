"""Cost of one lift among thirty, build time and seconds of a run against a single lift; start time of 256 processes.

    python tests/bench/yard.py [--json] [--short]

Lifts of the scene `hall` side by side, 1.3 s after one another, each in a run in this process until all lists are done.
A lift whose list is done hangs in its slings until then, which costs events: beside the lift that ends alone stands one
that is shown alone for as long.  Seconds are those of the processor, least of three, with machine code from the cache.

A yard of 127 lifts has 256 processes by default: two machines a lift, commander, kernel.  Wall time of its first
two seconds as a user starts it: until all nodes have said what they declare, and until the command has ended.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from heavylift.coordinator.run import run
from heavylift.nodes.scene import LoadedScene, parse

sys.path.insert(0, str(Path(__file__).parent))
from shared.rows import SHORT, options, row

MANY, TIMES, APART = (2, 1, 1.3) if SHORT else (30, 3, 1.3)
BUILD, COST = 2.0, 1.5  # [s] more than one; times the cost of one
CROWD = 3 if SHORT else 127  # lifts, of two processes each
START_s = 5.0


def text(lifts: int, start: float = 1.0, end: str = "") -> str:
    """A yard of so many lifts."""
    rows = [f"  l{i}: {{extends: hall, at: [0 m, {40 * i} m], start: {start + APART * i} s}}\n" for i in range(lifts)]
    return f"heavylift: 1\nname: yard\naccuracy: 0.1 %\nsamples: 5 Hz\n{end}lifts:\n" + "".join(rows)


def built(lifts: int, *more: float | str) -> tuple[float, LoadedScene]:
    """Seconds until a yard could run, and the yard."""
    began = time.process_time()
    scene = parse(text(lifts, *more))
    return time.process_time() - began, scene


def ran(scene: LoadedScene) -> tuple[float, float]:
    """Seconds of its run, and of the simulated time."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        result = run(scene, Path(folder) / "yard.mcap", in_process=True)
        return time.process_time() - began, result.sim_s


def command() -> tuple[float, float, float]:
    """Seconds of a run of the crowd in processes: until they had started, until its exit, and of the processor."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "crowd.yaml").write_text(text(CROWD, 1.0, "end: 2 s\n"))
        started = [sys.executable, "-c", "from heavylift.coordinator.cli import main; main()", "run", "crowd.yaml"]
        began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([*started, "--json"], cwd=folder, check=True, capture_output=True)
        wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return json.loads(done.stdout)["budget"]["start"], wall, cpu


def main() -> None:
    """All figures."""
    options(__doc__ or "")
    took = {lifts: min(built(lifts)[0] for _ in range(TIMES + 1)) for lifts in (1, MANY)}
    row(f"{MANY} lifts are built, more than one", took[MANY] - took[1], "s", at_most=BUILD)
    one, builder = built(1)[1], built(MANY)[1]
    ran(one)  # compiles
    _, end = ran(builder)
    long = built(1, 1.0 + 0.5 * APART * (MANY - 1), f"end: {end} s\n")[1]  # as the one in the middle
    alone, as_long, among = (min(ran(scene)[0] for _ in range(TIMES)) for scene in (one, long, builder))
    row(f"a lift among {MANY}", among / MANY, "s", "alone", alone, at_most=COST)
    row(f"a lift among {MANY}", among / MANY, "s", "alone for as long", as_long, at_most=COST)
    command()  # reads and compiles what the next find in the cache
    start, whole, cpu = (min(found) for found in zip(*(command() for _ in range(TIMES)), strict=True))
    row(f"{2 * CROWD + 2} processes start", start, "s", at_most=START_s)
    row(f"{2 * CROWD + 2} processes, from the command to its exit", whole, "s")
    row(f"{2 * CROWD + 2} processes, of the processor", cpu, "s")


if __name__ == "__main__":
    main()
