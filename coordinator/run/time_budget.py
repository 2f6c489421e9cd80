"""The best accuracy that this machine reaches in a given time, as ordinary settings of the scene.

What a run costs is predicted: the operations of the kernel by `fidelity`, samples by their number, the rest is alike in
all runs.  Seconds of each were measured on one machine; a probe of a few milliseconds tells how fast another one is,
and what a run has taken is kept for the next one of the same plan.  All of that only chooses the settings: a run that
repeats them gives the same digest anywhere, however long it takes.
"""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from math import ceil, inf, log10
from pathlib import Path
from statistics import median

import msgspec
from heavylift.kernel.cache import cache_folder, read_cached, write_cached
from heavylift.kernel.errors import SceneError
from heavylift.nodes.fidelity.verdict import Verdict, percent
from heavylift.nodes.plan.fidelity import Asked, Question
from heavylift.nodes.plan.plan import Plan, encode
from heavylift.nodes.scene import LoadedScene, load
from heavylift.nodes.scene.text.units import DURATION

IMPORTED = time.perf_counter()
USUAL: tuple[Asked, ...] = ("rope tension",)  # what is meant where a scene asks for nothing
ACCURACIES = (0.1, 0.05, 0.03, 0.02, 0.01, 0.005, 0.003, 0.002, 0.001, 0.0005, 0.0003)
PROBE_s = 3.5e-3  # what `_probe` takes on the machine of the next three
OPERATION_s, SAMPLE_s, REST_s = 2.8e-8, 1.5e-4, 1.4  # of a predicted evaluation of one state, of a sample, of a run
SPARE = 0.93  # of the time, for what no prediction knows


class Spent(msgspec.Struct, array_like=True):
    """Seconds that a run has taken once its scene was ready: of its kernel, and all others."""

    kernel: float
    rest: float


@dataclass(frozen=True)
class Within:
    """A scene with the settings that fit, what is to be told before it runs, and who keeps what it took."""

    scene: LoadedScene
    told: str
    known: str  # name of the file that keeps it
    code: frozenset[str]  # files of machine code before the run

    def took(self, seconds: float, kernel: float) -> None:
        """Keep what the run has taken, that of the kernel among it; of what is alike in all runs the least.  A run that
        had to compile says nothing of the next one."""
        if _code() != self.code:
            return
        now, before = Spent(kernel, seconds - kernel), _spent(self.known)
        if before is not None:
            now = Spent(0.5 * (before.kernel + now.kernel), min(before.rest, now.rest))
        write_cached(self.known, msgspec.msgpack.encode(now))


def budget(
    name: str | Path,
    settings: Sequence[str],
    within: str = "",
    factor: float | None = None,
    rate: float | None = None,
    in_process: bool = False,
) -> Within:
    """The scene at the best accuracy for a time from the start of this process to its end, or for `factor` simulated
    seconds in each of them; raises SceneError where nothing is predicted, or the time is too short for anything."""
    option = f"--within '{within}'" if within else f"--real-time {factor:g}"
    if (within and factor is not None) or rate is not None:
        raise SceneError(f"{option}: give one of --within, --real-time and --rate")
    if any(setting.partition("=")[0].strip() == "accuracy" for setting in settings):
        raise SceneError(f"{option}: it chooses the accuracy; leave the setting 'accuracy' out")
    if factor is not None and not 0.0 < factor < inf:
        raise SceneError(f"{option}: give a number above 0, such as 1000")
    seconds = 0.0
    if within:
        try:
            seconds = DURATION.read(within)
        except ValueError as error:
            raise SceneError(f"{option}: {error}") from None
    began = elapsed()
    base = load(name, settings)
    again = elapsed() - began  # to load it with other settings takes no longer
    ask = base.scene.ask or USUAL
    if factor is not None:
        seconds = lasts(base) / factor
        option = f"{option}, that is {seconds:.3g} s"
    speed = _probe() / PROBE_s

    @cache
    def takes(accuracy: float) -> float:
        """Seconds of a run whose scene is ready, at an accuracy."""
        verdict = base.answering(Question(ask, accuracy))
        if verdict.unknown and not verdict.cost:
            raise SceneError(f"{option}: nothing is predicted here: {verdict.unknown}; leave it out")
        if verdict.notes:
            return inf  # not promised
        name = _known(base.modelled(verdict), in_process)
        return _predicted(verdict, base.plan, lasts(base), speed, _spent(name))

    left = SPARE * seconds - again
    accuracy = _finest(lambda at: elapsed() + takes(at) <= left)
    if accuracy is None:
        cheapest = min(ACCURACIES, key=takes)
        needed = _up((elapsed() + takes(cheapest) + again) / SPARE)
        to = f"{', '.join(ask)} to {percent(cheapest)}"
        raise SceneError(f"{option}: too short, for {to} this machine needs about {needed} s; give it more")
    chosen = [*settings, f"ask=[{', '.join(ask)}]", f"accuracy={percent(accuracy)}"]
    scene = load(name, chosen)
    known = _known(scene.plan, in_process)
    assert scene.verdict is not None
    whole = elapsed() + _predicted(scene.verdict, scene.plan, lasts(scene), speed, _spent(known))
    same = " ".join(f"--set '{x}'" for x in chosen[-2:])
    new = "" if _spent(known) else "; the first time its machine code may have to be made, which takes longer"
    told = f"{option}: {', '.join(ask)} to {percent(accuracy)}, about {whole:.2g} s in all{new}; the same run: {same}"
    return Within(scene, told, known, _code())


def _finest(fits: Callable[[float], bool]) -> float | None:
    """Of the accuracies that fit the finest, looked for as if a finer one never cost less; all others if none was."""
    found, rest = None, list(ACCURACIES)
    while rest:
        middle = len(rest) // 2
        if fits(rest[middle]):
            found, rest = rest[middle], rest[middle + 1 :]
        else:
            rest = rest[:middle]
    return found or next((x for x in reversed(ACCURACIES) if fits(x)), None)


def lasts(scene: LoadedScene) -> float:
    """Simulated seconds of a run, about."""
    if scene.plan.end is not None:
        return scene.plan.end
    return max((state.t for state in scene.states), default=0.0)


def elapsed() -> float:
    """Seconds since this process was started, whatever it was before it became this program."""
    try:
        stat = Path("/proc/self/stat").read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()
        return time.clock_gettime(time.CLOCK_BOOTTIME) - int(stat[19]) / os.sysconf("SC_CLK_TCK")
    except (OSError, AttributeError, IndexError):  # not Linux
        return time.perf_counter() - IMPORTED


def _predicted(verdict: Verdict, plan: Plan, simulated: float, speed: float, spent: Spent | None) -> float:
    """Seconds of a run whose scene is ready."""
    if spent is not None:
        return spent.kernel + spent.rest
    assert verdict.cost is not None
    return speed * (REST_s + OPERATION_s * verdict.cost.product + SAMPLE_s * plan.samples_hz * simulated)


def _known(plan: Plan, in_process: bool) -> str:
    how = b"one" if in_process else b"many"
    return f"{hashlib.sha256(how + encode(plan)).hexdigest()}.time"


def _spent(name: str) -> Spent | None:
    try:
        return msgspec.msgpack.decode(read_cached(name), type=Spent)
    except msgspec.MsgspecError:
        return None


def _code() -> frozenset[str]:
    """Names of the files that hold machine code."""
    try:
        return frozenset(
            name
            for name in os.listdir(cache_folder())
            if not name.endswith((".time", ".path", ".verdict", ".modelled"))
        )
    except OSError:
        return frozenset()


def _probe() -> float:
    """Seconds of a piece of work that is always the same."""
    times = []
    for _ in range(5):
        began = time.perf_counter()
        sum(i * i for i in range(60_000))
        times.append(time.perf_counter() - began)
    return median(times)


def _up(seconds: float) -> str:
    """Rounded up to two digits."""
    unit = 10.0 ** (ceil(log10(seconds)) - 2)
    return f"{ceil(seconds / unit) * unit:.3g}"
