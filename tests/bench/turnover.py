"""How long the founding lift takes on this machine: whole run, and start to first grant, cold and warm.

    python tests/bench/turnover.py [--json]

Whole processes, as a user starts them, all twelve of them and with full recording.  There is no peer that runs this
scene; the reference is the budget.  Medians of three runs.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

HEAVYLIFT = Path(sys.executable).parent / "heavylift"
RUN_s, COLD_s, WARM_s = 15.0, 3.0, 1.5  # budgets


def run(folder: Path, cache: Path) -> tuple[float, float]:
    """Seconds to the first stage (the first grants are done) and to the exit."""
    environment = {**os.environ, "HEAVYLIFT_CACHE": str(cache)}
    began = time.perf_counter()
    process = subprocess.Popen(
        [HEAVYLIFT, "run", "turnover"],
        cwd=folder,
        env=environment,
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
    )
    assert process.stderr is not None
    first = process.stderr.readline()
    granted = time.perf_counter() - began
    assert "take up slack" in first, first
    process.communicate()
    assert process.returncode == 0
    return granted, time.perf_counter() - began


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cold = [run(folder, folder / f"cache-{i}") for i in range(3)]
        warm = [run(folder, folder / "cache-0") for _ in range(3)]
    rows = [
        ("start to first grant, cold cache", median(g for g, _ in cold), COLD_s),
        ("start to first grant, warm cache", median(g for g, _ in warm), WARM_s),
        ("turnover, start to exit, cold cache", median(e for _, e in cold), RUN_s),
        ("turnover, start to exit, warm cache", median(e for _, e in warm), RUN_s),
    ]
    for title, value, target in rows:
        row = {
            "name": title,
            "value": round(value, 3),
            "unit": "s",
            "peer": None,
            "peer_value": None,
            "ratio": round(value / target, 3),
            "target": target,
            "met": value <= target,
        }
        print(json.dumps(row) if "--json" in sys.argv else f"{title:<38} {value:6.2f} s   budget {target:g} s")


if __name__ == "__main__":
    main()
