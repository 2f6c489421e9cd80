"""Waiting times of a user of the commands, from key press to answer, on this machine.

    python tests/bench/wait.py [--json] [--short]

Commands are processes as a user starts them, `turnover` with all twelve of its own and with full recording, with an
empty cache of machine code and with a full one.  The equilibrium path is walked with compiled code that is warm, but
anew for each plan; a verdict with all clearances is timed where a run takes it, beside the kernel's time of the same
run, so a slow machine shows as such.  Least of several, as other work on the machine only ever adds; no peer does this.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from heavylift import simulate
from heavylift.coordinator import verdict
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load, parse
from heavylift.nodes.statics import StaticRun
from shared.rows import SHORT, options, row

HEAVYLIFT = [sys.executable, "-c", "from heavylift.coordinator.cli import main; main()"]
LIFT, END, TIMES = ("lift", ["end=10 s"], 1) if SHORT else ("turnover", [], 3)
CHECKED = "lift"  # two cranes
SHEDS = [f"  shed-{i}: {{box: [8 m, 20 m, 9 m], at: [{40 + 12 * i} m, 110 m, 4.5 m]}}" for i in range(4)]
COLD_s, WARM_s, GRANT_COLD_s, GRANT_WARM_s = 3.0, 1.3, 3.0, 1.5
SLOWER = 2.0  # with obstacles than without
IMPORT_s, HELP_s, CHECK_s, OBSTACLES_s = 0.1, 0.3, 0.5, 1.0
VERDICT_s, PATH_s, DOCUMENT_s, AGAIN_ms = 0.3, 1.0, 2.0, 20.0
SHARE = 25.0  # [%] of the CPU time of a run, its verdict


def least(measure: Callable[[], float], times: int = TIMES) -> float:
    return min(measure() for _ in range(times))


def command(folder: Path, *words: str) -> float:
    """Seconds until a command has ended."""
    began = time.perf_counter()
    subprocess.run([*HEAVYLIFT, *words], cwd=folder, check=True, capture_output=True)
    return time.perf_counter() - began


def imported() -> float:
    began = time.perf_counter()
    subprocess.run([sys.executable, "-c", "import heavylift"], check=True)
    return time.perf_counter() - began


def lift(folder: Path, cache: Path) -> tuple[float, float]:
    """Seconds until the first stage has begun, so that the first grants are done, and until the exit."""
    began = time.perf_counter()
    process = subprocess.Popen(
        [*HEAVYLIFT, "run", LIFT, "--force", *(f"--set={x}" for x in END)],
        cwd=folder,
        env={**os.environ, "HEAVYLIFT_CACHE": str(cache)},
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
    )
    assert process.stderr is not None
    stage, text, granted = load(LIFT).plan.actions[0].stage, "", 0.0
    for line in process.stderr:
        text += line
        granted = granted or (time.perf_counter() - began if stage in line else 0.0)
    assert process.wait() == 0, text
    assert granted, text
    return granted, time.perf_counter() - began


def checked(obstacles: int) -> float:
    """CPU seconds of all checks of a new scene, with its path at rest and its clearances."""
    sheds = "\n".join(["obstacles:", *SHEDS[:obstacles]]) if obstacles else ""
    began = time.process_time()
    scene = parse(f"heavylift: 1\nname: sheds\nextends: {CHECKED}\n{sheds}\n", passing=True)
    assert not [x for x in scene.checked(verdict.near_at_rest(scene.plan, scene.statics)) if x.state == "red"]
    return time.process_time() - began


def again() -> float:
    """Seconds of `simulate` in a process that has done it before."""
    began = time.perf_counter()
    simulate(CHECKED)
    return time.perf_counter() - began


def path() -> float:
    """Seconds of the walk along the equilibrium path."""
    rehearsal = StaticRun(load(LIFT, END).plan)
    began = time.perf_counter()
    rehearsal.walk()
    assert rehearsal.states
    return time.perf_counter() - began


@contextmanager
def judging(clock: Callable[[], float] = time.perf_counter) -> Iterator[list[float]]:
    """Seconds of each verdict."""
    found, judge = [], verdict.verdict_of_run

    def timed(*arguments):  # type: ignore[no-untyped-def]
        began = clock()
        checked = judge(*arguments)
        found.append(clock() - began)
        return checked

    with patch.object(verdict, "verdict_of_run", timed):
        yield found


def share(name: str, settings: list[str], path: Path) -> float:
    """CPU time of the verdict of a run, in per cent of that of the rest of the run."""
    with judging(time.process_time) as judged:
        scene, began = load(name, settings), time.process_time()
        run(scene, path, in_process=True, force=True)
        rest = time.process_time() - began - judged[0]
    return 100.0 * judged[0] / rest


def main() -> None:
    options(__doc__ or "")
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # as who has installed heavylift
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        row("import heavylift", least(imported), "s", at_most=IMPORT_s)
        row("heavylift --help", least(lambda: command(folder, "--help")), "s", at_most=HELP_s)
        command(folder, "check", CHECKED)
        row("check, two cranes", least(lambda: command(folder, "check", CHECKED)), "s", at_most=CHECK_s)
        (folder / "sheds.yaml").write_text("\n".join(["heavylift: 1", f"extends: {CHECKED}", "obstacles:", *SHEDS]))
        seconds = least(lambda: command(folder, "check", "sheds.yaml"))
        row("check, two cranes and four obstacles, again", seconds, "s", at_most=OBSTACLES_s)
        checked(4)
        none, one, four = (least(lambda n=n: checked(n)) for n in (0, 1, 4))  # type: ignore[misc]
        row("checks of a new scene with an obstacle, CPU", one, "s", "without", none, at_most=SLOWER)
        row("checks of a new scene with four obstacles, CPU", four, "s", "without", none, at_most=SLOWER)
        for _ in range(2):
            again()
        row("simulate, again in one process", 1e3 * least(again, 5 * TIMES), "ms", at_most=AGAIN_ms)
        cold = [lift(folder, folder / f"cache-{i}") for i in range(TIMES)]
        warm = [lift(folder, folder / "cache-0") for _ in range(TIMES)]
        for what, found, grant, end in (("empty", cold, GRANT_COLD_s, COLD_s), ("full", warm, GRANT_WARM_s, WARM_s)):
            row(f"{LIFT}, start to first grant, {what} cache", min(g for g, _ in found), "s", at_most=grant)
            row(f"{LIFT}, start to exit, {what} cache", min(e for _, e in found), "s", at_most=end)
        recording = f"{LIFT}.mcap"
        for document, words in {
            "page": ("view", "-o", "lift.html"),
            "report": ("report", "-o", "report.html"),
            "film": ("plot", "--lift", "-o", "lift.gif"),
        }.items():
            verb, *rest = words
            seconds = least(lambda verb=verb, rest=rest: command(folder, verb, recording, *rest, "--force"))  # type: ignore[misc]
            row(f"{LIFT}, {document}", seconds, "s", at_most=DOCUMENT_s)
        path()
        row(f"{LIFT}, equilibrium path", least(path), "s", at_most=PATH_s)
        verdict.prepare()
        with judging() as judged:
            runs = [run(load(LIFT, END), folder / "run.mcap", in_process=True, force=True) for _ in range(TIMES)]
        kernel = min(r.budget.kernel for r in runs)
        for name, settings in ((CHECKED, []), (LIFT, END)):
            percent = least(lambda a=name, b=settings: share(a, b, folder / "run.mcap"))  # type: ignore[misc]
            row(f"{name}, share of a run that its verdict takes", percent, "%", at_most=SHARE)
        row(f"{LIFT}, verdict", min(judged), "s", "kernel of the same run", kernel, at_most=VERDICT_s, absolute=True)


if __name__ == "__main__":
    main()
