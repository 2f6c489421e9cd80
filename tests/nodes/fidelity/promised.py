"""Is what is promised kept, on lifts of every kind?  The chosen rung and steps, against the richest rung.

`judged(seed, accuracies)` runs the lift of a seed as it is written, as it is asked at each accuracy, and as truly as
the kernel can: four lumps a rope, steps of dop853 at 1e-9.  A run that chooses four lumps is judged against eight.
`rough`: two lumps at 1e-6, to see that all of this works.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cache
from math import inf
from random import Random

from heavylift.kernel.errors import HeavyliftError
from heavylift.nodes.fidelity import ASKABLE
from heavylift.nodes.scene import parse
from lifted import lifted
from lifts_of_kinds import Drawn, lift_of_kinds
from measuring import Seen, apart

STEPS, ROUGH = ["method=dop853", "tolerance=1e-9"], ["method=dop853", "tolerance=1e-6"]
STILL = ("set down", "drop", "different speeds")  # kinds that swing only where something moves sideways


@dataclass(frozen=True)
class Judged:
    """One lift at one accuracy: errors of what it asks, measured and predicted, whether they are promised, the rung,
    method and tolerance, cost and that of the scene without a question [evaluations x states]; or why it failed."""

    seed: int
    kinds: tuple[str, ...]
    accuracy: float
    errors: dict[str, float]
    predicted: dict[str, float]
    notes: tuple[str, ...]
    rung: str
    cost: int
    plain: int
    seconds: float = 0.0
    failed: str = ""

    @property
    def worst(self) -> float:
        """Largest measured error relative to the accuracy; infinite where the run failed."""
        return inf if self.failed else max(self.errors.values()) / self.accuracy


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
def truth(seed: int, lumps: int = 4, rough: bool = False) -> Seen:
    """The lift of a seed on the richest rung, in fine steps."""
    rung = [richest(2), *ROUGH] if rough else [richest(lumps), *STEPS]
    scene = parse(lift_of_kinds(seed).text, overrides=rung)
    return Seen.of(scene, lifted(scene))


def judged(seed: int, accuracies: tuple[float, ...], rough: bool = False) -> list[Judged]:
    """The lift of a seed at each accuracy."""
    drawn = lift_of_kinds(seed)
    scene = parse(drawn.text)
    plain = lifted(scene).cost
    return [_judged(seed, drawn, accuracy, plain, rough) for accuracy in accuracies]


def _judged(seed: int, drawn: Drawn, accuracy: float, plain: int, rough: bool) -> Judged:
    ask = asked_of(seed, drawn)
    overrides = [f"ask=[{', '.join(ask)}]", f"accuracy={100 * accuracy:g} %"]
    scene = parse(drawn.text, overrides=overrides)
    f, verdict = scene.plan.fidelity, scene.verdict
    ropes = f"{f.lumps} lumps" if f.ropes == "massive" else f"{f.ropes} ropes"
    rung = f"{ropes}, {f.girder} girder, {f.motion}, {scene.plan.method} at {scene.plan.tolerance:.0e}"
    steps = verdict.steps[0].errors if verdict.steps else {}
    predicted = {q: verdict.errors.get(q, inf) + verdict.chance.get(q, 0.0) + steps.get(q, 0.0) for q in ask}
    begun = time.process_time()
    try:
        run = lifted(scene)
        true = truth(seed, 8 if f.ropes == "massive" and f.lumps == 4 else 4, rough)
        errors, cost, failed = apart(Seen.of(scene, run), true), run.cost, ""
    except (HeavyliftError, KeyError, ValueError) as error:  # it did not end, or a stage has never begun
        errors, cost, failed = {}, 0, f"{type(error).__name__}: {error}"
    return Judged(
        seed, drawn.kinds, accuracy, {q: errors[q] for q in ask if q in errors}, predicted, verdict.notes, rung, cost,
        plain, time.process_time() - begun, failed,
    )  # fmt: skip
