"""Every method on the rung that a random lift is given: what its steps were predicted to cost and to add, and did.

`taken(seed, accuracy)` -> one `Taken` for each method that the rule holds to be sufficient, the chosen one first.  True
is the same rung in steps a hundred times as exact as any of them, short enough to see every peak.
"""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
from heavylift.nodes.fidelity import Stepped
from heavylift.nodes.scene import parse
from kept import asked
from lifted import lifted
from measuring import Seen, apart
from random_lifts import random_lift

TRUE = {"method": "dopri5", "tolerance": 1e-10}


@dataclass(frozen=True)
class Taken:
    """A method as predicted, the quantities asked, the errors of its steps, its cost [evaluations x states]."""

    predicted: Stepped
    ask: tuple[str, ...]
    errors: dict[str, float]
    cost: float


@dataclass(frozen=True)
class _Scene:
    plan: object


def taken(seed: int, accuracy: float) -> list[Taken]:
    """Of the lift of a seed, asked to an accuracy."""
    ask = asked(seed)
    scene = parse(random_lift(seed), overrides=[f"ask=[{', '.join(ask)}]", f"accuracy={100 * accuracy:g} %"])
    left = {q: accuracy - e for q, e in scene.verdict.errors.items()}
    true = _seen(scene.plan, **TRUE)[1]
    found = []
    for steps in scene.verdict.steps:
        if steps.within(left):
            run, seen = _seen(scene.plan, method=steps.method, tolerance=steps.tolerance)
            found.append(Taken(steps, ask, apart(seen, true), run.cost))
    return found


def _seen(plan, **steps):
    scene = _Scene(msgspec.structs.replace(plan, **steps))
    run = lifted(scene)
    return run, Seen.of(scene, run)
