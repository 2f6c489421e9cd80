"""How a page plays in a browser without a graphics card: pictures a second, what one costs, and the bytes of an hour.

    python tests/bench/page.py [--json]

The founding lift (67 minutes) at 20 times real time, 1200 x 800 pixels, headless Chromium with its software renderer.
The processor time of a picture is that of all of the browser's processes, so it holds on a busy machine, too; what the
same browser shows when nothing is drawn is measured beside it.
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "recordings"))
from browser import Chromium
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording, view

SECONDS = 6.0
FRAMES_per_s, HOUR_bytes = 30.0, 15e6  # what is wanted
COUNT = """new Promise(done => {
  const { player, stage } = heavylift; const began = performance.now(); let n = 0;
  const next = () => {
    n++;
    if (performance.now() - began < %g) requestAnimationFrame(next);
    else { player.play(false); done([1e3 * n / (performance.now() - began), stage.quality.level, n]); }
  };
  %s; requestAnimationFrame(next);
})"""
TICKS_per_s = 100  # of /proc/<pid>/stat


def processor_s(pid: int) -> float:
    """Processor time of a process and all below it, so far."""
    stats = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                fields = (entry / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            stats[int(entry.name)] = int(fields[1]), int(fields[11]) + int(fields[12])
    total, todo = 0, [pid]
    while todo:
        total += sum(stats[p][1] for p in todo if p in stats)
        todo = [p for p, (parent, _) in stats.items() if parent in todo]
    return total / TICKS_per_s


def main() -> None:
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = Path(folder) / "turnover.mcap"
        run(load("turnover"), path, in_process=True)
        page = view(path, path.with_suffix(".html"))
        size = page.stat().st_size * 3600.0 / float(Recording(path).fact("sim_s"))
        with Chromium(Path(folder) / "profile") as browser:
            browser.open(f"{page.as_uri()}#t=900")
            browser.run(COUNT % (2e3, "player.play(true)"))  # until the number of pixels has settled
            spent = processor_s(browser.pid)
            rate, level, frames = browser.run(COUNT % (1e3 * SECONDS, "player.play(true)"))
            cost = (processor_s(browser.pid) - spent) / frames
            idle = browser.run(COUNT % (1e3 * SECONDS, ""))[0]
    rows = [
        ("pictures a second", rate, "1/s", idle, FRAMES_per_s, rate >= FRAMES_per_s),
        ("processor time of a picture", 1e3 * cost, "ms", None, None, None),
        ("level of pixels, 0 = all", level, "", None, None, None),
        ("page of an hour", size / 1e6, "MB", None, HOUR_bytes / 1e6, size <= HOUR_bytes),
    ]
    for name, value, unit, peer_value, target, met in rows:
        row = {"name": name, "value": value, "unit": unit, "peer": "the same page at rest" if peer_value else None}
        ratio = value / peer_value if peer_value else None
        row |= {"peer_value": peer_value, "ratio": ratio, "target": target, "met": met}
        wanted = f", wanted {target:g}" if target else ""
        print(json.dumps(row) if "--json" in sys.argv else f"{name:30} {value:8.2f} {unit}{wanted}")


if __name__ == "__main__":
    main()
