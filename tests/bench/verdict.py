"""What a run costs before it begins and after it has ended: its equilibrium path, and its verdict with all clearances.

    python tests/bench/verdict.py [--json] [--short]

The verdict is timed where `turnover` takes it, at the end of a run in one process; the peer is the kernel's time of the
same run, so a slow machine shows as such.  The library of distances and the judges are imported before and counted on
their own line.
The path is walked with compiled code that is warm, but anew for each plan.  Medians of three; `--short` takes one run.
"""

import json
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from heavylift.coordinator.record import scene as recording
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.nodes.statics.rehearsal import Rehearsal

VERDICT_s, PATH_s = 0.3, 1.0  # targets
TIMES = 1 if "--short" in sys.argv else 3


def verdicts(folder):
    """Seconds of the verdict and of the kernel, for each run; and of the imports, once."""
    found, imports = [], []
    judged = recording.judge

    def timed(plan, history, conduct):
        began = time.perf_counter()
        import coal  # noqa: F401
        import heavylift.coordinator.verdict.judging  # noqa: F401

        ready = time.perf_counter()
        verdict = judged(plan, history, conduct)
        found.append(time.perf_counter() - ready)
        imports.append(ready - began)
        return verdict

    recording.judge = timed
    try:
        kernel = [run(load("turnover"), folder / "run.mcap", in_process=True).budget.kernel for _ in range(TIMES)]
    finally:
        recording.judge = judged
    return median(found), median(kernel), imports[0]


def path():
    """Seconds of the walk along the equilibrium path, with compiled code that one walk has made warm."""
    found = []
    for _ in range(TIMES + 1):
        rehearsal = Rehearsal(load("turnover").plan)
        began = time.perf_counter()
        rehearsal.walk()
        found.append(time.perf_counter() - began)
        assert rehearsal.states
    return median(found[1:])


def row(name, value, peer=None, peer_value=None, target=None):
    line = {
        "name": name,
        "value": round(value, 3),
        "unit": "s",
        "peer": peer,
        "peer_value": peer_value and round(peer_value, 3),
        "ratio": round(value / peer_value, 4) if peer_value else None,
        "target": target,
        "met": None if target is None else value <= target,
    }
    if "--json" in sys.argv:
        print(json.dumps(line), flush=True)
        return
    told = f"{name:<50} {line['value']:>7} s"
    if peer:
        told += f"  {peer} {line['peer_value']} s, ratio {line['ratio']}"
    if target is not None:
        told += f"  target <= {target} s: {'met' if line['met'] else 'MISSED'}"
    print(told, flush=True)


def main():
    row("turnover, equilibrium path", path(), target=PATH_s)
    with tempfile.TemporaryDirectory() as name:
        verdict, kernel, imported = verdicts(Path(name))
    row("turnover, verdict and clearances", verdict, "kernel of the same run", kernel, VERDICT_s)
    row("import of the judges and their library", imported)


if __name__ == "__main__":
    main()
