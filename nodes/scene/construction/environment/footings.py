"""Bases and configurations of machines as parts of the plan, and the limits of ground loads and wind."""

from collections.abc import Collection, Iterator, Sequence
from typing import Any

import msgspec
from heavylift.nodes.limits.named import CORNERS, TRACKS
from heavylift.nodes.plan.limit import RatedLimit, RestLoad
from heavylift.nodes.plan.mechanism import Footing, Mechanism
from heavylift.nodes.scene.construction.scene_builder import SceneBuilder
from heavylift.nodes.scene.keys.parts.mechanics import HookKeys, Parts
from heavylift.nodes.scene.keys.parts.standing import Stands
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path, SourceText
from heavylift.nodes.scene.text.units import LENGTH, MASS

STATICS = "statics of a rigid base"
LEFT_OUT = "inertia of the machine and wind on it are not in it"
UNKNOWN = "give 'stands' to its type: tracks, outriggers or wheels"


def footing_of(
    source: SourceText, base: Path, given: Stands | None, bodies: Collection[str], prefix: str
) -> Footing | None:
    """Return the base on which a machine stands; None if the machine has no base.

    `prefix`: prefix of the names of the machine's bodies."""
    if given is None:
        return None
    body = f"{prefix}{given.on}"
    if body not in bodies:
        known = [name.removeprefix(prefix) for name in bodies]
        source.fault((*base, "stands", "on"), f"there is no body '{given.on}' to stand on", closest(given.on, known))
    at = {"body": body, "at": given.at}
    if x := given.tracks:
        return Footing(kind="tracks", length=x.length, width=x.apart, each=x.width, **at)  # type: ignore[arg-type]
    if y := given.outriggers:
        return Footing(kind="outriggers", length=y.length, width=y.width, each=y.pad, **at)  # type: ignore[arg-type]
    if z := given.wheels:
        return Footing(kind="wheels", length=z.length, width=z.width, each=float(z.each), **at)  # type: ignore[arg-type]
    return None


def set_up(builder: SceneBuilder, machines: Sequence[Mechanism]) -> tuple[Mechanism, ...]:
    """Return the machines, with the scene's mats and a description of their configuration added if they have hooks."""
    names = [machine.name for machine in machines if machine.hooks]
    for name in (name for name in builder.scene.ground.mats if name not in names):
        builder.source.fault(("ground", "mats", name), f"there is no crane '{name}'", closest(name, names), on_key=True)
    return tuple(_set_up(builder, machine) if machine.hooks else machine for machine in machines)


def _set_up(builder: SceneBuilder, machine: Mechanism) -> Mechanism:
    footing, mats, path = machine.footing, builder.scene.ground.mats.get(machine.name), ("ground", "mats", machine.name)
    if mats and (footing is None or footing.kind == "wheels"):
        builder.source.fault(path, f"'{machine.name}' stands on no tracks and no outriggers", on_key=True)
    elif mats and footing:
        least = footing.each * (footing.length if footing.kind == "tracks" else 1.0)
        if mats.area < least:
            builder.source.fault(
                (*path, "area"), f"mats are not smaller than what stands on each of them, {least:g} m2"
            )
        footing = msgspec.structs.replace(footing, mat=(mats.area, mats.mass))
    machine = msgspec.structs.replace(machine, footing=footing)
    return msgspec.structs.replace(machine, configuration=_configuration(machine, _parts(builder, machine)))


def _configuration(machine: Mechanism, given: Parts[Any] | None) -> dict[str, str]:
    """Return how a machine is set up, in words: type, boom, counterweight, base of the load charts, falls, mats."""
    found = {key: str(value) for key, value in given.configuration.items()} if given else {}
    hooks: dict[str, HookKeys] = given.hooks if given else {}
    for name, hook in hooks.items():
        of = "" if len(hooks) == 1 else f" of {name.rpartition('.')[2]}"
        for key, size in (("boom", LENGTH), ("counterweight", MASS), ("outriggers", LENGTH)):
            if (value := getattr(hook, key)) is not None:
                found.setdefault(f"{key}{of}", size.show(value))
    falls = {hook.rope.rpartition(".")[2]: str(hook.falls) for hook in machine.hooks}
    same = len({*falls.values()}) == 1
    found |= {"falls": next(iter(falls.values()))} if same else {f"falls of {name}": n for name, n in falls.items()}
    if x := machine.footing:
        found["base"] = f"{x.kind} {LENGTH.show(x.length)} long, {LENGTH.show(x.width)} apart"
        found |= {"mats": f"{x.mat[0]:g} m2 each"} if x.mat else {}
    return found


def standing_limits(builder: SceneBuilder, machine: Mechanism) -> Iterator[RatedLimit]:
    """Yield the limits of the load on each track, outrigger or wheel, and of the distance to tipping."""
    name, footing, given = machine.name, machine.footing, _given(builder, machine)
    if footing is None:
        note = UNKNOWN if given is None else "it stands on a foundation"
        elements = (name,) if given is None else ()
        yield RatedLimit(
            subject=name, quantity="ground pressure", unit="Pa", elements=elements, note=note, where=machine.where
        )
        return
    at = {"elements": (name,), "where": machine.where}
    if footing.kind == "wheels":
        most = given.wheels.capacity if given and given.wheels else None
        by, note = ("its type", LEFT_OUT) if most else ("", "give its wheels a 'capacity'")
        for corner in CORNERS:
            yield RatedLimit(
                subject=f"{name} {corner}", quantity="wheel load", unit="kg", value=most, over=corner, source=by,
                note=note, **at,  # type: ignore[arg-type]
            )  # fmt: skip
    else:
        most, path = builder.scene.ground.bearing, ("ground", "bearing")
        by, note = ("the scene", LEFT_OUT) if most else ("", "write 'ground: {bearing: 200 kPa}', what it may bear")
        at |= {"where": builder.source.where(path)} if most else {}
        for each in TRACKS if footing.kind == "tracks" else CORNERS:
            yield RatedLimit(
                subject=f"{name} {each}", quantity="ground pressure", unit="Pa", value=most, over=each, source=by,
                note=note, **at,  # type: ignore[arg-type]
            )  # fmt: skip
    yield RatedLimit(
        subject=name, quantity="uplift", unit="", value=1.0, source=STATICS, note=LEFT_OUT, **at,  # type: ignore[arg-type]
    )  # fmt: skip


def wind_limits(builder: SceneBuilder, machines: Collection[Mechanism], winds: tuple[str, ...]) -> Iterator[RatedLimit]:
    """Yield the wind limits of machines with hooks and of the whole scene."""
    most, where = builder.scene.limits.wind, builder.source.where(("limits",))
    stated = builder.scene.factors.wind or 0.0
    if not winds and not stated:
        by = "the scene" if most is not None else ""
        note = "no wind is modelled"
        yield RatedLimit(subject="all", quantity="wind", unit="m/s", value=most, source=by, note=note, where=where)
        return
    row: dict[str, Any] = {"quantity": "wind", "unit": "m/s", "elements": winds}
    if stated:
        row |= {"rest": RestLoad(value=stated, bound=stated), "note": "in the stated wind of the factor sheet"}
    unknown = not machines
    for machine in machines:
        given = _parts(builder, machine)
        own = given.wind if given else None
        unknown |= own is None
        if own is not None:
            yield RatedLimit(subject=machine.name, value=own, source="its type", where=machine.where, **row)
    if most is not None:
        yield RatedLimit(subject="all", value=most, source="the scene", where=where, **row)
    elif unknown:
        row["note"] = "give it under 'limits: {wind: ...}'"
        yield RatedLimit(subject="all", where=where, **row)


def _given(builder: SceneBuilder, machine: Mechanism) -> Stands | None:
    parts = _parts(builder, machine)
    return parts.stands if parts else None


def _parts(builder: SceneBuilder, machine: Mechanism) -> Parts[Any] | None:
    """Return the keys from which a machine was built; None if it was built otherwise."""
    scene = builder.scene
    return scene.machines.get(machine.name) or scene.mechanism
