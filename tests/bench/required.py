"""What a lift costs of which rope tensions alone are asked, to 5, 1 and 0.3 %, beside the same lift followed in full.

    python tests/bench/required.py [--json] [--short] [--lifts 40]

The kernel's seconds of runs in one process, each asked run beside a plain one (`dopri5` at its tolerance) in turns,
which may be promised less, as its rung would be too dear, and beside `dopri5` on the same rung; and the worst peak of a
hook's rope against that rung at 1e-8.  Then whole runs from start to exit, with all their processes and full recording.
Medians of three.  Then what the rung of 5 % costs from 10 % to 1e-6: of settings of all methods the cheapest whose
worst peak is so exact, against dop853 at 1e-11.  Then random lifts of every kind (lifts_of_kinds.py), each asked what
its seed says, to 5 and to 1 %: CPU time of runs in memory, the least of three, against `dopri5` at its tolerance on the
same rung.  At last `--within` a time, twice what the cheapest run takes: of five runs the median may exceed it by a
fifth.
"""

import dataclasses
import gc
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path
from statistics import median

from heavylift.coordinator.run import run
from heavylift.coordinator.ladder.in_memory import play
from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.scene import LoadedScene, load, parse
from heavylift.recordings import Recording
from msgspec.structs import replace
from shared.rows import SHORT, options, row

sys.path.insert(0, str(Path(__file__).parents[1] / "nodes/fidelity"))
from lifts_of_kinds import lift_of_kinds
from promised import asked_of

SCENE, TIMES = ("lift", 1) if SHORT else ("turnover", 3)
KERNEL = {"5 %": 0.10, "1 %": 0.15, "0.3 %": 0.3}  # of the plain run's seconds
LEAST_s = 6.0  # that --within is given: a start on a busy machine, predicted before it is over
WHOLE_s = {"5 %": 2.0, "1 %": 2.2, "0.3 %": 3.0, "": 3.5}
PLAIN = ["method=dopri5"]
TRUE = 1e-8
LEVELS = ("5 %",) if SHORT else (*KERNEL, "")
LIFTS, SEED = (1, 3002) if SHORT else (40, 3000)
DECADES = [10.0**-n for n in range(1, 7)]
SETTINGS = {
    "radau5": ("1e-2", "1e-3", "1e-4", "1e-5", "1e-6"),
    "dopri5": ("1e-4", "1e-6"),
    "dop853": ("1e-5", "1e-7", "1e-9"),
}
RANGE = 30.0  # of what 1e-6 costs over what 10 % does
MEDIAN, DEAREST = {"5 %": 0.4, "1 %": 0.5}, 1.5  # of the plain run's time


def asking(accuracy: str) -> list[str]:
    """Settings of a scene that asks for rope tensions; as it is written with ""."""
    return ["ask=[rope tension]", f"accuracy={accuracy}"] if accuracy else []


def on_its_rung(accuracy: str, tolerance: float | None, path: Path) -> tuple[float, dict[str, float]]:
    """The same of the rung that the question gets, by `dopri5` at a tolerance, None: the one that it needs."""
    scene = load(SCENE, asking(accuracy))
    needed = {s.method: s.tolerance for s in scene.verdict.steps}["dopri5"]
    plan = replace(scene.plan, method="dopri5", tolerance=tolerance or needed)
    return measured([], path, dataclasses.replace(scene, plan=plan))


def measured(settings: list[str], path: Path, scene: LoadedScene | None = None) -> tuple[float, dict[str, float]]:
    """Seconds of the kernel, and the highest tension of each rope [N]."""
    result = run(scene or load(SCENE, settings), path, in_process=True)
    peaks = Recording(path)["rope/peak"]
    path.unlink()
    return result.budget.kernel, dict(zip(peaks.names, peaks.values.max(axis=0), strict=True))


def whole(settings: list[str], folder: Path) -> float:
    """Seconds of a run as a user starts it, to its exit."""
    command = [sys.executable, "-c", "from heavylift.coordinator.cli import main; main()", "run", SCENE, "--force"]
    began = time.perf_counter()
    subprocess.run([*command, *(f"--set={x}" for x in settings)], cwd=folder, check=True, capture_output=True)
    return time.perf_counter() - began


def within(seconds: float, folder: Path) -> float:
    """Seconds of a run that is to take so long."""
    command = [sys.executable, "-c", "from heavylift.coordinator.cli import main; main()", "run", SCENE, "--force"]
    began = time.perf_counter()
    subprocess.run([*command, "--within", f"{seconds} s"], cwd=folder, check=True, capture_output=True)
    return time.perf_counter() - began


def decades(path: Path) -> None:
    """What each further digit costs, on the rung of 5 %."""
    rung = [*asking("5 %"), "method=dop853", "tolerance=1e-11"]
    true, found = measured(rung, path)[1], list[tuple[float, float]]()
    for method, tolerances in SETTINGS.items():
        for tolerance in tolerances:
            runs = [measured([*rung[:2], f"method={method}", f"tolerance={tolerance}"], path) for _ in range(TIMES)]
            found.append((min(s for s, _ in runs), worst(runs[0][1], true)))
    cheapest = [min(s for s, error in found if error <= e) for e in DECADES]
    for e, seconds in zip(DECADES, cheapest, strict=True):
        row(f"{SCENE}, worst peak below {e:g}, kernel", seconds, "s")
    row(f"{SCENE}, kernel at {DECADES[-1]:g} over that at {DECADES[0]:g}", cheapest[-1] / cheapest[0], at_least=RANGE)


def worst(peaks: dict[str, float], true: dict[str, float]) -> float:
    """Largest relative error of the highest tensions of the hooks' ropes."""
    return max(abs(peaks[rope.name] / true[rope.name] - 1.0) for rope in load(SCENE).plan.rig.hook_ropes)


def random_lifts(count: int) -> None:
    """Each as it is asked and by `dopri5` on the same rung; what nothing is promised of is left out, and counted."""
    found: dict[str, list[float]] = {accuracy: [] for accuracy in MEDIAN}
    for seed in range(SEED, SEED + count):
        drawn = lift_of_kinds(seed)
        for accuracy, ratios in found.items():
            settings = [f"ask=[{', '.join(asked_of(seed, drawn))}]", f"accuracy={accuracy}"]
            scene = parse(drawn.text, overrides=settings)
            at = {s.method: s.tolerance for s in scene.verdict.steps} if scene.verdict else {}
            if not at or scene.verdict.notes:
                continue
            plain = replace(scene.plan, method="dopri5", tolerance=at["dopri5"])
            with suppress(HeavyliftError):
                mine, its = (min(play(p).cpu_s for _ in range(1 if SHORT else 3)) for p in (scene.plan, plain))
                ratios.append(mine / its)
    for accuracy, ratios in found.items():
        name = f"{len(ratios)} promised of {count} random lifts to {accuracy}, CPU time against dopri5"
        row(f"{name}, median", median(ratios), at_most=MEDIAN[accuracy])
        row(f"{name}, worst", max(ratios), at_most=DEAREST)


def main() -> None:
    gc.set_threshold(50_000)  # as in the command itself
    lifts = options(__doc__ or "", {"--lifts": {"type": int, "default": LIFTS, "help": "how many at random"}}).lifts
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for accuracy in filter(None, LEVELS):
            mine, plain = [], []
            for _ in range(TIMES + (not SHORT)):  # the first makes the code warm
                spent, peaks = measured(asking(accuracy), folder / "mine.mcap")
                mine.append(spent)
                plain.append(measured([*asking(accuracy), *PLAIN], folder / "plain.mcap")[0])
            followed = on_its_rung(accuracy, None, folder / "followed.mcap")[0]
            true = on_its_rung(accuracy, TRUE, folder / "true.mcap")[1]
            title = f"{SCENE}, rope tension to {accuracy}"
            seconds, most = median(mine[1:] or mine), KERNEL[accuracy]
            row(f"{title}, kernel", seconds, "s", "dopri5", median(plain[1:] or plain), at_most=most)
            row(f"{title}, kernel", seconds, "s", "dopri5 on the same rung", followed, at_most=most)
            row(f"{title}, worst peak", 100.0 * worst(peaks, true), "%", at_most=float(accuracy.removesuffix(" %")))
        for accuracy in LEVELS:
            seconds = median(whole(asking(accuracy), folder) for _ in range(TIMES))
            row(f"{SCENE}, {accuracy or 'nothing'} asked, start to exit", seconds, "s", at_most=WHOLE_s[accuracy])
        decades(folder / "decade.mcap")
        random_lifts(lifts)
        given = max(LEAST_s, 2.0 * whole(asking("5 %"), folder))
        taken = median(within(given, folder) for _ in range(1 if SHORT else 5))
        row(f"{SCENE}, --within {given:.2g} s", taken, "s", "what was given", given, at_most=1.2)


if __name__ == "__main__":
    main()
