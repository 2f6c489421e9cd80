"""The best accuracy that this machine reaches in a given time, as ordinary settings of the scene.

The cost of a run is measured in this process: from a coarse accuracy to finer ones, as long as the measurement and a
run at this accuracy fit into the time. Only the choice of settings depends on the clock: a run that repeats them has
the same digest on any machine, however long it takes.
"""

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, inf, log10
from pathlib import Path

from heavylift.coordinator.record.in_memory import CUT
from heavylift.kernel.errors import HeavyliftError, SceneError
from heavylift.nodes.plan.fidelity import Answer, Question
from heavylift.nodes.scene import LoadedScene, load
from heavylift.nodes.scene.text.units import DURATION

from .choosing import ACCURACIES, answered, choose
from .measuring import Measuring, largest
from .model_levels import Ladder, ModelLevel

IMPORTED = time.perf_counter()
COARSE = (0.1, 0.03)  # accuracies that are tried before those of `decided`
AROUND = 1.0  # [s] of a run besides its kernel: processes, recording, verdict
SPARE = 0.93  # of the time, for what nobody foresees


@dataclass(frozen=True)
class Within:
    """A scene with the model level and time steps that fit into the available wall time, and a message that announces
    these."""

    scene: LoadedScene
    message: str


def within(
    name: str | Path, settings: Sequence[str], ask: Sequence[str], seconds: str = "", factor: float | None = None,
    rate: float | None = None,
) -> Within:  # fmt: skip
    """Return the scene at the best accuracy that the available wall time allows.

    This process ends within `seconds` after its start, or the run reaches `factor` simulated seconds per wall second.

    `ask`: quantities to measure if the scene names none. Raises SceneError if the time is too short.
    """
    option = f"--within '{seconds}'" if seconds else f"--real-time {factor:g}"
    if (seconds and factor is not None) or rate is not None:
        raise SceneError(f"{option}: give only one of --within, --real-time and --rate")
    if any(setting.partition("=")[0].strip() == "accuracy" for setting in settings):
        raise SceneError(f"{option}: this option chooses the accuracy; leave out the setting 'accuracy'")
    if factor is not None and not 0.0 < factor < inf:
        raise SceneError(f"{option}: give a number greater than 0, such as 1000")
    try:
        allowed = DURATION.read(seconds) if seconds else 0.0
    except ValueError as error:
        raise SceneError(f"{option}: {error}") from None
    scene = load(name, settings)
    if not scene.facts.ask:
        scene = load(name, [*settings, f"ask=[{', '.join(ask)}]"])
    if scene.plan.models:
        raise SceneError(f"{option}: errors cannot be measured for a scene with user models; leave out the option")
    if factor is not None:
        allowed = lasts(scene) / factor
        option = f"{option}, that is {allowed:.3g} s"
    found, needed = _best(scene, allowed)
    if found is None:
        unit = 10.0 ** (ceil(log10(needed)) - 2)
        raise SceneError(
            f"{option}: the time is too short; this computer needs about {ceil(needed / unit) * unit:.3g} s"
        )
    chosen = answered(scene, found)
    same = " ".join(f"--set '{x}'" for x in ModelLevel(chosen.plan).settings[1:])
    return Within(chosen, f"{option}: {found}; the same run: {same}")


def _best(scene: LoadedScene, allowed: float) -> tuple[Answer | None, float]:
    """Return the finest answer whose run fits, or None, and the time that the coarsest needs [s]."""
    ladder, ask, takes, needed = Ladder(scene.plan, scene.facts.named), scene.facts.ask, 0.0, 2.0 * allowed
    found: Answer | None = None
    measuring = Measuring(ask, lambda: SPARE * allowed - AROUND - takes - elapsed() if found else inf)
    for accuracy in (*COARSE, *ACCURACIES):
        try:
            answer = choose(ladder, Question(ask, accuracy), measuring)
        except HeavyliftError as error:
            if CUT not in str(error):
                raise
            break
        spent = measuring.spent.get(ModelLevel(answered(scene, answer).plan).key)
        run = spent.wall_s if spent else 0.0
        if elapsed() + AROUND + run > SPARE * allowed:
            needed = (elapsed() + AROUND + run) / SPARE if found is None else needed
            break
        found, takes = answer, run
        if answer.notes or largest(answer.errors) <= ACCURACIES[-1]:
            break
    return found, needed


def lasts(scene: LoadedScene) -> float:
    """Estimate the simulated duration of a scene's run [s]."""
    return scene.plan.end if scene.plan.end is not None else max((state.t for state in scene.states), default=0.0)


def elapsed() -> float:
    """Return the time since the start of this process [s], including the start of the Python interpreter."""
    try:
        stat = Path("/proc/self/stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
        return time.clock_gettime(time.CLOCK_BOOTTIME) - int(stat[19]) / os.sysconf("SC_CLK_TCK")
    except (OSError, AttributeError, IndexError):  # not Linux
        return time.perf_counter() - IMPORTED
