"""How far the machines of a plan are modelled, and what its fidelity leaves out of them."""

from __future__ import annotations

from heavylift.nodes.plan.mechanism import Mechanism
from heavylift.nodes.plan.plan import Plan

from . import modelled


def as_modelled(plan: Plan, machine: Mechanism) -> Mechanism:
    """A machine as it is modelled."""
    lift = next((each for each in plan.lists if machine.name in each.machines), plan)
    return modelled(machine, lift.fidelity)


def left_out(plan: Plan) -> tuple[str, ...]:
    """Omissions of a plan's model level, in words."""
    at, parts = plan.fidelity, plan.machines
    heavy = any(not row.why for machine in parts for row in machine.heavy)
    words = [
        ("girder rigid", at.girder == "rigid" and any(machine.girders for machine in parts)),
        ("elastic parts rigid", at.girder == "rigid" and any(machine.bends for machine in parts)),
        ("ropes rigid", at.ropes == "rigid" and heavy),
        ("slings rigid", at.slings == "rigid" and any(machine.ties for machine in parts)),
        ("ropes without mass", heavy and at.ropes != "massive" and at.rope_mass == "none"),
        ("rope mass lumped at the ends", heavy and at.ropes != "massive" and at.rope_mass == "lumped"),
        (f"each rope of {at.lumps} lumps", heavy and at.ropes == "massive"),
        (f"motion {at.motion} the rails alone", at.motion != "spatial"),
        (f"{len(at.locked)} joint{'s' * (len(at.locked) > 1)} locked", bool(at.locked)),
    ]
    return tuple(word for word, out in words if out)
