"""Limits of the loads on hooks: several machines together, slings, shackles, frames, lugs."""

from collections import Counter
from collections.abc import Iterable, Iterator
from datetime import date

import msgspec
from heavylift.nodes.limits.sharing import DETERMINATE
from heavylift.nodes.limits.standards import (
    CABLE_LAID,
    TANDEM,
    TANDEM_SOURCE,
    UNREAD,
    assembly,
    at_rest,
    in_a_run,
    shackle,
    strength_limits,
)
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.connections import lug_places, ties_on
from heavylift.nodes.plan.limit import RatedLimit
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.keys.parts.rigging import Equaliser, Frame, SlingKeys, SlingType
from heavylift.nodes.scene.text.source import Path, shown

from .edges import lugs_of, slings_of, terms

YEAR = 366  # [days] between examinations, at most (ASME B30.9, periodic inspection)


def tandem_limits(builder: SceneBuilder) -> Iterator[RatedLimit]:
    """Yield the reduced capacities of hooks of several machines that together carry one load at the start."""
    lifting: dict[str, dict[str, list[plan.Hoist]]] = {}  # load -> machine -> hooks
    lugs, keys = lug_places(builder.machines), builder.scene.machines
    rated = {name for name, x in keys.items() if any(cell.tandem < 1.0 for cell in x.load_cells.values())}
    for machine in builder.machines:
        for hook in machine.hooks:
            for tie in ties_on(builder.machines, hook):
                if tie.lug and (held := tie.lower or lugs.get(tie.lug)):
                    lifting.setdefault(held.body, {}).setdefault(machine.name, []).append(hook)
    seen, own = set[str](), builder.scene.factors.tandem
    for hooks in (hooks for hooks in lifting.values() if len(hooks) > 1):
        more = own or TANDEM[min(len(hooks), max(TANDEM))]
        mine = (hook for name, each in hooks.items() if name not in rated for hook in each)  # others have rows
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


def with_rigging(builder: SceneBuilder, limits: Iterable[RatedLimit]) -> Iterator[RatedLimit]:
    """Yield the limits, with the mass of slings and shackles that is added to each load on a hook or frame.

    They have no mass in the model. There are two shackles for each sling. The mass below a hook is that of the
    factor sheet or, without one, that known from the gear. Hooks that hold a sling together share its mass."""
    scene, of = builder.scene, Counter[str]()
    for item in scene.gear.values():
        for owner, _, what in (at.rpartition(".") for at in item.at):
            of[owner] += {"sling": 1, "shackle": 2}.get(what, 0) * (item.mass or 0.0)  # type: ignore[assignment]
    slings = {rope: (f"rigging.{name}", str(sling.number)) for name in scene.rigging
              for rope, sling in slings_of(scene, name).items()}  # fmt: skip
    hooks = [hook for machine in builder.machines for hook in machine.hooks]
    below = {x.rope: {slings.get(t.rope, ("rig", t.rope)) for t in ties_on(builder.machines, x)} for x in hooks}
    shared = Counter(sling for each in below.values() for sling in each)
    for limit in limits:
        total, given = 0.0, scene.factors.rigging
        if limit.quantity == "frame load" and given is None:
            total = sum(of[owner] for owner, _ in sorted({slings[x] for x in limit.elements if x in slings}))
        for each in (below[name] for name in limit.elements if below.get(name)):
            total += sum(of[x[0]] / shared[x] for x in sorted(each)) if given is None else given
        note = "; ".join(x for x in (limit.note, f"{total / 1e3:.3g} t of slings and shackles") if x)
        yield msgspec.structs.replace(limit, rigging=total, note=note) if total and limit.unit == "kg" else limit


def rigging_limits(builder: SceneBuilder, machine: plan.Mechanism) -> Iterator[RatedLimit]:
    """Yield the limits of slings, shackles and frames of a rigging entry."""
    entries = {name: x for name, x in builder.scene.rigging.items() if name in machine.rigged or name == machine.name}
    for name, given in entries.items():
        at = {"unit": "kg", "source": "the scene", "where": builder.source.where(("rigging", name))}
        if isinstance(given, Frame):
            below = tuple(x for word, slings in _on(builder).items() if word.split(".")[0] == name for x in slings)
            if given.capacity:
                yield RatedLimit(subject=name, quantity="frame load", value=given.capacity, elements=below, **at)  # type: ignore[arg-type]
            continue
        slings = machine.rigged[name]
        if isinstance(given, SlingKeys):
            yield from _assembly(builder, name, given, slings, str(at["where"]))
        for sling in slings:
            yield from sling_limits(builder, given.sling, sling, at["where"], ("rigging", name, "sling"))
            bent = isinstance(given, Equaliser) or bool(given.over_edges)
            yield bridle_limit(builder, sling, at["where"], bent=bent)
            yield shackle_limit(builder, given.shackle, sling, ("rigging", name, "shackle"))


def shackle_limit(builder: SceneBuilder, WLL: float | None, sling: str, at: Path) -> RatedLimit:
    """Return the limit of the load on each shackle of a sling; a shackle listed as gear is checked by its standard."""
    item = _item(builder, at)
    note = "give its 'shackle'" if WLL is None else shackle(WLL, item.partition(", ")[2]) if item else ""
    return RatedLimit(
        subject=sling, quantity="shackle load", unit="kg", value=WLL, elements=(sling,), note=note,
        source=item or ("the scene" if WLL else ""), where=builder.source.where(at[:-1]),
    )  # fmt: skip


def _item(builder: SceneBuilder, at: Path) -> str:
    """Return the gear item that is used at a path, and its standard, as text; "" if there is none."""
    found = ((name, x.standard) for name, x in builder.scene.gear.items() if shown(at) in x.at)
    return ", ".join(filter(None, next(found, ())))


def _on(builder: SceneBuilder) -> dict[str, list[str]]:
    """Return the slings on each hook and on each point of a frame; a sling over a sheave is listed twice."""
    found: dict[str, list[str]] = {}
    for name, given in builder.scene.rigging.items():
        for rope, sling in slings_of(builder.scene, name).items():
            assert not isinstance(given, Frame)
            found.setdefault(given.holders[sling.number], []).extend(
                [rope] * (2 if isinstance(given, Equaliser) else 1)
            )
    return found


def lug_limits(builder: SceneBuilder) -> Iterator[RatedLimit]:
    """Yield the limits of the lugs of blocks and of the points of frames."""
    scene, lugs, held = builder.scene, lugs_of(builder.scene), dict[object, list[str]]()
    for name, given in scene.rigging.items():
        for rope, sling in slings_of(scene, name).items():
            for word in given.to if isinstance(given, Equaliser) else [sling.holds]:
                held.setdefault(lugs.get(word, word), []).append(rope)
    if scene.block:
        every = [tie.rope for tie in builder.slings()]  # of beams, which may take any lug
        for lug in scene.block.lugs:
            yield from _lug(builder, lug, scene.block.lug_capacity, [*held.get(lugs[lug], ()), *every], ("block",))
    for name, block in scene.blocks.items():
        for lug in (f"{name}.{lug}" for lug in block.lugs):
            slings = [*held.get(lugs[lug], ()), *(tie.rope for tie in builder.slings())]
            yield from _lug(builder, lug, block.lug_capacity, slings, ("blocks", name))
    for name, given in scene.rigging.items():
        if isinstance(given, Frame):
            for lug in (name, *(f"{name}.{point}" for point in given.points)):
                slings = [*held.get(lug, ()), *_on(builder).get(lug, ())]
                yield from _lug(builder, lug, given.lug_capacity, slings, ("rigging", name))


def _lug(builder: SceneBuilder, lug: str, most: float | None, slings: list[str], base: Path) -> Iterator[RatedLimit]:
    where = builder.source.where((*base, "lug capacity"))
    if slings:
        yield RatedLimit(
            subject=lug, quantity="lug load", unit="kg", value=most, elements=tuple(slings),
            source="the scene" if most else "", note="" if most else "give 'lug capacity'", where=where,
        )  # fmt: skip


def bridle_limit(builder: SceneBuilder, sling: str, where: str, *, bent: bool) -> RatedLimit:
    """Yield the limit of a sling's angle to the vertical; none if the sling is `bent` over an edge or sheave."""
    limits, row = builder.scene.limits, {"subject": sling, "unit": "rad", "elements": (sling,), "where": where}
    if bent:
        note = "it bends over an edge or a sheave, where no angle to the vertical counts"
        return RatedLimit(quantity="bridle angle", note=note, **row | {"elements": ()})  # type: ignore[arg-type]
    source = "the scene" if limits.model_fields_set & {"bridle", "bridle_warning"} else "EN 13414-1"
    warning = limits.bridle_warning
    return RatedLimit(quantity="bridle angle", value=limits.bridle, warning=warning, source=source, **row)  # type: ignore[arg-type]


def sling_limits(builder: SceneBuilder, given: SlingType, name: str, where: str, base: Path) -> Iterator[RatedLimit]:
    """Yield the limits of a sling, for its static load and for its peak load."""
    known = terms(given, _item(builder, base))
    own = {"factor": tuple(at_rest(known, builder.scene.gravity)), "partial_factor": tuple(in_a_run(known))}
    own |= {x: (getattr(given, x), "the scene", "") for x in own if x in given.model_fields_set and getattr(given, x)}
    yield from strength_limits("sling", name, given.breaking, where, own)  # type: ignore[arg-type]
    if known.termination in CABLE_LAID and not known.WLL:
        yield RatedLimit(subject=name, quantity="heavy sling", unit="", elements=(name,), note=UNREAD, where=where)


def _assembly(
    builder: SceneBuilder, name: str, given: SlingKeys, slings: tuple[str, ...], where: str
) -> Iterator[RatedLimit]:
    """Yield the limits of a certified assembly of slings, or a note on load sharing for more than three legs."""
    scene, sling = builder.scene, given.sling
    if given.over_edges or len({*given.holders}) > 1:
        return
    own = sling.legs == "single" or "factor" in sling.model_fields_set
    known = terms(sling, _item(builder, ("rigging", name, "sling")))
    found = None if own else assembly(known, len(given.to), scene.gravity)
    row = {"subject": name, "elements": slings, "where": where}
    if found:
        yield RatedLimit(
            quantity="assembly load", unit="kg", chart=found[0], over="angle", source=found[1],
            note="shares as lengths and stiffness make them", **row,  # type: ignore[arg-type]
        )  # fmt: skip
    elif len(given.to) > DETERMINATE and sling.legs != "single" and not (scene.practice or scene.factors.skew):
        message = (
            f"{len(given.to)} slings share a load as lengths and stiffness make them: write 'sling: {{legs: single}}'"
        )
        yield RatedLimit(quantity="sharing", unit="", note=f"{message} or 'factors: {{skew: 1.25}}'", **row)  # type: ignore[arg-type]


def certificate_limits(builder: SceneBuilder) -> Iterator[RatedLimit]:
    """Yield a limit without a value for each item of gear whose certificate is missing or has expired."""
    today = _date(builder.scene.project.date) if builder.scene.project else None
    for name, x in builder.scene.gear.items() if today else ():
        given = _date(x.certificate)
        note = "give 'certificate' with its date, such as 2026-11-29" if given is None else ""
        if given and today and (today - given).days > YEAR:
            note = f"{x.certificate}, more than a year before the project: examine it again, and give 'certificate'"
        if note and x.at:
            where = builder.source.where(("gear", name))
            yield RatedLimit(subject=f"certificate of {name}", quantity="inputs", unit="", note=note, where=where)


def _date(text: str) -> date | None:
    """Return the date in a text; None if it is not an ISO date."""
    try:
        return date.fromisoformat(text.strip())
    except ValueError:
        return None


def gear_of(builder: SceneBuilder) -> Iterator[plan.Gear]:
    """Yield the items of rigging gear that the scene uses."""
    scene = builder.scene
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
