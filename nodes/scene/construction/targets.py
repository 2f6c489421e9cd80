"""Everything an action can give an order to, by the words a scene uses for it.

One table, so that an unknown target is answered with the nearest known one.
"""

from __future__ import annotations

from dataclasses import dataclass

from heavylift.nodes.models.mechanism import turning
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.verbs import Kind

from .yard import Yard


@dataclass(frozen=True)
class Actor:
    """What an order can address: the model that has it, its name there, its ramp [m/s2 or rad/s2], how many pulses a
    ramp without swing has, whether it turns."""

    kind: Kind
    model: str
    name: str
    accel: float = 0.0
    loader: str = ""
    turns: bool = False
    pulses: int = 0


def targets(yard: Yard, mechanism: plan.Mechanism | None) -> dict[str, tuple[Actor, ...]]:
    """Every target of this scene with its actors."""
    table: dict[str, tuple[Actor, ...]] = {}
    on_hook = {(c, h): loader for loader, (c, h) in yard.hooks.items()}
    hooks: dict[str, Actor] = {}
    for crane in yard.cranes:
        table[crane.name] = (_driven("gantry", crane.name, plan.drive_name(crane.name, "gantry"), crane.gantry),)
        for trolley in (crane.upper, crane.lower):
            drive = plan.drive_name(crane.name, trolley.name)
            actor = _driven("trolley", crane.name, drive, trolley.axis)
            table[f"{crane.name} {trolley.name} trolley"] = (actor,)
        for hook in crane.hooks:
            loader = on_hook[crane.name, hook.name]
            hooks[loader] = Actor("hook", crane.name, hook.rope, hook.accel, loader)
            table[f"{crane.name} {hook.name}"] = table[loader] = (hooks[loader],)
    for group, loaders in yard.groups.items():
        table[f"{group} hooks"] = tuple(hooks[loader] for loader in loaders if loader in hooks)
    if yard.cranes:
        table["cranes"] = tuple(table[c.name][0] for c in yard.cranes)
        for which in ("upper", "lower"):
            table[f"{which} trolleys"] = tuple(table[f"{c.name} {which} trolley"][0] for c in yard.cranes)
        table["trolleys"] = table["upper trolleys"] + table["lower trolleys"]
        table["hooks"] = tuple(hooks.values())
    for plural in ("cranes", "upper trolleys", "lower trolleys", "trolleys", "hooks"):
        if plural in table:
            table[f"all {plural}"] = table[plural]
    for sling in yard.slings:
        table[sling.name] = (Actor("sling", sling.loader, sling.name, loader=sling.loader),)
    if yard.block:
        table["block"] = (Actor("block", "block", "turn"),)
    if mechanism:
        drives = {drive.name for drive in mechanism.system.drives}
        angular = turning(mechanism)
        for actuator in mechanism.actuators:
            kind: Kind = "drive" if actuator.name in drives else "winch"
            actor = _driven(kind, mechanism.name, actuator.name, actuator, actuator.name in angular)
            table[actuator.name] = (actor,)
        for rope in (rope for rope in mechanism.system.straight_ropes if not rope.winch):
            table[rope.name] = (Actor("rope", mechanism.name, rope.name),)
        for brake in mechanism.system.brakes:
            table[brake.name] = (Actor("brake", mechanism.name, brake.name),)
        for lock in mechanism.system.locks:
            table[lock.name] = (Actor("lock", mechanism.name, lock.name),)
    table["wait"] = (Actor("none", "", "wait"),)
    return table


def _driven(kind: Kind, model: str, name: str, by: plan.Axis | plan.Actuator, turns: bool = False) -> Actor:
    return Actor(kind, model, name, by.accel, turns=turns, pulses=by.pulses)
