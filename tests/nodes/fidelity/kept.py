"""Whether `accuracy:` is kept: a random lift on the rung that is chosen for it, against the richest one in other code.

`judged(seed, accuracy)` runs both; what a scene asks is drawn by its seed.
"""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

import numpy as np
from heavylift.nodes.fidelity import ASKABLE
from heavylift.nodes.scene import parse
from lifted import lifted
from measuring import Seen, apart
from random_lifts import awaits_lifting, random_lift
from richest_lift import richest
from scipy.interpolate import CubicSpline

SAMPLES = 0.1  # [s]
RTOL = 1e-3  # of the reference: see tests/full/test_the_reference_has_converged.py
RICHEST = (
    "fidelity={ropes: massive, lumps: 4, rope mass: lumped, slings: elastic, girder: elastic, motion: spatial, "
    "pads: all, locked: []}"
)


@dataclass(frozen=True)
class Judged:
    """One scene: errors of what it asks, the rung, rules that left something out, cost [evaluations x states]."""

    seed: int
    ask: tuple[str, ...]
    accuracy: float
    errors: dict[str, float]
    predicted: dict[str, float]
    rung: str
    left_out: tuple[str, ...]
    cost: int
    richest: int | None
    without_algebra: float | None  # richest over cost, if linear algebra counted for nothing
    product: int  # evaluations x states alone
    reference: int  # the same of the independent code, which solves the richest rung by Radau's method

    @property
    def worst(self) -> float:
        """Largest measured error relative to the accuracy."""
        return max(self.errors.values()) / self.accuracy


def asked(seed: int) -> tuple[str, ...]:
    """One to all of the quantities; no time of a lift-off that the scene does not wait for, but rope tension then."""
    r = Random(f"ask {seed}")
    chosen = r.sample(ASKABLE, r.randint(1, len(ASKABLE)))
    if not awaits_lifting(seed):
        chosen = [q for q in chosen if q != "lift-off time"] or ["rope tension"]
    return tuple(q for q in ASKABLE if q in chosen)


def reference(seed: int, rtol: float = RTOL, lumps: int = 2) -> Seen:
    """The lift in code of its own; two lumps a rope show what four do, see FIDELITY.md."""
    scene = parse(random_lift(seed))
    run = richest(scene.plan, rtol=rtol, lumps=lumps)
    times, first = np.unique(run.times, return_index=True)
    grid = np.arange(0.0, times[-1], SAMPLES)
    places = CubicSpline(times, np.array(run.places)[first])(grid)
    names = [action.stage for action in scene.plan.actions] + ["finished"]
    return Seen(scene.plan, run.peaks, zip(names, [0.0, *run.ended], strict=True), grid, places, run.cost)


def judged(seed: int, accuracy: float, true: Seen | None = None, against: bool = True) -> Judged:
    """The lift of a seed, asked to an accuracy; `against`: the richest rung runs, too, in our own code with the method
    that is cheapest for it, to see what that costs."""
    ask, text = asked(seed), random_lift(seed)
    asks = [f"ask=[{', '.join(ask)}]", f"accuracy={100 * accuracy:g} %"]
    scene = parse(text, overrides=asks)
    run = lifted(scene)
    most = lifted(parse(text, overrides=[RICHEST, *asks])) if against else None
    true = true or reference(seed)
    errors = apart(Seen.of(scene, run), true)
    f, verdict = scene.plan.fidelity, scene.verdict
    left = tuple(d.choice.rule for d in verdict.decided if d.outcome == "left out")
    ropes = f"{f.lumps} lumps" if f.ropes == "massive" else f"{f.ropes} ropes"
    rung = f"{ropes}, {f.girder} girder, {f.motion}"
    return Judged(
        seed, ask, accuracy, {q: errors[q] for q in ask}, dict(verdict.errors), rung, left, run.cost,
        most.cost if most else None, most.evaluations * most.states / run.evaluations / run.states if most else None,
        run.evaluations * run.states, true.cost,
    )  # fmt: skip
