"""Speed of variants of the bundled lift, and the overhead of the study engine.

    python tests/bench/sweep.py [--json] [--short]

Runs a second and core are of CPU time in one thread, warm, as a worker has it: loading a variant with all its checks,
the run, its digest; then with limits and clearances checked as well.  The engine's overhead is the wall time of a study
on an executor that runs in this thread, less that of its variants.  Growth is that of the resident set from the first
tenth of the runs to the last; two workers are compared with one by wall time, so other work on the machine counts.
"""

from __future__ import annotations

import gc
import itertools
import os
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any

from heavylift.coordinator.record import play
from heavylift.coordinator.run import run
from heavylift.coordinator.sweeps import Study, Task, Variant, played, sweep
from heavylift.nodes.scene import load
from shared.rows import SHORT, options, row

SCENE = "lift"
RUNS = 2 if SHORT else 60
GROWING = 4 if SHORT else 10_000
POOLED = 2 if SHORT else 256
NUMBERS = itertools.count()
PAGE_MB = os.sysconf("SC_PAGE_SIZE") / 2**20


class InThisThread(Executor):
    """The least that an engine can cost."""

    def submit(self, f: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(f(*args, **kwargs))
        return future


def variants(count: int) -> Iterator[Variant]:
    """Lifts of masses that were not run before: nothing of them is in a cache."""
    for number in range(count):
        yield Variant(number, (f"block.mass={300 + 0.001 * next(NUMBERS)} t",), ())


def rate(task: Task) -> float:
    """Runs a second of CPU time: of the fastest half, for other work only ever slows them."""
    spent = []
    for variant in variants(RUNS):
        began = time.thread_time()
        assert played(task, variant)["status"] == "done"
        spent.append(time.thread_time() - began)
    fastest = sorted(spent)[: max(1, len(spent) // 2)]
    return len(fastest) / sum(fastest)


def resident() -> float:
    """[MB]"""
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE_MB


def pooled(folder: Path, workers: int) -> tuple[float, float]:
    """Wall seconds of a study on a pool of processes, and the most memory that one of them has had [MB]."""
    began = time.perf_counter()
    low, most = 300 + next(NUMBERS), [0.0]

    def watch(study: Study, row: dict[str, Any] | None) -> None:
        if row is not None:
            status = Path(f"/proc/{row['process']}/status").read_text()
            most.append(int(status.partition("VmHWM:")[2].split()[0]) / 1024)

    vary = [f"block.mass={low}..{low + 0.001 * (POOLED - 1)} t by 0.001 t"]
    study = sweep(SCENE, vary, into=folder, workers=workers, watch=watch)
    assert len(study.rows) == POOLED
    return time.perf_counter() - began, max(most)


def main() -> None:
    options(__doc__)
    gc.set_threshold(10_000)  # as in a worker
    scene = load(SCENE)
    bare, checked = Task.of(scene, 60.0, "none", False), Task.of(scene, 60.0, "none", True)
    played(checked, next(variants(1)))
    row("runs a second and core, without verdict", rate(bare), "1/s", at_least=60.0)
    row("runs a second and core, with verdict and clearances", rate(checked), "1/s", at_least=40.0)
    spent = min(_seconds(lambda: play(scene.plan)) for _ in range(1 if SHORT else 20))
    row("the run of a loaded variant alone", 1e3 * spent, "ms")
    run_again = play(scene.plan)
    judged = min(_seconds(lambda: replace(run_again.judge).fine) for _ in range(1 if SHORT else 20))
    row("share of that run that its verdict takes", 100 * judged / spent, "%", at_most=25.0)
    with tempfile.TemporaryDirectory() as folder:
        study = sweep(SCENE, ["block.mass={301 t, 302 t}"], into=Path(folder) / "1", executor=InThisThread())
        digests = [run(load(SCENE, r["settings"]), Path(folder) / f"{n}.mcap", in_process=True).digest
                   for n, r in study.rows.items()]  # fmt: skip
        row(
            "digests that differ from those of `run`",
            sum(r["digest"] not in digests for r in study.rows.values()),
            "",
            at_most=0,
        )
        masses = ", ".join(f"{400 + 0.01 * n:g} t" for n in range(RUNS))
        began = time.perf_counter()
        study = sweep(
            SCENE, [f"block.mass={{{masses}}}"], into=Path(folder) / "2", executor=InThisThread(), judged=False
        )
        whole = time.perf_counter() - began
        inside = sum(r["wall_s"] for r in study.rows.values())
        row("overhead of the engine", 1e3 * (whole - inside) / RUNS, "ms a run", at_most=5.0)
        (one, most), (two, other) = pooled(Path(folder) / "3", 1), pooled(Path(folder) / "4", 2)
        row(f"{POOLED} variants on two workers beside one", one / two, "x", at_least=1.9)
    row("largest worker", max(most, other), "MB", at_most=200.0)
    before = 0.0
    for variant in variants(GROWING):
        if variant.number == GROWING // 10:
            before = resident()
        played(bare, variant)
    row(f"growth over {GROWING} runs", resident() - before, "MB", at_most=20.0)


def _seconds(f: Any) -> float:
    began = time.thread_time()
    f()
    return time.thread_time() - began


if __name__ == "__main__":
    main()
