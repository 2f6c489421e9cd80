"""Models of a plan that a plan of equal structure takes over: ports and couplings stay, numbers of mechanics change.

Two machines are alike if each number is zero in both or in neither, and if all else that actors are made from is equal.
"""

from collections.abc import Mapping
from typing import Any

from heavylift.kernel.description.field_types import field_names
from heavylift.kernel.description.mechanics import GROUPS, System
from heavylift.nodes.devs import Coupled, Model
from heavylift.nodes.plan.mechanism import Mechanism
from heavylift.nodes.plan.plan import Plan

from .assembly import CommanderModel, NodeModel
from .commander.actuator_registry import machines as machine_names, turns
from .commander.commander import Commander
from .commander.conditions import watched
from .levels.listing import as_modelled
from .machine import MachineModel
from .parts.parts import BodyAtomic, JointAtomic, Part

UNREAD = {"limits", "gear", "place", "accepts_assumed"}  # fields of a plan that no model reads
TAKEN = {"actions", "end"}  # those that the commander takes with the plan, if its ports and the watchers stay
DECLARED = {"system", "cargo", "shapes", "heavy", "bends", "servos", "footing", "configuration", "lacks"}
CARGO = ("body", "faces", "turned")  # what actors know of lifted bodies


def taken_over(models: Mapping[str, NodeModel], old: Plan, new: Plan) -> bool:
    """Give the models of the plan `old` the numbers of the plan `new`; if more differs, return False and change
    nothing."""
    fields = (name for name in Plan.__struct_fields__ if name not in {"machines", *UNREAD, *TAKEN})
    if any(getattr(old, name) != getattr(new, name) for name in fields) or old.lists or old.models or old.driven:
        return False
    if watched(old) != watched(new) or turns(old) != turns(new) or machine_names(old) != machine_names(new):
        return False
    machines = {x.name: as_modelled(new, x) for x in new.machines}
    own = {name: model for name, model in models.items() if isinstance(model, MachineModel)}
    if own.keys() != machines.keys() or not all(_alike(x.mechanism, machines[name]) for name, x in own.items()):
        return False
    for model in models.values():
        if isinstance(model, MachineModel):
            _renumber(model, machines[model.name])
        elif isinstance(model, CommanderModel):
            for child in model.children.values():
                if isinstance(child, Commander):
                    child.take(new)
    return True


def _alike(old: Mechanism, new: Mechanism) -> bool:
    """Return whether models of a machine fit another one after its numbers were exchanged."""
    if old is new:
        return True
    if any(getattr(old, name) != getattr(new, name) for name in Mechanism.__struct_fields__ if name not in DECLARED):
        return False
    if _read(old) != _read(new):
        return False
    return _same(old.system, new.system)


def _read(machine: Mechanism) -> list[object]:
    """Return what actors are made from beside the fields that are compared as they are."""
    named = {x.name for x in machine.actuators}  # other winches start at the lengths of their ropes
    starts = [(x.name, x.L0) for x in machine.system.all_ropes if x.winch and x.name not in named]
    return [machine.system.gravity, starts, *(getattr(x, name) for x in machine.cargo for name in CARGO)]


def _same(a: Any, b: Any) -> bool:
    """Return whether two descriptions differ in numbers only, none of which is zero in one of them alone."""
    if a is b:
        return True
    if type(a) is not type(b):
        return False
    if isinstance(a, float):
        return bool((a == 0.0) == (b == 0.0))
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(_same, a, b))
    if names := field_names(a.__class__):
        return all(_same(getattr(a, name), getattr(b, name)) for name in names)
    return bool(a == b)


def _renumber(model: MachineModel, mechanism: Mechanism) -> None:
    """Let the parts of a machine declare the elements of a mechanism in place of their own of the same names."""
    if mechanism is model.mechanism:
        return
    given = {(group, x.name): x for group in GROUPS for x in getattr(mechanism.system, group)}
    waiting: list[Model] = [model]
    for part in waiting:  # which grows
        if isinstance(part, Coupled):
            waiting += part.children.values()
        elif isinstance(part, JointAtomic):
            part.joint = given["joints", part.joint.name]
        elif isinstance(part, BodyAtomic):
            part.body = given["bodies", part.body.name]
        elif isinstance(part, Part):
            own = {group: found for group in GROUPS if (found := getattr(part.laws, group))}
            if own:
                laws = {group: tuple(given.get((group, x.name), x) for x in xs) for group, xs in own.items()}
                part.laws = System(**laws, gravity=part.laws.gravity)
    model.adopt(mechanism)
