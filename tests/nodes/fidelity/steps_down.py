"""One rung down from the rung above, for each rule: what both models of a lift are, and what the rule predicts.

`measured(seed, rule)` -> (predicted, measured) by quantity, or None where the rule does not allow its step.
"""

from __future__ import annotations

from functools import cache

from heavylift.nodes.fidelity import case as numbers
from heavylift.nodes.fidelity import rules
from heavylift.nodes.fidelity.chance import chance
from heavylift.nodes.plan import Fidelity
from heavylift.nodes.scene import parse
from lifted import lifted
from measuring import Seen, apart
from random_lifts import random_lift

ABOVE = {"ropes": "elastic", "rope_mass": "lumped", "girder": "elastic"}
RICHEST = {"ropes": "massive", "lumps": 2, "rope_mass": "lumped", "girder": "elastic"}
STIFF = ABOVE | {"girder": "rigid"}
STEPS = {
    rules.pads: STIFF | {"pads": "all"},
    rules.lumps: RICHEST | {"lumps": 4},
    rules.rope_mass: RICHEST,
    rules.girder: ABOVE,
    rules.plane: ABOVE,
    rules.idle_drives: ABOVE,
    rules.hinges: ABOVE,
}
FINE = "0.01 %"  # accuracy of the steps in time
RESOLUTION = {  # below this, two runs are not apart: of peaks, a frequency seen for 15 s
    "rope tension": 5e-4, "swing": 5e-4, "position": 3e-4, "lift-off time": 3e-4,
}  # fmt: skip


@cache
def ran(seed: int, fidelity: tuple[tuple[str, object], ...]) -> Seen:
    """The lift of a seed on a rung."""
    told = ", ".join(f"{k.replace('_', ' ')}: {v}" for k, v in fidelity)
    scene = parse(random_lift(seed), overrides=[f"fidelity={{{told}}}", f"accuracy={FINE}"])
    return Seen.of(scene, lifted(scene))


@cache
def case_of(seed: int) -> numbers.Case:
    """The numbers of the lift of a seed."""
    scene = parse(random_lift(seed))
    case = numbers.case_of(scene.plan, scene.followed)
    assert case is not None
    return case


def measured(seed: int, rule: rules.Rule) -> tuple[dict[str, float], dict[str, float]] | None:
    """Errors that the rule predicts, and those of the lift a step down against the rung above."""
    above = STEPS[rule]
    choice = rule(case_of(seed), Fidelity(**above))
    if not choice.allowed:
        return None
    below = above | choice.change
    if choice.locked:
        below["locked"] = f"[{', '.join(choice.locked)}]"
    predicted = {q: choice.errors.get(q, 0.0) + chance(case_of(seed)).get(q, 0.0) for q in RESOLUTION}
    return predicted, apart(ran(seed, tuple(below.items())), ran(seed, tuple(above.items())))
