"""What a recording says of its scene at the start: how it is computed, what is rated, what hangs and stands where."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import msgspec
from heavylift.coordinator.transport.placement import Placement
from heavylift.nodes.models.levels.listing import left_out
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.spellings import BEAMS

if TYPE_CHECKING:
    from heavylift.nodes.scene import LoadedScene


def facts_of(scene: "LoadedScene", nodes: Sequence[str], placement: Placement) -> dict[str, object]:
    """All of it, by name."""
    plan = scene.plan
    return {
        "scene": plan.name,
        "seed": plan.seed,
        **({"project": scene.facts.project} if scene.facts.project else {}),
        **_asked(scene),
        "modelled": told_of(plan),
        "errors": scene.errors,
        "tolerance": f"{plan.tolerance:.6g}",
        "method": plan.method,
        **({"step": f"{plan.step:.6g} s"} if plan.step else {}),
        "samples_hz": plan.samples_hz,
        "fidelity": {key: getattr(plan.fidelity, key) for key in plan.fidelity.__struct_fields__ if key != "where"},
        **({"answer": msgspec.to_builtins(scene.answer) | {"told": str(scene.answer)}} if scene.answer else {}),
        "nodes": nodes,
        "placement": {process: list(nodes) for process, nodes in placement.processes.items()},
        "rated": rated(plan),
        "tandem": scene.facts.tandem,
        "supports": supports(plan),
        BEAMS: hanging(plan),
    }


def told_of(plan: Plan) -> str:
    """What its fidelity leaves out."""
    out = left_out(plan)
    return f"left out: {', '.join(out)}" if out else "as it is written"


def _asked(scene: "LoadedScene") -> dict[str, object]:
    """What a scene asks and how accurately; nothing of one that asks nothing."""
    if not scene.facts.ask:
        return {}
    return {"asked": ", ".join(scene.facts.ask), "accuracy": f"{100 * scene.facts.accuracy:.6g} %"}


def supports(plan: Plan) -> list[dict[str, object]]:
    """Where bodies can stand: name, body, point of it, height of the pad [m]."""
    found = [support for machine in plan.machines for support in machine.system.supports]
    return [{"name": s.name, "body": s.point.body, "p": s.point.p, "height": s.height, "on": s.on} for s in found]


def hanging(plan: Plan) -> dict[str, str]:
    """Machines that hang on the hook of another one, with its rope."""
    owners = {body.name: machine.name for machine in plan.machines for body in machine.system.bodies}
    hooks = [(machine.name, hook) for machine in plan.machines for hook in machine.hooks]
    on = {owners[hook.eye.body]: hook.rope for name, hook in hooks if owners.get(hook.eye.body, name) != name}
    return {machine.name: on[machine.name] for machine in plan.machines if machine.name in on}


ROPES = ("rope tension", "sling tension")  # limits of one rope at rest


def rated(plan: Plan) -> dict[str, float]:
    """Tension that counts as 100 % of use, per rope [N]; ropes without one are left out."""
    hooks = {hook.rope: hook.rated for machine in plan.machines for hook in machine.hooks if hook.rated}
    slings = {tie.rope: tie.rated for machine in plan.machines for tie in machine.ties if tie.rated}
    most = {q: {x.subject: x.value for x in plan.limits if x.quantity == q and x.value} for q in ROPES}
    return most["rope tension"] | hooks | slings | most["sling tension"]
