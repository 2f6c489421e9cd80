"""What hangs on the hooks of cranes on rails: hook rope, frame as its type makes it, slings.

Each hangs at rest below its trolley on its stretched rope, its slings slack by `slack`, straight or over edges.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import msgspec
import numpy as np
from heavylift.kernel.description.forces import InputSignal, Reeving, Sheave
from heavylift.kernel.description.mechanics import (
    WORLD,
    Point,
    Rope,
    RopeSpan,
    System,
    Vector,
    merge,
)
from heavylift.nodes.limits.reeving import lead_factor
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.mechanism import BrakeLatch, Cell, Heavy
from heavylift.nodes.plan.spellings import BEAMS
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.nodes.scene.keys.parts.joints import Free
from heavylift.nodes.scene.keys.parts.machines import FrameParts
from heavylift.nodes.scene.keys.parts.mechanics import HookKeys
from heavylift.nodes.scene.text.faults import closest, raise_faults
from heavylift.nodes.scene.text.source import Path

from .limiting import reeving, rope_factor
from .mechanism import build_mechanism
from .rigging.edges import SPREAD, along_edges, height_of
from .rigging.slings import key_of, lugs_of, rated
from .scene_builder import UPPER, SceneBuilder, by_beam, parts_of, ramp_of

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


def on_hook(yard: SceneBuilder, rig: schema.RigKeys, name: str, given: schema.FrameKeys) -> OnHook:
    """What hangs on the hook of a beam, which is there."""
    path: Path = ("rig", BEAMS, name)
    crane_name, hook = yard.hooks[name]
    crane = yard.scene.cranes[crane_name]
    leaves, known = parts_of(crane).hooks[hook], lugs_of(yard.scene)
    frame = _frame(yard, name, given.parts, crane.hook_block)
    system, at = frame.system, kinematics.poses(frame.system)
    top, mass = leaves.at[2], sum(body.mass for body in system.bodies)
    ends, lugs = [Point(end.body, end.at) for end in given.parts.slings], [x for x in given.lugs or () if x in known]
    if given.lugs and len(given.lugs) != len(ends):
        yard.source.fault((*path, "lugs"), f"{len(ends)} slings hang on it, which need as many lugs")
    lugs = by_beam(lugs, {lug: p.p[0] for lug, p in known.items()})
    strain = mass * yard.scene.gravity / (crane.falls * crane.fall_EA)
    if given.rope is not None:
        hangs = given.rope * (1 + strain)
    elif lugs:
        lug_z = yard.scene.all_blocks[known[lugs[0]].body].at[2] + sum(known[lug].p[2] for lug in lugs) / len(lugs)
        height = -sum(float(kinematics.place(end, at)[2]) for end in ends) / len(ends)
        hangs = top - (lug_z + given.sling + height - rig.slack)
    else:
        hangs = top - crane.highest_hook
    x, y = crane.at + leaves.at[0], trolley_start(yard, name=crane_name, crane=crane, trolley=leaves.on)
    over: list[Edges] = [()] * len(ends)
    if given.over_edges:
        over, hangs = _over(yard, rig, name, given, at, [known[lug] for lug in lugs], (x, y, top), hangs)
    pose = (x, y, top - hangs, 0.0, 0.0, 0.0, 1.0)
    rope = _rope(yard, name, given, mass, hangs / (1 + strain))
    winch = plan.Actuator(
        name=rope.name, start=rope.L0, accel=ramp_of(crane.ramp)[0], lower=crane.shortest_rope, upper=crane.drum,
        highest=crane.highest_hook, emergency=crane.emergency,
    )  # fmt: skip
    drums, efficiency, _ = reeving(crane)
    part = crane.fall_breaking / rope_factor(crane)[0] - crane.fall_mass * yard.scene.gravity * rope.L0
    n = len(rope.lines)
    a, b, z = (sum(line.a.p[i] for line in rope.lines) / n for i in range(3))
    ex, ey, ez = (sum(line.b.p[i] for line in rope.lines) / n + pose[i] for i in range(3))
    hoist = plan.Hoist(
        rope=rope.name,
        eye=Point(given.parts.eye.body, (0.0, 0.0, 0.0)),
        block_mass=crane.hook_block,
        capacity=crane.hook_capacity,
        on=f"{crane_name}.{leaves.on}",
        line=crane.falls * crane.fall_mass,
        ends=((a + crane.at, b + y, z), (ex, ey, ez)),
        below=mass,
        falls=crane.falls,
        drum_ends=drums,
        efficiency=efficiency,
        breaking=crane.fall_breaking,
        rated=max(crane.falls * part / lead_factor(crane.falls, drums, efficiency), 0.0),
        where=yard.source.where((*path, "hook")),
    )
    assert hoist.ends is not None
    heavy = Heavy(
        rope=rope.name, line=hoist.line, beside=tuple((line.b.p[0], 0.0, 0.0) for line in rope.lines),
        ends=hoist.ends, below=hoist.below, on=hoist.on,
    )  # fmt: skip
    free = replace(system.joints[0], q0=pose)
    frame = msgspec.structs.replace(frame, system=replace(system, joints=(free, *system.joints[1:])))
    return OnHook(hook, rope, heavy, winch, hoist, _slung(yard, rig, name, given, frame, lugs, over))


def _frame(yard: SceneBuilder, name: str, parts: FrameParts, block: float) -> plan.Mechanism:
    """Its bodies and joints with the hook block, the origin of whose body hangs at that of the world."""
    base, eye = ("rig", BEAMS, name, "parts"), parts.eye.body
    ends: dict[Path, str] = {("slings", i): end.body for i, end in enumerate(parts.slings)}
    for key, body in ({("eye",): eye} | ends).items():
        if body not in parts.bodies:
            yard.source.fault((*base, *key, "body"), f"there is no body '{body}'", closest(body, parts.bodies))
    raise_faults(yard.source, yard.source.faults)
    own = parts.bodies[eye]
    bodies, below = {eye: own.model_copy(update={"mass": (own.mass or 0.0) + block})}, [eye]
    for body in below:  # from the eye down
        below += [x.child for x in parts.joints.values() if x.parent == body and x.child not in below]
    bodies |= {body: parts.bodies[body] for body in (*below, *parts.bodies) if body in parts.bodies and body != eye}
    still = (0.0, 0.0, 0.0)
    free = Free.model_construct(type="free", child=eye, position=still, velocity=still, rate=still)
    hung = parts.model_copy(update={"bodies": bodies, "joints": {f"{name}.free": free, **parts.joints}})
    made = build_mechanism(yard.source, hung, yard.scene.gravity, base=base)
    raise_faults(yard.source, yard.source.faults)
    shapes = tuple(msgspec.structs.replace(shape, thing=name) for shape in made.shapes)
    return msgspec.structs.replace(made, name=name, shapes=shapes)


def _slung(
    yard: SceneBuilder, rig: schema.RigKeys, name: str, given: schema.FrameKeys, frame: plan.Mechanism, lugs: list[str],
    over: list[Edges],
) -> plan.Mechanism:  # fmt: skip
    """A frame with its slings, which lock brakes of it while none is hooked."""
    known, path, EA = lugs_of(yard.scene), ("rig", BEAMS, name), rig.sling.EA
    blocks = {word: point.body for word, point in known.items()}
    cargo = blocks[lugs[0]] if lugs else next(iter(blocks.values()), WORLD)
    mass = sum(body.mass for body in frame.system.bodies)
    damping = 2 * rig.sling.damping * math.sqrt(EA / given.sling * (mass / 2))
    ropes, bent, ties = list[Rope](), list[Reeving](), list[plan.Tie]()
    for i, end in enumerate(given.parts.slings):
        sling, upper, lug = f"{name}.sling-{i + 1}", Point(end.body, end.at), lugs[i] if i < len(lugs) else ""
        to = known[lug] if lug else Point(cargo, (0.0, 0.0, 0.0))
        if over[i]:
            bent.append(Reeving(sling, upper, over[i], to, EA, InputSignal(given.sling), damping, bool(lug)))
        else:
            ropes.append(Rope(sling, (RopeSpan(upper, to),), EA, given.sling, damping, hooked=bool(lug)))
        most, where = rated(rig.sling, yard.scene.gravity), yard.source.where((*path, "sling"))
        ties.append(plan.Tie(rope=sling, upper=upper, lug=key_of(lug, to) if lug else "", rated=most, where=where))
    names, locks = tuple(tie.rope for tie in ties), {f"{name}.{x}" for x in given.parts.locked_while_empty}
    brakes = tuple(replace(x, engaged=not lugs) if x.name in locks else x for x in frame.system.brakes)
    if unknown := locks - {brake.name for brake in brakes}:
        there = f"there is no brake '{min(unknown).removeprefix(f'{name}.')}'"
        yard.source.fault((*path, "parts", "locked while empty"), there, on_key=True)
    own, load = replace(frame.system, brakes=brakes), given.capacity * yard.scene.gravity
    return msgspec.structs.replace(
        frame,
        system=merge([own, System(ropes=tuple(ropes), forces=tuple(bent))], yard.scene.gravity),
        ties=tuple(ties),
        cells=(Cell(name=f"{name}.load", body=ties[0].upper.body, ropes=names, rated=load),),
        latches=tuple(BrakeLatch(brake=brake.name, ties=names) for brake in brakes if brake.name in locks),
        levels=True,
        where=yard.source.where(path),
    )


def _over(
    yard: SceneBuilder, rig: schema.RigKeys, name: str, given: schema.FrameKeys, own: kinematics.Poses,
    lugs: list[Point], exit_: Vector, hangs: float,
) -> tuple[list[Edges], float]:  # fmt: skip
    """The edges of each sling, and how far below its trolley the beam hangs, for which `hangs` is a guess [m]; `own`:
    where its bodies are from its eye."""
    path = ("rig", BEAMS, name)
    if len(lugs) < len(given.parts.slings):
        yard.source.fault((*path, "over edges"), "slings bend over edges from the start: hook them to 'lugs' then")
        return [()] * len(given.parts.slings), hangs
    ends = [(Point(end.body, end.at), lug) for end, lug in zip(given.parts.slings, lugs, strict=True)]
    x, y, top = exit_
    R, blocks, eye = np.eye(3), yard.scene.all_blocks, np.array([x, y, top - hangs])
    at = {WORLD: (np.zeros(3), R)} | {body: (eye + p, Q) for body, (p, Q) in own.items() if body != WORLD}
    at |= {block: (np.array(given.at), R) for block, given in blocks.items()}
    coms = {block: given.com for block, given in blocks.items()}
    over = [along_edges(yard.source, path, given.over_edges, yard.scene.edges, pair, coms, lambda: at) for pair in ends]
    if len({edge.at.body for edge in over[0]}) > 1:
        told = "the block turns freely, so its slings bend over edges of one body only"
        yard.source.fault((*path, "over edges"), told)
    if yard.source.faults or given.rope is not None:
        return over, hangs

    def height(i: int) -> float:
        (dx, dy, dz), lug = kinematics.place(ends[i][0], own).tolist(), ends[i][1]

        def rope(z: float) -> Reeving:
            upper = Point(WORLD, (x + dx, y + dy, z + dz))
            return Reeving(f"{name}.sling-{i + 1}", upper, over[i], lug, rig.sling.EA, InputSignal(given.sling))

        low = blocks[lug.body].at[2] + lug.p[2] - dz + SPREAD
        return height_of(rope, low, given.sling, rig.slack, at, "over its edges")

    try:
        return over, top - min(map(height, range(len(ends))))
    except ValueError as error:
        yard.source.fault((*path, "sling"), str(error))
        return over, hangs


def _rope(yard: SceneBuilder, name: str, given: schema.FrameKeys, carried: float, L0: float) -> Rope:
    """The falls of a hook as two lines that are apart."""
    crane_name, hook = yard.hooks[name]
    crane, blocks = yard.scene.cranes[crane_name], yard.scene.all_blocks
    leaves, half, eye = parts_of(crane).hooks[hook], given.parts.eye.apart / 2, given.parts.eye.body
    x, _, z = leaves.at
    lines = tuple(
        RopeSpan(Point(f"{crane_name}.{leaves.on}", (x + d, 0.0, z)), Point(eye, (d, 0.0, 0.0)), 0.5)
        for d in (-half, half)
    )
    carried += sum(block.mass for block in blocks.values()) / len(yard.hooks)
    EA = crane.falls * crane.fall_EA
    damping = 2 * crane.rope_damping * math.sqrt(EA / max(L0, 1e-3) * carried)
    return Rope(f"{crane_name}.{hook}", lines, EA, L0, damping, winch=True)


def trolley_start(yard: SceneBuilder, name: str, crane: schema.CraneKeys, trolley: str) -> float:
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


def spare_hooks(yard: SceneBuilder, crane: str = "") -> dict[str, HookKeys]:
    """Hooks of cranes on rails, or of one of them, on which no beam hangs: rigging may."""
    found, taken = dict[str, HookKeys](), {f"{owner}.{hook}" for owner, hook in yard.hooks.values()}
    for name, given in yard.scene.cranes.items():
        accel, _ = ramp_of(given.ramp)
        for hook, leaves in parts_of(given).hooks.items() if crane in ("", name) else ():
            if f"{name}.{hook}" not in taken:
                found[f"{name}.{hook}"] = HookKeys.model_construct(
                    on=f"{name}.{leaves.on}", at=leaves.at, falls=given.falls, block=given.hook_block,
                    capacity=given.hook_capacity, fall_EA=given.fall_EA, fall_breaking=given.fall_breaking,
                    mechanism_group=given.mechanism_group, speed=given.empty_hoist_speed, ramp=accel,
                    emergency=given.emergency, shortest=given.shortest_rope, longest=given.drum,
                    highest=given.highest_hook, damping=given.rope_damping,
                )  # fmt: skip
    return found


def with_hooks(yard: SceneBuilder, crane: plan.Mechanism, hung: plan.Mechanism) -> plan.Mechanism:
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
