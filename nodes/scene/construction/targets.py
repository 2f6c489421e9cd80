"""All targets of orders, by the words that a scene uses for them.

They are in one table, so that the error for an unknown target can suggest the nearest known one.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from heavylift.kernel.description.units import natural
from heavylift.nodes.models.commander.turn_law import traversing
from heavylift.nodes.models.machine import turning
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.verbs import Kind, Verb
from heavylift.recordings.format.spellings import CALLED, called_of

from .scene_builder import SceneBuilder


@dataclass(frozen=True)
class OrderTarget:
    """A part of a model to which an order can be given, such as a drive, winch, brake or sling.

    `model`: the model that it belongs to; `name`: its name in the plan; `accel`: acceleration of its ramp [m/s2 or
    rad/s2]; `pulses`: number of pulses of a ramp without swing; `turns`: whether its coordinate is an angle; `verb`:
    the only verb that it accepts; `speed`: its highest speed, `loaded`: the same with a load; `emergency`: deceleration
    of stops.
    """

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
    loaded: float | None = None

    def obeys(self, verb: Verb) -> bool:
        """Return whether the target accepts orders with this verb."""
        own = (
            self.verb in ("", verb.name)
            or self.kind in ("winch", "hook")
            or verb.name == "drive"
            or verb.becomes == "stop"
        )
        fits = self.kind != "drive" or verb.units == ("turning" if self.turns else "sliding") or verb.units == "either"
        return self.kind in verb.kinds and own and fits


def targets(builder: SceneBuilder) -> dict[str, tuple[OrderTarget, ...]]:
    """Return all targets of orders in a scene: for each name, the parts to which an order to this name goes."""
    table: dict[str, tuple[OrderTarget, ...]] = {}
    on_hook = {".".join(words): frame for frame, words in builder.hooks.items()}
    for machine in builder.machines:
        _of_machine(table, machine, on_hook)
    for plural in (plural for called in CALLED.values() if (plural := f"{called}s") in table):
        every = plural.rpartition(" ")[2]
        table[every] = table[f"all {every}"] = (*table.get(every, ()), *table[plural])
    for group, frames in builder.groups.items():
        table[f"{group} hooks"] = tuple(table[frame][0] for frame in frames if frame in table)
    for beam in builder.hooks:
        for tie in builder.slings(beam):
            table[tie.rope] = (OrderTarget("sling", beam, tie.rope, beam=beam),)
    turns = any(traversing(m, hook) for m in builder.machines for hook in m.hooks)
    for name in builder.scene.all_blocks:
        table[name] = (OrderTarget("block", name, "turn") if turns else OrderTarget("load", name, "level"),)
    for interlock in builder.interlocks:
        actors = (OrderTarget("interlock", interlock.machine, interlock.name),)
        table[interlock.name] = table[interlock.name.replace(".", " ", 1)] = actors
    table |= {lift: (OrderTarget("lift", lift, lift),) for lift in builder.scene.lifts}
    table["wait"] = (OrderTarget("none", "", "wait"),)
    return table


def _of_machine(table: dict[str, tuple[OrderTarget, ...]], machine: plan.Mechanism, on_hook: Mapping[str, str]) -> None:
    """Add the targets of a machine. The name of the machine itself accepts the verbs of its drives, and those of its
    hook if it has only one. `on_hook`: frames on hooks, whose names are targets as well."""
    drives = {drive.name for drive in machine.system.drives}
    tugs = {line.name for line in machine.system.tugger_lines}
    angular = turning(machine.system)
    plurals = dict[str, list[OrderTarget]]()
    words = ["", *CALLED.values()]  # drives in their order, then winches
    for by in sorted(
        machine.actuators, key=lambda x: (x.name not in drives, words.index(called_of(x.name)[1]), natural(x.name))
    ):
        frame, turns = on_hook.get(by.name, ""), by.name in angular
        kind: Kind = "drive" if by.name in drives else "tugger" if by.name in tugs else "hook" if frame else "winch"
        actor = OrderTarget(
            kind, machine.name, by.name, by.accel, frame, turns, by.pulses, by.verb, by.speed, by.emergency, by.loaded
        )
        table[by.name] = table[by.name.replace(f"{machine.name}.", f"{machine.name} ", 1)] = (actor,)
        called = called_of(by.name)[1]
        for other in filter(None, (frame, f"{machine.name} {called}" if called else "")):
            table[other] = (actor,)
        if called:
            plurals.setdefault(f"{called}s", []).append(actor)
    for rope in (rope for rope in machine.system.all_ropes if not rope.winch and rope.name not in table):
        table[rope.name] = (OrderTarget("rope", machine.name, rope.name),)
    for brake in machine.system.brakes:
        table[brake.name] = (OrderTarget("brake", machine.name, brake.name),)
    for lock in machine.system.locks:
        table[lock.name] = (OrderTarget("lock", machine.name, lock.name),)
    moved = [table[a.name][0] for a in machine.actuators if a.verb and a.name in drives]
    hooks = [table[hook.rope][0] for hook in machine.hooks]
    for name, slings in machine.rigged.items():
        table[name] = tuple(actor for sling in slings for actor in table.get(sling, ()))
    if moved or hooks:
        table[machine.name] = (*moved, *(hooks if len(hooks) == 1 else ()))
    for plural, actors in {"cranes": moved, "hooks": hooks, **plurals}.items():
        if actors:
            table[plural] = table[f"all {plural}"] = (*table.get(plural, ()), *actors)
