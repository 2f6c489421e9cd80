"""What hangs on the hooks of cranes on rails: hook rope, lifting beam on a hinge, two slings.

Each hangs at rest below its trolley on its stretched rope, its slings slack by `slack`, straight or over edges.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import msgspec
import numpy as np
from heavylift.kernel.description.forces import Reeving, Sheave, Signal
from heavylift.kernel.description.mechanics import (
    WORLD,
    Body,
    Brake,
    Joint,
    JointSpring,
    Line,
    Point,
    Rope,
    Stop,
    System,
    Vector,
    merge,
)
from heavylift.nodes.limits.reeving import lead_factor
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.mechanism import Cell, Heavy, Latch
from heavylift.nodes.plan.spellings import BEAMS
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.parts.mechanics import Hook
from heavylift.nodes.scene.text.source import Path

from .limiting import reeving, rope_factor
from .rigging.edges import SPREAD, along_edges, height_of
from .rigging.slings import key_of, lugs_of, rated
from .yard import UPPER, Yard, box, by_beam, parts_of, ramp_of

THIN = 1.0  # edge of what has no other [m]
Edges = tuple[Sheave, ...]


@dataclass(frozen=True)
class OnHook:
    """A hook with its rope and winch, and the beam that hangs on it."""

    hook: str
    rope: Rope
    heavy: Heavy
    winch: plan.Actuator
    hoist: plan.Hoist
    beam: plan.Mechanism


def on_hook(yard: Yard, rig: schema.Rig, name: str, given: schema.Beam) -> OnHook:
    """What hangs on the hook of a beam, which is there."""
    path: Path = ("rig", BEAMS, name)
    crane_name, hook = yard.hooks[name]
    crane = yard.scene.cranes[crane_name]
    leaves, known = parts_of(crane).hooks[hook], lugs_of(yard.scene)
    top, mass = leaves.at[2], crane.hook_block + given.upper_mass + given.lower_mass
    lugs = by_beam([lug for lug in given.lugs or () if lug in known], {lug: p.p[0] for lug, p in known.items()})
    strain = mass * yard.scene.gravity / (crane.falls * crane.fall_EA)
    if given.rope is not None:
        hangs = given.rope * (1 + strain)
    elif lugs:
        at = yard.scene.all_blocks[known[lugs[0]].body].at
        lug_z = at[2] + sum(known[lug].p[2] for lug in lugs) / len(lugs)
        hangs = top - (lug_z + given.sling + given.height - rig.slack)
    else:
        hangs = top - crane.highest_hook
    x, y = crane.at + leaves.at[0], trolley_start(yard, name=crane_name, crane=crane, trolley=leaves.on)
    over: list[Edges] = [(), ()]
    if given.over_edges:
        over, hangs = _over(yard, rig, name, given, [known[lug] for lug in lugs], (x, y, top), hangs)
    upper_mass = given.upper_mass + crane.hook_block
    pose = (x, y, top - hangs, 0.0, 0.0, 0.0, 1.0)
    rope = _rope(yard, name, given, hangs / (1 + strain))
    winch = plan.Actuator(
        name=rope.name, start=rope.L0, accel=ramp_of(crane.ramp)[0], lower=crane.shortest_rope, upper=crane.drum,
        highest=crane.highest_hook, emergency=crane.emergency,
    )  # fmt: skip
    ends, efficiency, _ = reeving(crane)
    part = crane.fall_breaking / rope_factor(crane)[0] - crane.fall_mass * yard.scene.gravity * rope.L0
    n = len(rope.lines)
    a, b, z = (sum(line.a.p[i] for line in rope.lines) / n for i in range(3))
    ex, ey, ez = (sum(line.b.p[i] for line in rope.lines) / n + pose[i] for i in range(3))
    hoist = plan.Hoist(
        rope=rope.name,
        eye=Point(f"{name}.upper", (0.0, 0.0, 0.0)),
        block_mass=crane.hook_block,
        capacity=crane.hook_capacity,
        on=f"{crane_name}.{leaves.on}",
        line=crane.falls * crane.fall_mass,
        ends=((a + crane.at, b + y, z), (ex, ey, ez)),
        below=upper_mass + given.lower_mass,
        falls=crane.falls,
        drum_ends=ends,
        efficiency=efficiency,
        breaking=crane.fall_breaking,
        rated=max(crane.falls * part / lead_factor(crane.falls, ends, efficiency), 0.0),
        where=yard.source.where((*path, "hook")),
    )
    assert hoist.ends is not None
    heavy = Heavy(
        rope=rope.name, line=hoist.line, beside=tuple((line.b.p[0], 0.0, 0.0) for line in rope.lines),
        ends=hoist.ends, below=hoist.below, on=hoist.on,
    )  # fmt: skip
    bodies = _bodies(name, given, upper_mass)
    return OnHook(hook, rope, heavy, winch, hoist, _beam(yard, rig, name, given, bodies, pose, lugs, over))


def _bodies(name: str, given: schema.Beam, mass: float) -> tuple[Body, Body]:
    """From the hook eye to the hinge, and from there to the slings; uniform boxes."""
    beam = given.height - given.hinge

    def body(part: str, mass: float, size: Vector) -> Body:
        x, y, z = box(mass, size)
        return Body(f"{name}.{part}", mass, (0.0, 0.0, -size[2] / 2), ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)))

    upper = body("upper", mass, (given.falls_apart, 2.0, given.hinge))
    return upper, body("lower", given.lower_mass, (given.beam, 1.0, beam))


def _beam(
    yard: Yard, rig: schema.Rig, name: str, given: schema.Beam, bodies: tuple[Body, Body], pose: tuple[float, ...],
    lugs: list[str], over: list[Edges],
) -> plan.Mechanism:  # fmt: skip
    """Two bodies with a hinge that has stops, a damper and a brake, which holds while no sling is hooked; slings."""
    upper, lower, hinge = f"{name}.upper", f"{name}.lower", f"{name}.hinge"
    known, path, EA = lugs_of(yard.scene), ("rig", BEAMS, name), rig.sling.EA
    blocks = {word: point.body for word, point in known.items()}
    cargo = blocks[lugs[0]] if lugs else next(iter(blocks.values()), WORLD)
    damping = 2 * rig.sling.damping * math.sqrt(EA / given.sling * ((bodies[0].mass + bodies[1].mass) / 2))
    ropes, bent, ties = list[Rope](), list[Reeving](), list[plan.Tie]()
    for i in (0, 1):
        sling, beam, lug = f"{name}.sling-{i + 1}", _end(name, given, i), lugs[i] if i < len(lugs) else ""
        to = known[lug] if lug else Point(cargo, (0.0, 0.0, 0.0))
        if over[i]:
            bent.append(Reeving(sling, beam, over[i], to, EA, Signal(given.sling), damping, bool(lug)))
        else:
            ropes.append(Rope(sling, (Line(beam, to),), EA, given.sling, damping, hooked=bool(lug)))
        most, where = rated(rig.sling, yard.scene.gravity), yard.source.where((*path, "sling"))
        ties.append(plan.Tie(rope=sling, upper=beam, lug=key_of(lug, to) if lug else "", rated=most, where=where))
    turn = Joint(hinge, "revolute", upper, lower, (0.0, 0.0, -given.hinge), axis=(0.0, 1.0, 0.0), q0=(0.0,), v0=(0.0,))
    stop = Stop(f"{hinge}.stop", hinge, -given.stop, given.stop, given.stop_stiffness, given.stop_damping)
    lock = given.lock_moment, given.lock_stiffness, given.lock_damping
    brake = Brake(f"{hinge}.lock", hinge, *lock, not lugs)
    system = System(
        bodies=bodies,
        joints=(Joint(f"{name}.free", "free", WORLD, upper, q0=pose, v0=(0.0,) * 6), turn),
        springs=(JointSpring(f"{hinge}.damper", hinge, d=given.hinge_damping),),
        stops=(stop,),
        brakes=(brake,),
        ropes=tuple(ropes),
        forces=tuple(bent),
        gravity=yard.scene.gravity,
    )
    names = tuple(tie.rope for tie in ties)
    return plan.Mechanism(
        name=name,
        system=system,
        ties=tuple(ties),
        cells=(Cell(name=f"{name}.load", body=lower, ropes=names, rated=given.capacity * yard.scene.gravity),),
        latches=(Latch(brake=brake.name, ties=names),),
        shapes=tuple(_shapes(name, given)),
        levels=True,
        where=yard.source.where(path),
    )


def _shapes(name: str, given: schema.Beam) -> Iterator[plan.Shape]:
    """Hook block from the eye down to the hinge, as wide as its ropes are apart; beam between its slings."""
    wide, z = given.falls_apart or THIN, -given.hinge
    size = (wide, min(wide, 2.0), max(given.hinge, THIN))
    yield plan.Shape(body=f"{name}.upper", centre=(0.0, 0.0, z / 2), size=size, thing=name, part="hook block")
    down = -(given.height - given.hinge)
    size = (given.beam + THIN, THIN, max(-down, THIN))
    yield plan.Shape(body=f"{name}.lower", centre=(0.0, 0.0, down / 2), size=size, thing=name, part="beam")


def _over(
    yard: Yard, rig: schema.Rig, name: str, given: schema.Beam, lugs: list[Point], exit_: Vector, hangs: float
) -> tuple[list[Edges], float]:
    """The edges of each sling, and how far below its trolley the beam hangs, for which `hangs` is a guess [m]."""
    path = ("rig", BEAMS, name)
    if len(lugs) < 2:
        yard.source.fault((*path, "over edges"), "slings bend over edges from the start: hook them to 'lugs' then")
        return [(), ()], hangs
    ends = [(_end(name, given, i), lug) for i, lug in enumerate(lugs)]
    x, y, top = exit_
    R, up, blocks = np.eye(3), top - hangs - given.hinge, yard.scene.all_blocks
    at = {WORLD: (np.zeros(3), R), f"{name}.lower": (np.array([x, y, up]), R)}
    at |= {block: (np.array(given.at), R) for block, given in blocks.items()}
    coms = {block: given.com for block, given in blocks.items()}
    over = [along_edges(yard.source, path, given.over_edges, yard.scene.edges, pair, coms, lambda: at) for pair in ends]
    if len({edge.at.body for edge in over[0]}) > 1:
        told = "the block turns freely, so its slings bend over edges of one body only"
        yard.source.fault((*path, "over edges"), told)
    if yard.source.faults or given.rope is not None:
        return over, hangs

    def height(i: int) -> float:
        (dx, dy, dz), lug = ends[i][0].p, ends[i][1]

        def rope(z: float) -> Reeving:
            beam = Point(WORLD, (x + dx, y + dy, z - given.hinge + dz))
            return Reeving(f"{name}.sling-{i + 1}", beam, over[i], lug, rig.sling.EA, Signal(given.sling))

        low = blocks[lug.body].at[2] + lug.p[2] + given.hinge - dz + SPREAD
        return height_of(rope, low, given.sling, rig.slack, at, "over its edges")

    try:
        return over, top - min(height(0), height(1))
    except ValueError as error:
        yard.source.fault((*path, "sling"), str(error))
        return over, hangs


def _end(name: str, given: schema.Beam, i: int) -> Point:
    """The end of a beam at which a sling hangs."""
    return Point(f"{name}.lower", ((-1, 1)[i] * given.beam / 2, 0.0, -(given.height - given.hinge)))


def _rope(yard: Yard, name: str, given: schema.Beam, L0: float) -> Rope:
    """The falls of a hook as two lines that are apart."""
    crane_name, hook = yard.hooks[name]
    crane, blocks = yard.scene.cranes[crane_name], yard.scene.all_blocks
    leaves, half = parts_of(crane).hooks[hook], given.falls_apart / 2
    x, _, z = leaves.at
    lines = tuple(
        Line(Point(f"{crane_name}.{leaves.on}", (x + d, 0.0, z)), Point(f"{name}.upper", (d, 0.0, 0.0)), 0.5)
        for d in (-half, half)
    )
    carried = crane.hook_block + given.upper_mass + given.lower_mass
    carried += sum(block.mass for block in blocks.values()) / len(yard.hooks)
    EA = crane.falls * crane.fall_EA
    damping = 2 * crane.rope_damping * math.sqrt(EA / max(L0, 1e-3) * carried)
    return Rope(f"{crane_name}.{hook}", lines, EA, L0, damping, winch=True)


def trolley_start(yard: Yard, name: str, crane: schema.Crane, trolley: str) -> float:
    """y of a trolley at the start: as written, or above the mean of the lugs its beams carry [m]."""
    written = crane.upper_trolley if trolley == UPPER else crane.lower_trolley
    rig, known = yard.scene.rig, lugs_of(yard.scene)
    if written is not None or rig is None:
        return written if written is not None else sum(crane.girder) / 2
    hung = [beam for beam, (c, h) in yard.hooks.items() if c == name and parts_of(crane).hooks[h].on == trolley]
    lugs = [known[lug] for beam in hung for lug in rig.beams[beam].lugs or () if lug in known]
    if not lugs:
        return sum(crane.girder) / 2
    blocks = yard.scene.all_blocks
    y = blocks[lugs[0].body].at[1]
    return y + sum(lug.p[1] + (blocks[lug.body].at[1] - y) for lug in lugs) / len(lugs)


def spare_hooks(yard: Yard, crane: str = "") -> dict[str, Hook]:
    """Hooks of cranes on rails, or of one of them, on which no beam hangs: rigging may."""
    found, taken = dict[str, Hook](), {f"{owner}.{hook}" for owner, hook in yard.hooks.values()}
    for name, given in yard.scene.cranes.items():
        accel, _ = ramp_of(given.ramp)
        for hook, leaves in parts_of(given).hooks.items() if crane in ("", name) else ():
            if f"{name}.{hook}" not in taken:
                found[f"{name}.{hook}"] = Hook.model_construct(
                    on=f"{name}.{leaves.on}", at=leaves.at, falls=given.falls, block=given.hook_block,
                    capacity=given.hook_capacity, fall_EA=given.fall_EA, fall_breaking=given.fall_breaking,
                    mechanism_group=given.mechanism_group, speed=given.empty_hoist_speed, ramp=accel,
                    emergency=given.emergency, shortest=given.shortest_rope, longest=given.drum,
                    highest=given.highest_hook, damping=given.rope_damping,
                )  # fmt: skip
    return found


def with_hooks(yard: Yard, crane: plan.Mechanism, hung: plan.Mechanism) -> plan.Mechanism:
    """A crane with the hooks of rigging, too, which its load cells weigh."""
    hooks, cells = hung.hooks, []
    for cell in crane.cells:
        own = [hook for hook in hooks if cell.body in (hook.on, crane.system.bodies[0].name)]
        ropes, more = tuple(hook.rope for hook in own), sum(hook.block_mass for hook in own) * yard.scene.gravity
        cells.append(msgspec.structs.replace(cell, ropes=cell.ropes + ropes, rated=cell.rated + more))
    both = {
        of: getattr(crane, of) + getattr(hung, of) for of in ("actuators", "taut", "heavy", "bends", "shapes", "ties")
    }
    both |= {"hooks": crane.hooks + hooks, "cells": tuple(cells)}
    return msgspec.structs.replace(crane, system=merge([crane.system, hung.system], yard.scene.gravity), **both)
