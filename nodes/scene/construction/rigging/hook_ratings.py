"""Limits of machines with hooks: loads of single hooks, of several hooks and of the whole machine, ropes, off-lead,
travel.

The source of a number is the scene if a parameter in the scene gives it, else the machine type.
"""

from collections.abc import Iterator
from typing import Any

from heavylift.kernel.description.mechanics import WORLD
from heavylift.nodes.limits.reeving import ROLLING, drum_ends, lead_factor
from heavylift.nodes.limits.standards import ISO_4308, ROPE_FACTORS, strength_limits
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.connections import beneath, carried_hooks, is_root
from heavylift.nodes.plan.limit import Quantity, RatedLimit
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.keys.base import written
from heavylift.nodes.scene.keys.parts.mechanics import HookKeys
from heavylift.nodes.scene.text.source import Path

WAYS: dict[str, Quantity] = {"off_lead_along": "off-lead along", "off_lead_across": "off-lead across"}
OF_BOOMS = {"off_lead_along": "in the plane of the boom", "off_lead_across": "side lead: across the plane of the boom"}
IN_LIMITS = "as in limits"  # how far a rope of one way may lead
MOMENT_OF_BRAKE = {"quantity": "brake moment", "over": ""}
TRAVELS: dict[tuple[float, float, float], tuple[Quantity, str]] = {
    (1.0, 0.0, 0.0): ("rails", "along"),
    (0.0, 1.0, 0.0): ("girder", "across"),
}


def hook_limits(builder: SceneBuilder, machine: plan.Mechanism) -> Iterator[RatedLimit]:
    """Yield all limits of a machine with hooks."""
    rows = _Rows(builder, machine)
    hooks = [_Hook(rows, hook) for hook in sorted(machine.hooks, key=lambda hook: hook.rope)]
    for hook in hooks:
        yield hook.load()
    yield from _together(rows)
    for hook in hooks:
        yield from hook.roped()
    for hook in hooks:
        yield from hook.leads()
    yield from _travels(rows)
    for hook in hooks:
        yield from hook.ends()


class _Rows:
    """The keys of a machine, and the rows of the table of limits that are made from them."""

    def __init__(self, builder: SceneBuilder, machine: plan.Mechanism) -> None:
        self.yard, self.machine = builder, machine
        self.keys: Any = builder.scene.machines.get(machine.name) or builder.scene.mechanism
        self.base: Path = ("machines", machine.name) if machine.name in builder.scene.machines else ("mechanism",)

    def row(self, path: Path, place: str, /, **more: object) -> RatedLimit:
        """Return the limit whose value a key of the machine gives.

        The source of the limit is the scene if a parameter in the scene sets the key, else the type; `place`: line of
        the part in the type."""
        at, crane = (*self.base, *path), self.yard.scene.cranes.get(self.machine.name)
        source = f"type {crane.type}" if crane else "its type"
        if self.yard.source.written(at) != at:
            source, place = "the scene", self.yard.source.where(at)
        return RatedLimit(**{"source": source, "where": place, **more})  # type: ignore[arg-type]

    def missing(self, path: Path, message: str) -> dict[str, str]:
        """Return the note of a limit without a value: the name of the parameter that would set it, or `message`."""
        offered = self.yard.source.offered.get((*self.base, *path))
        return {"note": f"give '{offered}'" if offered else message, "source": ""}

    def part(self, body: str) -> str:
        """Return the name by which reports call a body with hooks: that of the machine, or machine and part."""
        name = self.machine.name
        return name if is_root(self.machine, body) else f"{name} {body.rpartition('.')[2]}"


class _Hook:
    """A hook of a machine, with its keys and the limits made from them."""

    def __init__(self, rows: _Rows, hook: plan.Hoist) -> None:
        self.rows, self.yard, self.hook, self.name = rows, rows.yard, hook, hook.rope
        self.given: HookKeys = rows.keys.hooks[hook.rope]

    def row(self, quantity: Quantity, unit: str, key: str, **more: object) -> RatedLimit:
        """Return the limit whose value a key of the hook gives."""
        of = {"subject": self.name, "quantity": quantity, "unit": unit, "elements": (self.name,), **more}
        return self.rows.row(("hooks", self.name, written(key)), self.hook.where, **of)

    def load(self) -> RatedLimit:
        """Return the limit of the load on the hook."""
        given, hook = self.given, self.hook
        if hook.chart:
            note = "with hook block; the next longer radius counts"
            return self.row("hook load", "kg", "capacity_chart", chart=hook.chart, over="radius", note=note)
        if given.capacity_by_place:
            chart = tuple(given.capacity_by_place)
            return self.row("hook load", "kg", "capacity_by_place", chart=chart, over="trolley")
        note = "" if given.capacity else "give its hook a 'capacity'"
        return self.row("hook load", "kg", "capacity", value=given.capacity, note=note)

    def roped(self) -> Iterator[RatedLimit]:
        """Yield the limits of the hook's rope and drum."""
        given, (_, _, message) = self.given, reeving(self.given)
        factor, source = rope_factor(given)
        if given.fall_breaking:
            yield self.row(
                "rope factor", "", "rope_factor", value=factor, least=True, factor=factor, source=source, note=message,
                breaking=given.fall_breaking,
            )  # fmt: skip
            note = "less the weight of its falls at the start"
            yield self.row(
                "rope tension", "N", "rope_factor", value=self.hook.rated, factor=factor, source=source, note=note
            )
            partial = given.rope_partial_factor
            by = self.row("rope peak", "N", "rope_partial_factor").source
            own = {"rope_partial_factor": (partial, by, message)} if partial else {}
            yield from strength_limits("hoist rope", self.name, given.fall_breaking, self.hook.where, own, message)
        else:
            yield self.row("rope tension", "N", "fall_breaking", note="give its hook a 'fall breaking'", source="")
        none = self.rows.missing(("hooks", self.name, "drum pull"), "its type states none")
        pull = {"value": given.drum_pull, "note": message} if given.drum_pull else none
        yield self.row("drum pull", "N", "drum_pull", **pull)

    def leads(self) -> Iterator[RatedLimit]:
        """Yield the limits of the hook's off-lead: along and across rails or boom, or in any direction."""
        limits, boom = self.yard.scene.limits, self.hook.axis is not None
        keys = [x for x in WAYS if getattr(self.given, x) is not None or (boom and getattr(limits, x) is not None)]
        for key in ["off_lead"] * (len(keys) < len(WAYS)) + keys if boom else keys or ["off_lead"]:
            own, scene, found = getattr(self.given, key, None), getattr(limits, key), dict[str, object]()
            own = IN_LIMITS if own is None else own
            if own == IN_LIMITS:
                own, written = limits.off_lead if scene is None else scene, {key, "off_lead"} & limits.model_fields_set
                where = self.yard.source.where(("limits",)) if written else self.rows.machine.where
                found = {"source": "the scene" if written else "assumed", "where": where}
            note = "the machine's limit is unknown" if own == "unknown" else OF_BOOMS.get(key, "") if boom else ""
            value = None if own == "unknown" else own
            yield self.row(WAYS.get(key, "off-lead"), "rad", key, value=value, note=note, **found)

    def ends(self) -> Iterator[RatedLimit]:
        """Yield the limits of the hook's height and of the rope length on its winch."""
        if self.given.highest is not None:  # else its shortest rope is the upper end
            yield self.row("hook height", "m", "highest", value=self.given.highest)
        winch = next((a for a in self.rows.machine.actuators if a.name == self.name), None)
        if winch is not None and winch.lower is not None and winch.upper is not None:
            yield self.row("rope length", "m", "longest", between=(winch.lower, winch.upper))


def reeving(given: HookKeys) -> tuple[int, float, str]:
    """Return the number of rope ends on the drum, the efficiency of a sheave, and a sentence about these numbers.

    The sentence marks assumed values."""
    ends = drum_ends(given.falls, given.drum_ends)
    efficiency = given.sheave_efficiency or ROLLING
    lead = lead_factor(given.falls, ends, efficiency)
    distances = f"{ends} drum end{'s' if ends > 1 else ''}{'' if given.drum_ends else ' (assumed)'}"
    sheaves = f"sheave efficiency {efficiency:g}{'' if given.sheave_efficiency else ' (assumed)'}"
    return ends, efficiency, f"{given.falls} falls, {distances}, {sheaves}: lead part {lead:.3f} of the mean"


def rope_factor(given: HookKeys) -> tuple[float, str]:
    """Return the required design factor of a hoist rope, and its source."""
    if given.rope_factor is not None:
        return given.rope_factor, "the scene"
    own = "mechanism_group" in given.model_fields_set
    return ROPE_FACTORS[given.mechanism_group], f"{ISO_4308}, {given.mechanism_group}{'' if own else ', assumed'}"


def _together(rows: _Rows) -> Iterator[RatedLimit]:
    """Yield the limits of the total load of several hooks, on one part or on the whole machine; they are reduced in
    tandem lifts."""
    machine, cells = rows.machine, rows.keys.load_cells if rows.keys else {}
    for body, x in sorted(cells.items(), key=lambda item: is_root(machine, item[0])):
        ropes = tuple(hook.rope for hook in carried_hooks(machine, body))
        of = {"subject": rows.part(body), "unit": "kg", "elements": ropes}
        key, most, quantity, note = "capacity", x.capacity, "crane load", ""
        if not is_root(machine, body):
            quantity = "trolley load"
        elif rows.yard.tandem and x.tandem < 1.0:
            key, most, quantity = "tandem", x.capacity * x.tandem, "tandem load"
            note = f"{x.tandem:.0%} of its {x.capacity / 1e3:g} t as two cranes lift together"
        if ropes:
            path = ("load cells", body, key)
            yield rows.row(path, machine.where, value=most, quantity=quantity, note=note, **of)
    if len(machine.hooks) > 1 and not cells:
        every, message = tuple(hook.rope for hook in machine.hooks), "its type states none of all its hooks together"
        yield RatedLimit(
            subject=machine.name, quantity="crane load", unit="kg", elements=every, note=message, where=machine.where
        )


def _travels(rows: _Rows) -> Iterator[RatedLimit]:
    """Yield the travel limits of hooks along x or y of the world, and the limits of the drives that carry hooks:
    horizontal rope forces, and moments about axes of rotation."""
    machine, driven = rows.machine, {drive.joint: drive.name for drive in rows.machine.system.drives}
    actuators = {actuator.name: actuator for actuator in machine.actuators}
    turned = {hook.rope for hook in machine.hooks if not _straight(machine, hook.on)}
    crane = machine.hooks or rows.base[0] == "machines"
    for joint in machine.system.joints if crane else ():
        along = TRAVELS.get(joint.axis) if joint.kind == "prismatic" else None
        actuator = actuators.get(driven.get(joint.name, ""))
        every = [hook.rope for hook in carried_hooks(machine, joint.child)]
        if actuator is None or rows.keys is None:
            continue
        ropes = tuple(rope for rope in every if rope not in turned) if along else ()
        (quantity, over), drive, subject = along or ("", ""), rows.keys.drives[actuator.name], rows.part(joint.child)
        of: dict[str, Any] = {"quantity": "side force", "unit": "N", "over": over, "elements": ropes}
        if joint.kind == "revolute":
            of = {"unit": "N m", "elements": (joint.child,)}
        for key, does in (("force", "its drive moves"), ("brake", "its brake holds")) if every else ():
            path, most = ("drives", actuator.name, key), getattr(drive, key)
            note = {"note": does} if most else rows.missing(path, f"its type states no '{key}' of {actuator.name}")
            if not of["elements"]:
                most, note = None, {"note": f"{actuator.name} does not slide along x or y of the world", "source": ""}
            if joint.kind == "revolute":  # a drive also starts what a brake only holds
                of |= {"quantity": "drive moment", "over": "start"} if key == "force" else MOMENT_OF_BRAKE
            yield rows.row(path, actuator.where, subject=subject, value=most, **of, **note)
        if along and actuator.lower is not None and actuator.upper is not None:
            of = {"quantity": quantity, "unit": "m", "elements": (joint.child,)}
            between, path = (actuator.lower, actuator.upper), ("drives", actuator.name, "range")
            yield rows.row(path, actuator.where, subject=subject, between=between, **of)


def _straight(machine: plan.Mechanism, body: str) -> bool:
    """Return whether a body is connected to the world by sliding or fixed joints only."""
    below = [*beneath(machine, body)]
    stands = below[-1].parent == WORLD if below else body == WORLD
    return stands and all(joint.kind in ("prismatic", "fixed") for joint in below)
