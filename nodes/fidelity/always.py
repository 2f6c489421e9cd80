"""What is left out of every lift whatever is asked, with the numbers of this one: one small function each.

They return a `Choice` like the rules, so that the report can name what is omitted, how many states that saves and what
it costs: bodies held by others, sheaves, air, pairs that could touch, machines that nothing connects.
"""

from __future__ import annotations

from collections.abc import Callable

from heavylift.kernel.algebra.elementary import power
from heavylift.kernel.description.forces import Wind
from heavylift.kernel.description.mechanics import System
from heavylift.nodes.plan.plan import Plan

from .lifts import lift_of
from .rules import STATES, Choice

FREE = 6  # degrees of freedom of a body that nothing holds
EFFICIENCY = 0.985  # of a sheave on roller bearings (DIN 15020)


def merged(plan: Plan, mechanics: System) -> Choice:
    """Bodies that fixed or locked joints hold: they belong to the bodies that carry them."""
    held = [j.child for j in mechanics.joints if j.kind == "fixed"]
    free = len(mechanics.bodies) - len(held)
    why = f"{len(held)} of {free + len(held)} bodies are held by others and one with them"
    return Choice("merged bodies", "", {}, STATES * FREE * len(held), {}, why)


def reeving(plan: Plan, mechanics: System) -> Choice:
    """The falls of a hook as one spring: right for their sum; friction gives the lead part more, eta the others less.

    Lead part over mean of n falls: n (1 - eta) / (1 - eta^n).
    """
    falls = [rope.falls for rope in lift_of(plan).rig.hook_ropes]
    n = max(falls, default=1)
    lead = n * (1.0 - EFFICIENCY) / (1.0 - power(EFFICIENCY, n)) - 1.0
    over = [r.name for r in mechanics.reevings]
    named = f"; {', '.join(over)}: sheave by sheave, as the scene says" if over else ""
    why = f"no friction is asked: {n} falls are one spring, of which the lead part carries {lead:.0%} more{named}"
    return Choice("sheaves", "", {}, STATES * sum(k - 1 for k in falls), {}, why)


def wind(plan: Plan, mechanics: System) -> Choice:
    """Still air, unless the scene names a wind."""
    winds = [f for f in mechanics.forces if isinstance(f, Wind)]
    if not winds:
        return Choice("wind", "", {}, 0, {}, "no wind: none is named")
    forces = []
    for w in winds:
        speed = max((abs(v) for v in (*w.signal.values, w.signal.value)), default=0.0)
        force = w.density * w.drag * w.area * speed * speed / 2.0
        forces.append(f"'{w.name}' pushes with {force / 1e3:.3g} kN at {speed:.3g} m/s")
    return Choice("wind", "", {}, 0, {}, ", ".join(forces), allowed=False)


def contact(plan: Plan, mechanics: System) -> Choice:
    """Pads meet the stool below them and no other; nothing else can touch, unless the scene names contacts."""
    every = len(lift_of(plan).block.pads) if lift_of(plan).block else 0
    standing = [pad for pad in lift_of(plan).block.pads if pad.closed] if lift_of(plan).block else []
    pairs = every * len(standing)
    kept = len(mechanics.supports)
    shapes = f"; {len(mechanics.contacts)} contacts are named" if mechanics.contacts else "; nothing else can touch"
    why = f"{kept} of {pairs} pairs of {every} pads and {len(standing)} stools{shapes}"
    return Choice("contact pairs", "", {}, 0, {}, why, allowed=pairs > kept)


def islands(plan: Plan, mechanics: System) -> Choice:
    """Machines that nothing connects have steps of their own; a group of them at rest takes none."""
    from heavylift.kernel.islands.components import (  # with arrays, which a process of a node lacks
        islands_of,
        loose_ropes,
    )
    from heavylift.nodes.models import hooked_later

    n = len(islands_of(mechanics, loose_ropes(mechanics, hooked_later(plan))))
    together = plan.fidelity.islands == "together"
    groups = f"{n} groups of machines, {'together, as the scene says' if together else 'each by itself'}"
    why = "all machines are tied together" if n == 1 else groups
    return Choice("islands", "", {}, 0, {}, why, allowed=n > 1 and not together)


ALWAYS: tuple[Callable[[Plan, System], Choice], ...] = (merged, reeving, wind, contact, islands)
