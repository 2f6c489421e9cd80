"""How long the founding lift takes on this machine, beside its motion: start to first grant, exit, path, verdict.

    python tests/bench/turnover.py [--json] [--short]

Whole processes are as a user starts them, all twelve of them and with full recording, cold and warm; no peer runs this
scene.  The equilibrium path is walked with compiled code that is warm, but anew for each plan.  The verdict with all
clearances is timed where a run takes it, at its end in one process; beside it stands the kernel's time of the same run,
so a slow machine shows as such.  The judges are imported before and counted on their own line.  Medians of three.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from unittest.mock import patch

from heavylift.coordinator import verdict
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.nodes.statics import Rehearsal
from shared.rows import SHORT, options, row

SCENE, END, TIMES = ("lift", ["end=10 s"], 1) if SHORT else ("turnover", [], 3)
RUN_s, COLD_s, WARM_s, VERDICT_s, PATH_s = 15.0, 3.0, 1.5, 0.3, 1.0  # budgets


def whole(folder: Path, cache: Path) -> tuple[float, float]:
    """Seconds to the first stage (the first grants are done) and to the exit."""
    command = [sys.executable, "-c", "from heavylift.coordinator.cli import main; main()", "run", SCENE, "--force"]
    began = time.perf_counter()
    process = subprocess.Popen(
        [*command, *(f"--set={x}" for x in END)],
        cwd=folder,
        env={**os.environ, "HEAVYLIFT_CACHE": str(cache)},
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
    )
    assert process.stderr is not None
    first = process.stderr.readline()
    granted = time.perf_counter() - began
    rest = process.communicate()[1]
    assert process.returncode == 0, first + rest
    assert load(SCENE).plan.actions[0].stage in first, first
    return granted, time.perf_counter() - began


def path() -> float:
    """Seconds of the walk along the equilibrium path."""
    found = []
    for _ in range(TIMES + 1):  # the first makes the code warm
        rehearsal = Rehearsal(load(SCENE, END).plan)
        began = time.perf_counter()
        rehearsal.walk()
        found.append(time.perf_counter() - began)
        assert rehearsal.states
    return median(found[1:])


def verdicts(folder: Path) -> tuple[float, float, float]:
    """Seconds of the verdict, of the kernel, and once of the imports."""
    found = []
    began = time.perf_counter()
    verdict.prepare()
    imported = time.perf_counter() - began
    judge = verdict.judge

    def timed(*arguments):  # type: ignore[no-untyped-def]
        began = time.perf_counter()
        judged = judge(*arguments)
        found.append(time.perf_counter() - began)
        return judged

    with patch.object(verdict, "judge", timed):
        runs = [run(load(SCENE, END), folder / "run.mcap", in_process=True) for _ in range(TIMES)]
    return median(found), median(r.budget.kernel for r in runs), imported


def main() -> None:
    options(__doc__ or "")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cold = [whole(folder, folder / f"cache-{i}") for i in range(TIMES)]
        warm = [whole(folder, folder / "cache-0") for _ in range(TIMES)]
        for what, found, to_grant in (("cold", cold, COLD_s), ("warm", warm, WARM_s)):
            row(f"start to first grant, {what} cache", median(g for g, _ in found), "s", at_most=to_grant)
            row(f"{SCENE}, start to exit, {what} cache", median(e for _, e in found), "s", at_most=RUN_s)
        row(f"{SCENE}, equilibrium path", path(), "s", at_most=PATH_s)
        judged, kernel, imported = verdicts(folder)
        name = f"{SCENE}, verdict and clearances"
        row(name, judged, "s", "kernel of the same run", kernel, at_most=VERDICT_s, absolute=True)
        row("import of the judges", imported, "s")


if __name__ == "__main__":
    main()
