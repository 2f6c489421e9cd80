"""Everything an action can give an order to, by the words a scene uses for it.

One table, so that an unknown target is answered with the nearest known one.
"""

from __future__ import annotations

from dataclasses import dataclass

from heavylift.kernel.description.joint_table import JOINTS, JointType
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.verbs import Kind

from .yard import Yard


@dataclass(frozen=True)
class Actor:
    """What an order can address: the model that has it, its name there, its ramp [m/s2 or rad/s2], whether it turns."""

    kind: Kind
    model: str
    name: str
    accel: float = 0.0
    loader: str = ""
    turns: bool = False


def targets(yard: Yard, mechanism: plan.Mechanism | None) -> dict[str, tuple[Actor, ...]]:
    """Every target of this scene with its actors."""
    table: dict[str, tuple[Actor, ...]] = {}
    on_hook = {(c, h): loader for loader, (c, h) in yard.hooks.items()}
    hooks: dict[str, Actor] = {}
    for crane in yard.cranes:
        table[crane.name] = (Actor("gantry", crane.name, plan.drive_name(crane.name, "gantry"), crane.gantry.accel),)
        for trolley in (crane.upper, crane.lower):
            drive = plan.drive_name(crane.name, trolley.name)
            actor = Actor("trolley", crane.name, drive, trolley.axis.accel)
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
    if yard.block:
        table["block"] = (Actor("block", "block", "turn"),)
    if mechanism:
        joints = {joint.name: JOINTS[joint.kind] for joint in mechanism.system.joints}
        drives = {drive.name: drive for drive in mechanism.system.drives}
        for actuator in mechanism.actuators:
            by = drives.get(actuator.name)
            kind: Kind = "drive" if by else "winch"
            turns = bool(by and _turns(joints[by.joint], by.coordinate))
            actor = Actor(kind, mechanism.name, actuator.name, actuator.accel, turns=turns)
            table[actuator.name] = (actor,)
        for brake in mechanism.system.brakes:
            table[brake.name] = (Actor("brake", mechanism.name, brake.name),)
        for lock in mechanism.system.locks:
            table[lock.name] = (Actor("lock", mechanism.name, lock.name),)
    table["wait"] = (Actor("none", "", "wait"),)
    return table


def _turns(joint: JointType, coordinate: str) -> bool:
    """Whether a coordinate, by default the only one, is an angle."""
    return joint.turns(joint.actable.index(coordinate) if coordinate else 0)
