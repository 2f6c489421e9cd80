"""Limits of what machines made of parts hold: hooks and their ropes, slings, shackles, frames, lugs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from heavylift.kernel.description.mechanics import WORLD, Vector
from heavylift.nodes.limits.reeving import ROLLING, drum_ends, lead_factor
from heavylift.nodes.limits.sharing import DETERMINATE
from heavylift.nodes.limits.slings import assembly, at_rest, in_a_run, shackle
from heavylift.nodes.limits.standards import ISO_4308, ROPE_FACTORS, TANDEM, TANDEM_SOURCE, strength_limits
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.limit import Quantity, RatedLimit
from heavylift.nodes.plan.mechanism import lug_places, ties_on
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.keys.parts.mechanics import HookKeys
from heavylift.nodes.scene.keys.parts.rigging import Equaliser, Frame, SlingKeys, SlingType
from heavylift.nodes.scene.text.source import Path, shown

from .slings import lugs_of, slings_of, terms

WAYS: dict[Vector, tuple[Quantity, str]] = {(1.0, 0.0, 0.0): ("rails", "along"), (0.0, 1.0, 0.0): ("girder", "across")}


def hook_limits(yard: SceneBuilder, machine: plan.Mechanism) -> Iterator[RatedLimit]:
    """Hooks of a machine made of parts: capacity or chart, rope, slings."""
    for hook in machine.hooks:
        given = _given(yard, machine, hook.rope)
        at = {"subject": hook.rope, "unit": "kg", "elements": (hook.rope,), "where": hook.where, "source": "its type"}
        if chart := hook.chart:
            note = "with hook block and rigging; the next longer radius counts"
            yield RatedLimit(quantity="hook load", chart=chart, over="radius", note=note, **at)  # type: ignore[arg-type]
        else:
            note = "" if given.capacity else "give its hook a 'capacity'"
            yield RatedLimit(quantity="hook load", value=given.capacity, note=note, **at)  # type: ignore[arg-type]
        yield _fall(given, at)
        winch = next((a for a in machine.actuators if a.name == hook.rope), None)
        ends = None if winch is None or winch.lower is None or winch.upper is None else (winch.lower, winch.upper)
        yield from _hoist(yard, given, at, ends)
    if len(machine.hooks) > 1:
        every, where = tuple(hook.rope for hook in machine.hooks), machine.where
        told = "its type states none of all its hooks together"
        yield RatedLimit(subject=machine.name, quantity="crane load", unit="kg", elements=every, note=told, where=where)
    yield from _travels(yard, machine)


def _travels(yard: SceneBuilder, machine: plan.Mechanism) -> Iterator[RatedLimit]:
    """Between which ends what carries hooks travels along the world's x or y, and what ropes may pull it that way."""
    keys: Any = yard.scene.machines.get(machine.name) or yard.scene.mechanism
    joints = {joint.child: joint for joint in machine.system.joints}
    driven = {drive.joint: drive.name for drive in machine.system.drives}
    carried: dict[str, tuple[str, ...]] = {}  # body -> hooks that travel with it
    for hook in machine.hooks:
        body = hook.on
        while (joint := joints.get(body)) is not None and joint.kind in ("prismatic", "fixed"):
            carried[body], body = (*carried.get(body, ()), hook.rope), joint.parent
        if body != WORLD:  # it turns
            carried = {name: tuple(rope for rope in ropes if rope != hook.rope) for name, ropes in carried.items()}
    for body, ropes in carried.items():
        way = WAYS.get(joints[body].axis) if ropes and joints[body].kind == "prismatic" else None
        name = driven.get(joints[body].name)
        actuator = next((x for x in machine.actuators if x.name == name), None)
        if way is None or actuator is None:
            continue
        quantity, over = way
        subject = machine.name if joints[body].parent == WORLD else f"{machine.name} {body.rpartition('.')[2]}"
        at = {"subject": subject, "where": actuator.where}
        if actuator.lower is not None and actuator.upper is not None:
            between = actuator.lower, actuator.upper
            yield RatedLimit(quantity=quantity, unit="m", between=between, elements=(body,), source="its type", **at)  # type: ignore[arg-type]
        for key, does in (("force", "its drive moves"), ("brake", "its brake holds")):
            most = getattr(keys.drives[name], key)
            row = {"note": does, "source": "its type"} if most else {"note": f"its type states no '{key}' of {name}"}
            yield RatedLimit(quantity="side force", unit="N", value=most, over=over, elements=ropes, **at, **row)  # type: ignore[arg-type]


def _hoist(
    yard: SceneBuilder, given: HookKeys, at: dict[str, Any], ends: tuple[float, float] | None
) -> Iterator[RatedLimit]:
    """How its rope may lead, its largest tension, and between which ends its winch moves."""
    limits = yard.scene.limits
    by = "the scene" if "off_lead" in limits.model_fields_set else "assumed"
    most = None if limits.off_lead == "unknown" else limits.off_lead
    note = "" if most is not None else "the machine's limit is unknown"
    yield RatedLimit(quantity="off-lead", value=most, note=note, **{**at, "unit": "rad", "source": by})
    if given.fall_breaking:
        yield from strength_limits("hoist rope", at["subject"], given.fall_breaking, at["where"], {})
    pull = {"value": given.drum_pull} if given.drum_pull else {"note": "its type states none", "source": ""}
    yield RatedLimit(quantity="drum pull", **{**at, "unit": "N", **pull})
    if given.highest is not None:  # else the shortest rope is the upper end
        yield RatedLimit(quantity="hook height", value=given.highest, **{**at, "unit": "m"})
    if ends is not None:
        yield RatedLimit(quantity="rope length", between=ends, **{**at, "unit": "m"})


def tandem_limits(yard: SceneBuilder, mechanisms: Sequence[plan.Mechanism]) -> Iterator[RatedLimit]:
    """Hooks of several machines that carry one load at the start: each may carry a part only of what it could alone."""
    lifting: dict[str, dict[str, list[plan.Hoist]]] = {}  # load -> machine -> hooks
    lugs, levelled = lug_places(mechanisms), {machine.name for machine in mechanisms if machine.levels}
    for machine in mechanisms:
        for hook in machine.hooks:
            for tie in ties_on(mechanisms, hook):
                if tie.lug and (held := tie.lower or lugs.get(tie.lug)):
                    lifting.setdefault(held.body, {}).setdefault(machine.name, []).append(hook)
    seen, own = set[str](), yard.scene.factors.tandem
    for hooks in (hooks for hooks in lifting.values() if len(hooks) > 1):
        more = own or TANDEM[min(len(hooks), max(TANDEM))]
        mine = (hook for name, each in hooks.items() if name not in levelled for hook in each)  # others have rows
        for hook in (hook for hook in mine if hook.capacity or hook.chart):
            chart = tuple((radius, mass / more) for radius, mass in hook.chart)
            note = f"{1.0 / more:.1%} of what it may carry alone, as {len(hooks)} cranes lift together"
            note += "" if own else f", not synchronised ({TANDEM_SOURCE})"
            if hook.rope not in seen:
                yield RatedLimit(
                    subject=hook.rope, quantity="tandem load", unit="kg", elements=(hook.rope,), chart=chart,
                    value=None if chart else hook.capacity / more, over="radius" if chart else "", note=note,
                    source="the scene" if own else "assumed", where=hook.where,
                )  # fmt: skip
            seen.add(hook.rope)


def _fall(given: HookKeys, at: dict[str, Any]) -> RatedLimit:
    """The rope of a hook at rest, all falls together, of which the one at the drum is loaded most; friction assumed."""
    at = {**at, "unit": "N", "quantity": "rope tension"}
    if not given.fall_breaking:
        return RatedLimit(note="give its hook a 'fall breaking'", **{**at, "source": ""})
    factor, ends = ROPE_FACTORS[given.mechanism_group], drum_ends(given.falls, None)
    most = given.falls * given.fall_breaking / factor / lead_factor(given.falls, ends, ROLLING)
    return RatedLimit(value=most, factor=factor, **{**at, "source": f"{ISO_4308}, {given.mechanism_group}"})


def _given(yard: SceneBuilder, machine: plan.Mechanism, rope: str) -> HookKeys:
    """The keys of a hook."""
    scene = yard.scene
    return (scene.machines.get(machine.name) or scene.mechanism).hooks[rope]  # type: ignore[union-attr]


def rigging_limits(yard: SceneBuilder, machine: plan.Mechanism) -> Iterator[RatedLimit]:
    """Slings of a rigging with their shackles, or the frame that it is."""
    entries = {name: x for name, x in yard.scene.rigging.items() if name in machine.rigged or name == machine.name}
    for name, given in entries.items():
        at = {"unit": "kg", "source": "the scene", "where": yard.source.where(("rigging", name))}
        if isinstance(given, Frame):
            below = tuple(x for word, slings in _on(yard).items() if word.split(".")[0] == name for x in slings)
            if given.capacity:
                yield RatedLimit(subject=name, quantity="frame load", value=given.capacity, elements=below, **at)  # type: ignore[arg-type]
            continue
        slings = machine.rigged[name]
        if isinstance(given, SlingKeys):
            yield from _assembly(yard, name, given, slings, str(at["where"]))
        for sling in slings:
            yield from sling_limits(yard, given.sling, sling, at["where"], ("rigging", name, "sling"))
            bent = isinstance(given, Equaliser) or bool(given.over_edges)
            yield bridle_limit(yard, sling, at["where"], bent=bent)
            yield shackle_limit(yard, given.shackle, sling, ("rigging", name, "shackle"))


def shackle_limit(yard: SceneBuilder, WLL: float | None, sling: str, at: Path) -> RatedLimit:
    """Of each shackle of a sling, of an item of gear by its standard."""
    item = _item(yard, at)
    note = "give its 'shackle'" if WLL is None else shackle(WLL, item.partition(", ")[2]) if item else ""
    return RatedLimit(
        subject=sling, quantity="shackle load", unit="kg", value=WLL, elements=(sling,), note=note,
        source=item or ("the scene" if WLL else ""), where=yard.source.where(at[:-1]),
    )  # fmt: skip


def _item(yard: SceneBuilder, at: Path) -> str:
    """The item of gear at a path and its standard; "" if there is none."""
    found = ((name, x.standard) for name, x in yard.scene.gear.items() if shown(at) in x.at)
    return ", ".join(filter(None, next(found, ())))


def _on(yard: SceneBuilder) -> dict[str, list[str]]:
    """The slings that hang on each hook and point of a frame, those over a sheave twice."""
    found: dict[str, list[str]] = {}
    for name, given in yard.scene.rigging.items():
        for rope, sling in slings_of(yard.scene, name).items():
            assert not isinstance(given, Frame)
            found.setdefault(given.holders[sling.number], []).extend(
                [rope] * (2 if isinstance(given, Equaliser) else 1)
            )
    return found


def lug_limits(yard: SceneBuilder) -> Iterator[RatedLimit]:
    """Lugs of blocks, and points of frames."""
    scene, lugs, held = yard.scene, lugs_of(yard.scene), dict[object, list[str]]()
    for name, given in scene.rigging.items():
        for rope, sling in slings_of(scene, name).items():
            for word in given.to if isinstance(given, Equaliser) else [sling.holds]:
                held.setdefault(lugs.get(word, word), []).append(rope)
    if scene.block:
        every = [tie.rope for tie in yard.slings()]  # of beams, which may take any lug
        for lug in scene.block.lugs:
            yield from _lug(yard, lug, scene.block.lug_capacity, [*held.get(lugs[lug], ()), *every], ("block",))
    for name, block in scene.blocks.items():
        for lug in (f"{name}.{lug}" for lug in block.lugs):
            slings = [*held.get(lugs[lug], ()), *(tie.rope for tie in yard.slings())]
            yield from _lug(yard, lug, block.lug_capacity, slings, ("blocks", name))
    for name, given in scene.rigging.items():
        if isinstance(given, Frame):
            for lug in (name, *(f"{name}.{point}" for point in given.points)):
                slings = [*held.get(lug, ()), *_on(yard).get(lug, ())]
                yield from _lug(yard, lug, given.lug_capacity, slings, ("rigging", name))


def _lug(yard: SceneBuilder, lug: str, most: float | None, slings: list[str], base: Path) -> Iterator[RatedLimit]:
    where = yard.source.where((*base, "lug capacity"))
    if slings:
        yield RatedLimit(
            subject=lug, quantity="lug load", unit="kg", value=most, elements=tuple(slings),
            source="the scene" if most else "", note="" if most else "give 'lug capacity'", where=where,
        )  # fmt: skip


def bridle_limit(yard: SceneBuilder, sling: str, where: str, *, bent: bool) -> RatedLimit:
    """How far a sling may stand off the vertical."""
    limits, row = yard.scene.limits, {"subject": sling, "unit": "rad", "elements": (sling,), "where": where}
    if bent:
        note = "it bends over an edge or a sheave, where no angle to the vertical counts"
        return RatedLimit(quantity="bridle angle", note=note, **row)  # type: ignore[arg-type]
    source = "the scene" if limits.model_fields_set & {"bridle", "bridle_warning"} else "EN 13414-1"
    warning = limits.bridle_warning
    return RatedLimit(quantity="bridle angle", value=limits.bridle, warning=warning, source=source, **row)  # type: ignore[arg-type]


def sling_limits(yard: SceneBuilder, given: SlingType, name: str, where: str, base: Path) -> Iterator[RatedLimit]:
    """A sling, at rest and at its peak."""
    known = terms(given, _item(yard, base))
    own = {"factor": tuple(at_rest(known, yard.scene.gravity)), "partial_factor": tuple(in_a_run(known))}
    own |= {x: (getattr(given, x), "the scene", "") for x in own if x in given.model_fields_set and getattr(given, x)}
    yield from strength_limits("sling", name, given.breaking, where, own)  # type: ignore[arg-type]


def _assembly(
    yard: SceneBuilder, name: str, given: SlingKeys, slings: tuple[str, ...], where: str
) -> Iterator[RatedLimit]:
    """The legs of a bridle on one hook or frame that were bought together; else, how more than three share a load."""
    scene, sling = yard.scene, given.sling
    if given.over_edges or len({*given.holders}) > 1:
        return
    own = sling.legs == "single" or "factor" in sling.model_fields_set
    known = terms(sling, _item(yard, ("rigging", name, "sling")))
    found = None if own else assembly(known, len(given.to), scene.gravity)
    row = {"subject": name, "elements": slings, "where": where}
    if found:
        yield RatedLimit(
            quantity="assembly load", unit="kg", chart=found[0], over="angle", source=found[1],
            note="shares as lengths and stiffness make them", **row,  # type: ignore[arg-type]
        )  # fmt: skip
    elif len(given.to) > DETERMINATE and sling.legs != "single" and not (scene.practice or scene.factors.skew):
        told = (
            f"{len(given.to)} slings share a load as lengths and stiffness make them: write 'sling: {{legs: single}}'"
        )
        yield RatedLimit(quantity="sharing", unit="", note=f"{told} or 'factors: {{skew: 1.25}}'", **row)  # type: ignore[arg-type]


def gear_of(yard: SceneBuilder) -> Iterator[plan.Gear]:
    """The items of rigging that the scene uses."""
    scene = yard.scene
    for name, x in scene.gear.items():
        number = 0
        for at in x.at:
            words = at.split(".")
            entry = scene.rigging.get(words[1]) if words[0] == "rigging" else None
            legs = len(entry.to) if isinstance(entry, SlingKeys) else 1
            slings = 2 * len(scene.rig.beams) if scene.rig and words[0] == "rig" else legs
            number += {"sling": slings, "shackle": 2 * slings, "length": 0}.get(words[-1], 1)
        yield plan.Gear(
            name=name, kind=x.kind, number=number, WLL=x.WLL or 0.0, mass=x.mass or 0.0, standard=x.standard,
            termination=x.termination or "", certificate=x.certificate, at=tuple(x.at),
        )  # fmt: skip
