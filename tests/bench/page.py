"""Playback of a page in a browser without a graphics card: frame rate, time of a frame, bytes, opening times.

    python tests/bench/page.py [--json] [--short]

The founding lift (67 minutes) at 20 times real time, 1200 x 800 pixels, headless Chromium with its software renderer.
The processor time of a picture is that of all of the browser's processes, so it holds on a busy machine, too; what the
same browser shows when nothing is drawn is measured beside it.  Long recordings are the same lift with ten hours and
with 200 samples a second (800 MB); making is reported in processor time, opening by the clock.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "recordings"))
from browser import CHROMIUM, Chromium
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording, view
from heavylift.recordings.documents import report
from shared.processes import family
from shared.rows import SHORT, options, row

SECONDS, SETTLING, START, LIFT = (0.3, 0.2, 1, ("lift", ["end=5 s"])) if SHORT else (6.0, 2.0, 900, ("turnover", []))
LONG = {"10 h": ["end=20 s"], "200 Hz": ["end=2 s", "samples=200 Hz"]} if SHORT else {
    "10 h": ["end=36000 s"], "200 Hz": ["samples=200 Hz"]
}  # fmt: skip
FRAMES_per_s, HOUR_bytes, OPEN_s = 30.0, 15e6, 2.0  # what is wanted
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
    return sum(int(fields[11]) + int(fields[12]) for fields in family(pid).values()) / TICKS_per_s


def played(page: Path, folder: Path) -> tuple[float, float, float, float, float]:
    """Pictures a second, level of pixels, processor time [s] of a picture, pictures a second at rest; until it is
    there [s]."""
    with Chromium(folder / "profile") as browser:
        browser.open(f"{page.as_uri()}#t={START}")
        began = time.perf_counter()
        browser.open(f"{page.as_uri()}#t={START}")
        opened = time.perf_counter() - began
        browser.run(COUNT % (1e3 * SETTLING, "player.play(true)"))  # until the number of pixels has settled
        spent = processor_s(browser.pid)
        rate, level, frames = browser.run(COUNT % (1e3 * SECONDS, "player.play(true)"))
        cost = (processor_s(browser.pid) - spent) / frames
        return rate, level, cost, browser.run(COUNT % (1e3 * SECONDS, ""))[0], opened


def opened(page: Path, condition: str, folder: Path) -> float:
    """Seconds until a browser that runs has a page [s]."""
    with Chromium(folder / "opening") as browser:
        began = time.perf_counter()
        browser("Page.navigate", url=page.as_uri())
        browser.until(condition)
        return time.perf_counter() - began


def long(name: str, settings: list[str], folder: Path) -> None:
    """Rows of a long recording: both documents made, and open."""
    path = folder / "long.mcap"
    run(load(LIFT[0], settings), path, in_process=True, force=True)
    for what, make, condition in (
        ("page", view, "document.documentElement?.dataset.ready === 'yes'"),
        ("report", report, "document.readyState === 'complete' && [...document.images].every(x => x.complete)"),
    ):
        began = time.process_time()
        made = make(path, folder / f"{what}.html", force=True)
        row(f"{name}: {what} is made, processor time", time.process_time() - began, "s", at_most=OPEN_s)
        row(f"{name}: {what}", made.stat().st_size / 1e6, "MB")
        if CHROMIUM is not None:
            row(f"{name}: seconds until the {what} is there", opened(made, condition, folder), "s", at_most=OPEN_s)


def main() -> None:
    options(__doc__ or "")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = Path(folder) / "run.mcap"
        run(load(*LIFT), path, in_process=True)
        page = view(path, path.with_suffix(".html"))
        size = page.stat().st_size * 3600.0 / float(Recording(path).fact("sim_s"))
        if CHROMIUM is None:
            print("there is no Chromium, so no page is played: install chromium", file=sys.stderr)
        else:
            rate, level, cost, idle, opened = played(page, Path(folder))
            row("pictures a second", rate, "1/s", "the same page at rest", idle, at_least=FRAMES_per_s, absolute=True)
            row("seconds until the page is there", opened, "s", at_most=OPEN_s, absolute=True)
            row("processor time of a picture", 1e3 * cost, "ms")
            row("level of pixels, 0 = all", level)
    if not SHORT:  # seconds of a lift say nothing of an hour
        row("page of an hour", size / 1e6, "MB", at_most=HOUR_bytes / 1e6)
    for name, settings in LONG.items():
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            long(name, settings, Path(folder))


if __name__ == "__main__":
    main()
