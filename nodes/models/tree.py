"""The model tree as text: coupled models, atomic models of joints and bodies, actors, and their ports.

Printed by `heavylift tree SCENE`; each line shows one model with its content and, in brackets, its input and output
ports as in -> out.
"""

from heavylift.nodes.devs import Coupled, InPort, Model
from heavylift.nodes.models.commander.commander import Commander
from heavylift.nodes.models.parts import parts
from heavylift.nodes.plan.plan import Plan

from .assembly import CommanderModel, build
from .machine import MachineModel
from .user_models import UserModelNode

KINDS: dict[type[Model], str] = {
    CommanderModel: "coupled: commander",
    MachineModel: "coupled: machine",
    UserModelNode: "own model",
    parts.JointCoupled: "joint coupled",
    parts.BodyCoupled: "body coupled",
    parts.Group: "actors on a part of the lift",
}


def tree(plan: Plan) -> str:
    """Return the tree of all models of a plan as text."""
    models = list(build(plan).values())
    lines = [f"{plan.name}: {len(models)} coupled models"]
    for i, model in enumerate(models):
        _draw(model, "", i == len(models) - 1, lines)
    return "\n".join(lines)


def tree_data(plan: Plan) -> dict[str, object]:
    """Return the tree as plain data: name, kind, ports and children of every model."""
    return {"name": plan.name, "children": [_data(model) for model in build(plan).values()]}


def _data(model: Model) -> dict[str, object]:
    into, out = _directions(model)
    children = list(model.children.values()) if isinstance(model, Coupled) else []
    return {"name": model.name, "kind": _kind(model), "in": into, "out": out, "children": [_data(c) for c in children]}


def _draw(model: Model, indent: str, last: bool, lines: list[str]) -> None:
    lines.append(f"{indent}{'└─' if last else '├─'} {model.name}  {_kind(model)}{_ports(model)}")
    children = list(model.children.values()) if isinstance(model, Coupled) else []
    for i, child in enumerate(children):
        _draw(child, indent + ("   " if last else "│  "), i == len(children) - 1, lines)


def _kind(model: Model) -> str:
    match model:
        case parts.JointAtomic():
            return f"joint atomic: {model.joint.kind}, {model.joint.parent} to {model.joint.child}"
        case parts.BodyAtomic():
            return f"body atomic: {model.body.mass / 1e3:g} t"
        case Commander():
            return f"commander atomic: {len(model.plan.actions)} actions"
        case parts.LiveActor():
            return f"actor: {type(model).__name__} of {model.element}"
        case parts.Actor():
            return " ".join(["actor: law", *_elements(model)])
        case _:
            return KINDS.get(type(model), type(model).__name__)


def _elements(actor: parts.Actor) -> list[str]:
    """Return the names of the laws declared by an actor."""
    laws = actor.declare()
    names = [s.name for s in laws.springs] + [s.name for s in laws.stops] + [m.name for m in laws.measured]
    return [f"of {name}" for name in names]


def _ports(model: Model) -> str:
    into, out = _directions(model)
    if orders := [name for name in out if name.startswith("order_")]:
        out = [name for name in out if name not in orders] + [f"{len(orders)} x order"]
    return f"  [{' '.join(into)} -> {' '.join(out)}]" if into or out else ""


def _directions(model: Model) -> tuple[list[str], list[str]]:
    """Return the names of a model's input ports and of its output ports."""
    into = [name for name, port in model.ports.items() if isinstance(port, InPort)]
    return into, [name for name in model.ports if name not in into]
