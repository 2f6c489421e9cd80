"""Models of the machines of a plan at its fidelity level, and a list of what this level leaves out."""

from heavylift.nodes.plan.mechanism import Mechanism
from heavylift.nodes.plan.plan import Plan

from . import PASSES, modelled
from .motion_given import motion_given, rides


def as_modelled(plan: Plan, machine: Mechanism) -> Mechanism:
    """Return a machine reduced to the model level of its lift or, if the lift has none of its own, of the plan."""
    lift = next((each for each in plan.lists if machine.name in each.machines), plan)
    return modelled(motion_given(machine, lift.fidelity, plan), lift.fidelity)


def exact(plan: Plan) -> dict[str, str]:
    """Return those simplifications of a plan's model level that leave the motion unchanged, each with the reason."""
    return {each.name: why for each in PASSES if (why := each.guard(plan))}


def left_out(plan: Plan) -> tuple[str, ...]:
    """Return, in words, the effects that the model level of a plan leaves out."""
    at, none = plan.fidelity, exact(plan)
    heavy = "ropes" not in none
    words = [
        ("girder rigid", at.girder == "rigid" and any(machine.girders for machine in plan.machines)),
        (
            "elastic parts rigid",
            at.girder == "rigid" and any(not row.stiffness for m in plan.machines for row in m.bends),
        ),
        ("drives stiff", at.girder == "rigid" and "drives" not in none),
        ("ropes rigid", at.ropes == "rigid" and heavy),
        ("slings rigid", at.slings == "rigid" and "slings" not in none),
        ("ropes without mass", heavy and at.ropes != "massive" and at.rope_mass == "none"),
        ("rope mass lumped at the ends", heavy and at.ropes != "massive" and at.rope_mass == "lumped"),
        (f"each rope of {at.lumps} lumps", heavy and at.ropes == "massive"),
        (f"motion {at.motion} the rails alone", at.motion != "spatial" and "motion" not in none),
        (f"{len(at.locked)} joint{'s' * (len(at.locked) > 1)} locked", bool(at.locked) and "locked" not in none),
        ("memory of radiated waves", at.water == "one frequency" and "water" not in none),
        (
            "drift of vessels, and their motion under loads",
            at.water == "motion given" and any(map(rides, plan.machines)),
        ),
        ("supports of other faces", at.pads == "standing" and "supports" not in none),
    ]
    return tuple(word for word, out in words if out)
