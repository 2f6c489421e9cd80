"""Loaders, hook ropes and slings of a scene file as their part of the plan.

Each loader hangs at rest below its trolley on its stretched rope, its slings slack by the rig's `slack`, straight or
over edges.
"""

from __future__ import annotations

import math

import numpy as np
from heavylift.kernel.description.forces import Reeving, Sheave, Signal
from heavylift.kernel.description.mechanics import WORLD, Line, Point
from heavylift.nodes.limits.reeving import lead_factor
from heavylift.nodes.plan import plan
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.text.source import Path

from .limiting import reeving, rope_factor
from .rigging.edges import SPREAD, along_edges, height_of
from .yard import Yard, box, by_beam, parts_of, trolley_start

Place = tuple[float, float, float]


def add_loader(yard: Yard, rig: schema.Rig, name: str, loader: schema.Loader) -> None:
    """Adds a loader, its hook rope and its two slings to the yard."""
    path: Path = ("rig", "loaders", name)
    crane_name, hook = yard.hooks[name]
    crane = yard.scene.cranes[crane_name]
    given, gravity = parts_of(crane).hooks[hook], yard.scene.gravity
    top = given.at[2]
    mass = crane.hook_block + loader.upper_mass + loader.lower_mass
    block = yard.scene.block
    lugs = [lug for lug in loader.lugs or () if block and lug in block.lugs]
    lugs = by_beam(lugs, {lug: block.lugs[lug][0] for lug in lugs}) if block else []
    strain = mass * gravity / (crane.falls * crane.fall_EA)
    if loader.rope is not None:
        hangs = loader.rope * (1 + strain)
    elif block and lugs:
        lug_z = block.at[2] + sum(block.lugs[lug][2] for lug in lugs) / len(lugs)
        hangs = top - (lug_z + loader.sling + loader.height - rig.slack)
    else:
        hangs = top - crane.highest_hook
    x = crane.at + given.at[0]
    y = trolley_start(yard, name=crane_name, crane=crane, trolley=given.on)
    over: list[tuple[Sheave, ...]] = [(), ()]
    if loader.over_edges:
        over, hangs = _over(yard, rig, name, loader, lugs, (x, y, top), hangs)
    frame, beam = loader.upper_mass + crane.hook_block, loader.height - loader.hinge
    yard.loaders.append(
        plan.Loader(
            name=name,
            pose=(x, y, top - hangs, 0.0, 0.0, 0.0, 1.0),
            upper=plan.Inertia(
                mass=frame,
                com=(0.0, 0.0, -loader.hinge / 2),
                moments=box(frame, (loader.falls_apart, 2.0, loader.hinge)),
            ),
            lower=plan.Inertia(
                mass=loader.lower_mass,
                com=(0.0, 0.0, -beam / 2),
                moments=box(loader.lower_mass, (loader.beam, 1.0, beam)),
            ),
            hinge=(0.0, 0.0, -loader.hinge),
            damping=loader.hinge_damping,
            stop_lower=-loader.stop,
            stop_upper=loader.stop,
            stop_k=loader.stop_stiffness,
            stop_d=loader.stop_damping,
            lock_moment=loader.lock_moment,
            lock_k=loader.lock_stiffness,
            lock_d=loader.lock_damping,
            capacity_N=loader.capacity * gravity,
            where=yard.source.where(path),
        )
    )
    _rope(yard, name, loader, hangs / (1 + strain))
    _slings(yard, rig, name, loader, lugs, over)


def _over(
    yard: Yard, rig: schema.Rig, name: str, loader: schema.Loader, lugs: list[str], exit_: Place, hangs: float
) -> tuple[list[tuple[Sheave, ...]], float]:
    """The edges of each sling, and how far below its trolley the loader hangs, for which `hangs` is a guess [m]."""
    block, path = yard.scene.block, ("rig", "loaders", name)
    if block is None or len(lugs) < 2:
        yard.source.fault((*path, "over edges"), "slings bend over edges from the start: hook them to 'lugs' then")
        return [(), ()], hangs
    ends = [(_beam(name, loader, i), Point("block", block.lugs[lug])) for i, lug in enumerate(lugs)]
    x, y, top = exit_
    R, up = np.eye(3), top - hangs - loader.hinge
    at = {WORLD: (np.zeros(3), R), "block": (np.array(block.at), R), f"{name}.lower": (np.array([x, y, up]), R)}
    over = [
        along_edges(yard.source, path, loader.over_edges, yard.scene.edges, pair, {"block": block.com}, lambda: at)
        for pair in ends
    ]
    if len({edge.at.body for edge in over[0]}) > 1:
        told = "the block turns freely, so its slings bend over edges of one body only"
        yard.source.fault((*path, "over edges"), told)
    if yard.source.faults or loader.rope is not None:
        return over, hangs

    def height(i: int) -> float:
        (dx, dy, dz), lug = ends[i][0].p, ends[i][1]

        def rope(z: float) -> Reeving:
            beam = Point(WORLD, (x + dx, y + dy, z - loader.hinge + dz))
            return Reeving(f"{name}.sling-{i + 1}", beam, over[i], lug, rig.sling.EA, Signal(loader.sling))

        low = block.at[2] + lug.p[2] + loader.hinge - dz + SPREAD
        return height_of(rope, low, loader.sling, rig.slack, at, "over its edges")

    try:
        return over, top - min(height(0), height(1))
    except ValueError as error:
        yard.source.fault((*path, "sling"), str(error))
        return over, hangs


def _beam(name: str, loader: schema.Loader, i: int) -> Point:
    """The end of a loader's beam at which a sling hangs."""
    return Point(f"{name}.lower", ((-1, 1)[i] * loader.beam / 2, 0.0, -(loader.height - loader.hinge)))


def _rope(yard: Yard, name: str, loader: schema.Loader, L0: float) -> None:
    crane_name, hook = yard.hooks[name]
    crane, block = yard.scene.cranes[crane_name], yard.scene.block
    leaves, half = parts_of(crane).hooks[hook], loader.falls_apart / 2
    x, _, z = leaves.at
    lines = tuple(
        Line(Point(f"{crane_name}.{leaves.on}", (x + d, 0.0, z)), Point(f"{name}.upper", (d, 0.0, 0.0)), 0.5)
        for d in (-half, half)
    )
    carried = crane.hook_block + loader.upper_mass + loader.lower_mass
    carried += block.mass / len(yard.hooks) if block else 0.0
    EA = crane.falls * crane.fall_EA
    ends, efficiency, _ = reeving(crane)
    part = crane.fall_breaking / rope_factor(crane)[0] - crane.fall_mass * yard.scene.gravity * L0
    yard.ropes.append(
        plan.HookRope(
            name=f"{crane_name}.{hook}",
            crane=crane_name,
            hook=hook,
            carries=name,
            eye=Point(f"{name}.upper", (0.0, 0.0, 0.0)),
            lines=lines,
            L0=L0,
            EA=EA,
            damping=2 * crane.rope_damping * math.sqrt(EA / max(L0, 1e-3) * carried),
            falls=crane.falls,
            line=crane.falls * crane.fall_mass,
            rated=max(crane.falls * part / lead_factor(crane.falls, ends, efficiency), 0.0),
            drum_ends=ends,
            efficiency=efficiency,
            breaking=crane.fall_breaking,
            where=yard.source.where(("rig", "loaders", name, "hook")),
        )
    )


def _slings(
    yard: Yard, rig: schema.Rig, name: str, loader: schema.Loader, lugs: list[str], over: list[tuple[Sheave, ...]]
) -> None:
    half_mass = (yard.loaders[-1].upper.mass + loader.lower_mass) / 2
    for i in (0, 1):
        yard.slings.append(
            plan.Sling(
                name=f"{name}.sling-{i + 1}",
                loader=name,
                beam=_beam(name, loader, i),
                over=over[i],
                lug=lugs[i] if i < len(lugs) else "",
                L0=loader.sling,
                EA=rig.sling.EA,
                damping=2 * rig.sling.damping * math.sqrt(rig.sling.EA / loader.sling * half_mass),
                rated=rig.sling.breaking / rig.sling.factor,
                where=yard.source.where(("rig", "loaders", name, "sling")),
            )
        )
