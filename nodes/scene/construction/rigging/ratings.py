"""Limits of what machines made of parts hold: hooks and their ropes, slings, shackles, frames, lugs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from heavylift.nodes.limits.reeving import ROLLING, drum_ends, lead_factor
from heavylift.nodes.limits.standards import ISO_4308, ND_0027, ROPE_FACTORS, SLINGS, SUCCESSOR, partial_factor
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.limit import Limit, Quantity
from heavylift.nodes.scene.construction.yard import Yard
from heavylift.nodes.scene.keys.parts.mechanics import Hook
from heavylift.nodes.scene.keys.parts.rigging import Equaliser, Frame, SlingType
from heavylift.nodes.scene.text.source import Path

from .slings import lugs_of, slings_of


def hook_limits(yard: Yard, machine: plan.Mechanism) -> Iterator[Limit]:
    """Hooks of a machine made of parts: capacity or chart, rope, slings."""
    for hook in machine.hooks:
        given = _given(yard, machine, hook.rope)
        at = {"subject": hook.rope, "unit": "kg", "elements": (hook.rope,), "where": hook.where, "source": "its type"}
        if chart := hook.chart:
            note = "with hook block and rigging; the next longer radius counts"
            yield Limit(quantity="hook load", chart=chart, over="radius", note=note, **at)  # type: ignore[arg-type]
        else:
            note = "" if given.capacity else "give its hook a 'capacity'"
            yield Limit(quantity="hook load", value=given.capacity, note=note, **at)  # type: ignore[arg-type]
        yield _fall(given, at)


def _fall(given: Hook, at: dict[str, Any]) -> Limit:
    """The rope of a hook at rest, all falls together, of which the one at the drum is loaded most; friction assumed."""
    at = {**at, "unit": "N", "quantity": "rope tension"}
    if not given.fall_breaking:
        return Limit(note="give its hook a 'fall breaking'", **{**at, "source": ""})
    factor, ends = ROPE_FACTORS[given.mechanism_group], drum_ends(given.falls, None)
    most = given.falls * given.fall_breaking / factor / lead_factor(given.falls, ends, ROLLING)
    return Limit(value=most, factor=factor, **{**at, "source": f"{ISO_4308}, {given.mechanism_group}"})


def _given(yard: Yard, machine: plan.Mechanism, rope: str) -> Hook:
    """The keys of a hook."""
    scene = yard.scene
    return (scene.machines.get(machine.name) or scene.mechanism).hooks[rope]  # type: ignore[union-attr]


def rigging_limits(yard: Yard, machine: plan.Mechanism) -> Iterator[Limit]:
    """Slings of a rigging with their shackles, or the frame that it is."""
    entries = {name: x for name, x in yard.scene.rigging.items() if name in machine.rigged or name == machine.name}
    for name, given in entries.items():
        at = {"unit": "kg", "source": "the scene", "where": yard.source.where(("rigging", name))}
        if isinstance(given, Frame):
            below = tuple(x for word, slings in _on(yard).items() if word.split(".")[0] == name for x in slings)
            if given.capacity:
                yield Limit(subject=name, quantity="frame load", value=given.capacity, elements=below, **at)  # type: ignore[arg-type]
            continue
        for sling in machine.rigged[name]:
            yield from sling_limits(given.sling, sling, at["where"])
            if given.shackle:
                yield Limit(subject=sling, quantity="shackle load", value=given.shackle, elements=(sling,), **at)  # type: ignore[arg-type]


def _on(yard: Yard) -> dict[str, list[str]]:
    """The slings that hang on each hook and point of a frame, those over a sheave twice."""
    found: dict[str, list[str]] = {}
    for name, given in yard.scene.rigging.items():
        for rope, sling in slings_of(yard.scene, name).items():
            assert not isinstance(given, Frame)
            found.setdefault(given.holders[sling.number], []).extend(
                [rope] * (2 if isinstance(given, Equaliser) else 1)
            )
    return found


def lug_limits(yard: Yard) -> Iterator[Limit]:
    """Lugs of blocks, and points of frames."""
    scene, lugs, held = yard.scene, lugs_of(yard.scene), dict[object, list[str]]()
    for name, given in scene.rigging.items():
        for rope, sling in slings_of(scene, name).items():
            for word in given.to if isinstance(given, Equaliser) else [sling.holds]:
                held.setdefault(lugs.get(word, word), []).append(rope)
    if scene.block and scene.block.lug_capacity:
        every = [sling.name for sling in yard.slings]  # of loaders, which may take any lug
        for lug in scene.block.lugs:
            yield from _lug(yard, lug, scene.block.lug_capacity, [*held.get(lugs[lug], ()), *every], ("block",))
    for name, block in scene.blocks.items():
        for lug in (f"{name}.{lug}" for lug in block.lugs if block.lug_capacity):
            yield from _lug(yard, lug, block.lug_capacity or 0.0, held.get(lugs[lug], []), ("blocks", name))
    for name, given in scene.rigging.items():
        if isinstance(given, Frame) and given.lug_capacity:
            for lug in (name, *(f"{name}.{point}" for point in given.points)):
                slings = [*held.get(lug, ()), *_on(yard).get(lug, ())]
                yield from _lug(yard, lug, given.lug_capacity, slings, ("rigging", name))


def _lug(yard: Yard, lug: str, most: float, slings: list[str], base: Path) -> Iterator[Limit]:
    where = yard.source.where((*base, "lug capacity"))
    if slings:
        yield Limit(
            subject=lug, quantity="lug load", unit="kg", value=most, elements=tuple(slings), source="the scene",
            where=where,
        )  # fmt: skip


def sling_limits(given: SlingType, name: str, where: str) -> Iterator[Limit]:
    """A sling, at rest and at its peak."""
    most = {"factor": given.factor, "source": "the scene" if "factor" in given.model_fields_set else SLINGS}
    own = f"{ND_0027}, 7.3.1, hand splice; {SUCCESSOR}"
    partial = given.partial_factor or partial_factor()
    peak = {"factor": partial, "source": "the scene" if given.partial_factor else own}
    kinds: tuple[tuple[Quantity, dict[str, Any]], ...] = (("sling tension", most), ("sling peak", peak))
    for quantity, by in kinds:
        yield Limit(
            subject=name, quantity=quantity, unit="N", value=given.breaking / by["factor"], breaking=given.breaking,
            elements=(name,), where=where, **by,
        )  # fmt: skip
