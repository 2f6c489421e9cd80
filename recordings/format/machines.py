"""Cranes, slings and the block of a recorded plan, as its machines tell."""

from __future__ import annotations

from typing import Any, NamedTuple

Data = dict[str, Any]


class Hook(NamedTuple):
    """A hook by its rope; masses [kg] of its block, of what may hang below it (0: not known), of what always does."""

    rope: str
    block_mass: float
    capacity: float
    dead: float


class Crane(NamedTuple):
    """A machine with hooks; capacity of all together [kg], 0: not known; lines of its ropes by their shares."""

    name: str
    capacity: float
    hooks: list[Hook]
    bodies: list[Data]
    shares: dict[str, list[float]]
    start: float | None


def cranes(plan: Data) -> list[Crane]:
    """All of them."""
    return [_crane(machine) for machine in plan.get("machines", []) if machine.get("hooks")]


def _crane(machine: Data) -> Crane:
    hooks = []
    for hook in sorted(machine["hooks"], key=lambda hook: str(hook["rope"])):
        block = float(hook.get("block_mass", 0.0))
        hooks.append(Hook(hook["rope"], block, hook.get("capacity", 0.0), hook.get("below", 0.0) or block))
    alone = hooks[0].capacity if len(hooks) == 1 else 0.0
    capacity = next((cell.get("capacity", 0.0) for cell in machine.get("cells", [])), alone)
    shares = {rope["name"]: [x.get("share", 1.0) for x in rope["lines"]] for rope in machine["system"].get("ropes", [])}
    first: Data = next(iter(machine.get("actuators", [])), {})
    start = first.get("start", 0.0) if machine.get("girders") else None
    return Crane(machine["name"], capacity, hooks, machine["system"].get("bodies", []), shares, start)


def ties(plan: Data) -> list[Data]:
    """The slings."""
    return [tie for machine in plan.get("machines", []) for tie in machine.get("ties", [])]


def block(plan: Data) -> Data:
    """What is lifted, with its pose at the start and how many supports it has; empty if that is nothing or several."""
    found = [(machine, cargo) for machine in plan.get("machines", []) for cargo in machine.get("cargo", [])]
    if len(found) != 1:
        return {}
    (machine, cargo), system = found[0], found[0][0]["system"]
    pose = next((x["q0"] for x in system["joints"] if x["child"] == cargo["body"]), [0.0] * 7)
    return {**cargo, "name": machine["name"], "pose": pose, "supports": len(system.get("supports", []))}
