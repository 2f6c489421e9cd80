"""Is what is promised kept, on lifts of every kind?  The chosen rung and steps, against the richest rung.

`judged(seed, accuracies)` runs the lift of a seed, or what else is drawn, as it is written, as it is asked at each
accuracy, and as truly as the kernel can: four lumps a rope, steps of dop853 at 1e-9.  A run that chooses four lumps is
judged against eight, in steps of radau5 at 1e-7 where ropes are damped.
`rough`: two lumps at 1e-6, to see that all of this works.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import inf
from random import Random
from resource import RUSAGE_CHILDREN, getrusage

from heavylift.kernel import HeavyliftError
from heavylift.nodes.fidelity import ASKABLE
from heavylift.nodes.scene import LoadedScene, parse
from lifted import lifted
from lifts_of_kinds import Drawn, lift_of_kinds
from measuring import Seen, apart

STEPS, ROUGH = ["method=dop853", "tolerance=1e-9"], ["method=dop853", "tolerance=1e-6"]
STIFF = ["method=radau5", "tolerance=1e-7"]  # of eight damped lumps: explicit steps would be a sixteenth as long
Drawing = Callable[[int], Drawn]
STILL = ("set down", "drop", "different speeds")  # kinds that swing only where something moves sideways


@dataclass(frozen=True)
class Judged:
    """One lift at one accuracy: errors of what it asks, measured and predicted, whether they are promised, the rung,
    method and tolerance, CPU time of a process that runs it and that of the scene without a question [s], with machine
    code from the cache; or why it failed."""

    seed: int
    kinds: tuple[str, ...]
    accuracy: float
    errors: dict[str, float]
    predicted: dict[str, float]
    notes: tuple[str, ...]
    rung: str
    cost: float
    plain: float
    failed: str = ""

    @property
    def worst(self) -> float:
        """Largest measured error relative to the accuracy; infinite where the run failed."""
        return inf if self.failed else max(self.errors.values(), default=0.0) / self.accuracy


def asked_of(seed: int, drawn: Drawn) -> tuple[str, ...]:
    """One to all of the quantities that the lift has."""
    r = Random(f"ask {seed}")
    chosen = r.sample(ASKABLE, r.randint(1, len(ASKABLE)))
    if not drawn.awaits:
        chosen = [q for q in chosen if q != "lift-off time"]
    if drawn.kinds[0] in STILL and "traverse" not in drawn.text:
        chosen = [q for q in chosen if q != "swing"]
    return tuple(q for q in ASKABLE if q in (chosen or ["rope tension"]))


def richest(lumps: int) -> str:
    """The richest rung, as a setting."""
    return (
        f"fidelity={{ropes: massive, lumps: {lumps}, rope mass: lumped, slings: elastic, girder: elastic, "
        "motion: spatial, pads: all, locked: []}"
    )


@cache
def truth(seed: int, lumps: int = 4, rough: bool = False, draw: Drawing = lift_of_kinds) -> Seen:
    """The lift of a seed on the richest rung, in fine steps."""
    drawn = draw(seed)
    steps = STIFF if lumps > 4 and "no damping" not in drawn.kinds else STEPS
    rung = [richest(2), *ROUGH] if rough else [richest(lumps), *steps]
    try:
        return _seen(drawn, rung)
    except HeavyliftError:  # pads that stick and slip without end: once more in other steps
        return _seen(drawn, [rung[0], *STIFF])


def _seen(drawn: Drawn, settings: list[str]) -> Seen:
    scene = parse(drawn.text, overrides=settings)
    return Seen.of(scene, lifted(scene))


def judged(
    seed: int, accuracies: tuple[float, ...], rough: bool = False, draw: Drawing = lift_of_kinds
) -> list[Judged]:
    """The lift of a seed at each accuracy; levels that are modelled and solved alike share one run."""
    runs = dict[object, Outcome]()
    return [_judged(seed, draw, accuracy, rough, runs) for accuracy in accuracies]


@cache
def plain(text: str) -> float:
    """CPU time of a process that runs a scene as it is written [s]."""
    _parsed(text)  # what follows the path of the list is compiled
    scene, seconds = _parsed(text)
    return start() + seconds + lifted(scene, timed=True).seconds


@cache
def start() -> float:
    """CPU time of a process before it can load a scene [s]."""
    before = getrusage(RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", "import heavylift.coordinator.run.simulate"], check=True)
    after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def _parsed(text: str, *overrides: str) -> tuple[LoadedScene, float]:
    """The scene, and CPU time of loading it [s]."""
    begun = time.process_time()
    return parse(text, overrides=overrides), time.process_time() - begun


Outcome = tuple[dict[str, float], float, str]  # errors of each quantity, CPU time [s], why it failed


def _judged(seed: int, draw: Drawing, accuracy: float, rough: bool, runs: dict[object, Outcome]) -> Judged:
    drawn = draw(seed)
    ask = asked_of(seed, drawn)
    scene, read = _parsed(drawn.text, f"ask=[{', '.join(ask)}]", f"accuracy={100 * accuracy:g} %")
    plan, verdict = scene.plan, scene.verdict
    f, steps = plan.fidelity, verdict.steps[0].errors if verdict.steps else {}
    ropes = f"{f.lumps} lumps" if f.ropes == "massive" else f"{f.ropes} ropes"
    rung = f"{ropes}, {f.girder} girder, {f.motion}, {plan.method} at {plan.tolerance:.0e}"
    predicted = {q: verdict.errors.get(q, inf) + verdict.chance.get(q, 0.0) + steps.get(q, 0.0) for q in ask}
    alike = None if verdict.notes else (f, plan.method, plan.tolerance)
    if alike is None:  # nothing is promised
        runs[alike] = {}, inf, ""
    elif alike not in runs:
        runs[alike] = _outcome(seed, scene, 8 if f.ropes == "massive" and f.lumps == 4 else 4, rough, draw)
    errors, seconds, failed = runs[alike]
    return Judged(
        seed, drawn.kinds, accuracy, {q: errors[q] for q in ask if q in errors}, predicted, verdict.notes, rung,
        start() + read + seconds, inf if verdict.notes else plain(drawn.text), failed,
    )  # fmt: skip


def _outcome(seed: int, scene: LoadedScene, lumps: int, rough: bool, draw: Drawing) -> Outcome:
    try:
        run = lifted(scene, timed=True)
        return apart(Seen.of(scene, run), truth(seed, lumps, rough, draw)), run.seconds, ""
    except (HeavyliftError, KeyError, ValueError) as error:  # it did not end, or a stage has never begun
        return {}, 0.0, f"{type(error).__name__}: {error}"
