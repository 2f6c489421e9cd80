"""Everything an action can give an order to, by the words a scene uses for it.

One table, so that an unknown target is answered with the nearest known one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from heavylift.nodes.models.commander.turn_law import traversing
from heavylift.nodes.models.machine import turning
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.verbs import Kind, Verb

from .scene_builder import LOWER, UPPER, SceneBuilder


@dataclass(frozen=True)
class OrderTarget:
    """What an order can address: the model that has it, its name there, its ramp [m/s2 or rad/s2], how many pulses a
    ramp without swing has, whether it turns; `verb`: the one that is its own, `speed`: its highest, if it has one;
    `emergency`: the deceleration of what stops it."""

    kind: Kind
    model: str
    name: str
    accel: float = 0.0
    beam: str = ""
    turns: bool = False
    pulses: int = 0
    verb: str = ""
    speed: float | None = None
    emergency: float | None = None

    def obeys(self, verb: Verb) -> bool:
        """Whether it can be given the verb."""
        own = self.verb in ("", verb.name) or self.kind == "winch" or verb.name == "drive" or verb.becomes == "stop"
        fits = self.kind != "drive" or verb.units == ("turning" if self.turns else "sliding") or verb.units == "either"
        return self.kind in verb.kinds and own and fits


def targets(yard: SceneBuilder, mechanisms: Sequence[plan.Mechanism]) -> dict[str, tuple[OrderTarget, ...]]:
    """Every target of this scene with its actors."""
    table: dict[str, tuple[OrderTarget, ...]] = {}
    on_hook = {f"{c}.{h}": (f"{c} {h}", beam) for beam, (c, h) in yard.hooks.items()}
    hooks: dict[str, OrderTarget] = {}
    for crane in yard.cranes:
        gantry, upper, lower, *winches = crane.actuators
        table[crane.name] = (_driven("gantry", crane.name, gantry.name, gantry),)
        for of, slide in ((UPPER, upper), (LOWER, lower)):
            table[f"{crane.name} {of} trolley"] = (_driven("trolley", crane.name, slide.name, slide),)
        for winch in sorted(winches, key=lambda winch: winch.name):
            if winch.name not in on_hook:
                hooks[winch.name] = _driven("winch", crane.name, winch.name, winch)
                table[winch.name.replace(".", " ", 1)] = table[winch.name] = (hooks[winch.name],)
                continue
            words, beam = on_hook[winch.name]
            hooks[beam] = OrderTarget("hook", crane.name, winch.name, winch.accel, beam, emergency=winch.emergency)
            table[words] = table[beam] = (hooks[beam],)
    for group, beams in yard.groups.items():
        table[f"{group} hooks"] = tuple(hooks[beam] for beam in beams if beam in hooks)
    if yard.cranes:
        table["cranes"] = tuple(table[c.name][0] for c in yard.cranes)
        for which in ("upper", "lower"):
            table[f"{which} trolleys"] = tuple(table[f"{c.name} {which} trolley"][0] for c in yard.cranes)
        table["trolleys"] = table["upper trolleys"] + table["lower trolleys"]
        table["hooks"] = tuple(hooks.values())
    for plural in ("cranes", "upper trolleys", "lower trolleys", "trolleys", "hooks"):
        if plural in table:
            table[f"all {plural}"] = table[plural]
    for beam in yard.hooks:
        for tie in yard.slings(beam):
            table[tie.rope] = (OrderTarget("sling", beam, tie.rope, beam=beam),)
    turns = yard.cranes or any(traversing(machine, hook) for machine in mechanisms for hook in machine.hooks)
    for name in yard.scene.all_blocks:
        table[name] = (OrderTarget("block", name, "turn") if turns else OrderTarget("load", name, "level"),)
    for mechanism in mechanisms:
        _of_machine(table, mechanism)
    for interlock in yard.interlocks:
        actors = (OrderTarget("interlock", interlock.machine, interlock.name),)
        table[interlock.name] = table[interlock.name.replace(".", " ", 1)] = actors
    table |= {lift: (OrderTarget("lift", lift, lift),) for lift in yard.scene.lifts}
    table["wait"] = (OrderTarget("none", "", "wait"),)
    return table


def _of_machine(table: dict[str, tuple[OrderTarget, ...]], machine: plan.Mechanism) -> None:
    """Targets of a mechanism; it can itself be given the verbs of its drives, and of its hook if it has one only."""
    drives = {drive.name for drive in machine.system.drives}
    angular = turning(machine.system)
    for actuator in machine.actuators:
        kind: Kind = "drive" if actuator.name in drives else "winch"
        actor = _driven(kind, machine.name, actuator.name, actuator, actuator.name in angular)
        table[actuator.name] = table[actuator.name.replace(f"{machine.name}.", f"{machine.name} ", 1)] = (actor,)
    for rope in (rope for rope in machine.system.all_ropes if not rope.winch):
        table[rope.name] = (OrderTarget("rope", machine.name, rope.name),)
    for brake in machine.system.brakes:
        table[brake.name] = (OrderTarget("brake", machine.name, brake.name),)
    for lock in machine.system.locks:
        table[lock.name] = (OrderTarget("lock", machine.name, lock.name),)
    moved = [table[a.name][0] for a in machine.actuators if a.verb and a.name in drives]
    hooks = tuple(table[hook.rope][0] for hook in machine.hooks)
    for name, slings in machine.rigged.items():
        table[name] = tuple(actor for sling in slings for actor in table.get(sling, ()))
    if moved or hooks:
        table[machine.name] = (*moved, *(hooks if len(hooks) == 1 else ()))
        for plural, actors in (("cranes", tuple(moved)), ("hooks", hooks)):
            if actors:
                table[plural] = table[f"all {plural}"] = (*table.get(plural, ()), *actors)


def _driven(kind: Kind, model: str, name: str, by: plan.Actuator, turns: bool = False) -> OrderTarget:
    return OrderTarget(kind, model, name, by.accel, "", turns, by.pulses, by.verb, by.speed, by.emergency)
