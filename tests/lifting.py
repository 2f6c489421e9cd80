"""What tests ask of a plan in which hooks lift something, and lifts of which little is stated."""

import re
from collections.abc import Sequence

from heavylift.kernel.description import Body, Check, Reeving, Rope
from heavylift.kernel.description.findings import findings
from heavylift.nodes.limits import checks_of
from heavylift.nodes.plan import Cargo, Mechanism, Plan, Tie, Use
from heavylift.nodes.scene import LoadedScene, bundled, parse

SECTIONS = ("project", "gear", "ground", "practice", "factors", "limits")
KEYS = ("lug capacity", "capacity")
GEARED = r"(sling|shackle): \{gear: [^}]*\}"


def unstated(text: str) -> str:
    """A scene without what it states only for its checks: gear, capacities, factors, limits."""
    text = re.sub(rf"^({'|'.join(SECTIONS)}):.*\n(?:[ #].*\n)*", "", text, flags=re.M)
    text = re.sub(rf"^ +(?:(?:{'|'.join(KEYS)}):.*|{GEARED})\n", "", text, flags=re.M)
    text = re.sub(rf", (?:capacity: [^}}]*|{GEARED})", "", text)
    return re.sub(r"\n{3,}", "\n\n", text)


def bare(name: str, settings: Sequence[str] = ()) -> LoadedScene:
    """A bundled lift of which no more is stated than a run needs."""
    return parse(unstated(bundled()[name].read_text(encoding="utf-8")), f"{name}.yaml", settings)


def findings_of(plan: Plan, uses: Sequence[Use], *, dynamic: bool) -> list[Check]:
    """What is beyond its limit, or should be reported, of values without errors."""
    found = findings(checks_of(plan, uses, (), {} if dynamic else None, ()))
    return [x for x in found if x.quantity != "factor sheet"]


def machine(plan: Plan, name: str) -> Mechanism:
    return next(x for x in plan.machines if x.name == name)


def cranes(plan: Plan) -> list[Mechanism]:
    return [x for x in plan.machines if x.girders]


def hook_ropes(plan: Plan) -> dict[str, Rope]:
    hooks = {hook.rope for x in plan.machines for hook in x.hooks}
    return {rope.name: rope for x in plan.machines for rope in x.system.ropes if rope.name in hooks}


def slings(plan: Plan) -> dict[str, tuple[Tie, Rope | Reeving]]:
    ropes = {rope.name: rope for x in plan.machines for rope in x.system.all_ropes}
    return {tie.rope: (tie, ropes[tie.rope]) for x in plan.machines for tie in x.ties}


def cargo(plan: Plan) -> Cargo:
    (found,) = (cargo for x in plan.machines for cargo in x.cargo)
    return found


def body(plan: Plan, name: str) -> Body:
    return next(body for x in plan.machines for body in x.system.bodies if body.name == name)


def pose(plan: Plan, name: str) -> tuple[float, ...]:
    return next(joint.q0 for x in plan.machines for joint in x.system.joints if joint.child == name)
