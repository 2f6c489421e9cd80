"""Cranes, loaders, block and rig of a scene file as their part of the plan.

Names are resolved here, defaults become numbers, and the start is an equilibrium: the block lies on its stools under
its own weight, each loader hangs at rest on its stretched rope with its slings slack by the rig's `slack`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from heavylift.kernel.describe import Line, Point, Support, Vector

from . import plan, schema
from .faults import closest
from .source import Fault, Path, Source

UPPER, LOWER = "upper", "lower"
HOOKS = {"H1": ("upper", -1), "H2": ("upper", 1), "H3": ("lower", 0)}  # trolley, side along x


@dataclass
class Yard:
    """What the machines of a scene resolve to, while its faults are collected."""

    source: Source
    scene: schema.Scene
    cranes: list[plan.Crane] = field(default_factory=list)
    loaders: list[plan.Loader] = field(default_factory=list)
    block: plan.Block | None = None
    ropes: list[plan.HookRope] = field(default_factory=list)
    slings: list[plan.Sling] = field(default_factory=list)
    hooks: dict[str, tuple[str, str]] = field(default_factory=dict)  # loader -> (crane, hook)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)  # -> loaders

    def fault(self, path: Path, sentence: str, hint: str = "", *, on_key: bool = False) -> None:
        self.source.faults.append(Fault(path, sentence, hint, on_key))


def build_machines(source: Source, scene: schema.Scene) -> Yard:
    """All machines of the scene; what is wrong is added to the faults of the source."""
    yard = Yard(source, scene)
    if scene.block:
        yard.block = _block(yard, scene.block)
    if scene.rig:
        _hang(yard, scene.rig)
    lifting = {crane for crane, _ in yard.hooks.values()}
    for name, crane in scene.cranes.items():
        yard.cranes.append(_crane(yard, name, crane, tandem=len(lifting) > 1))
    if scene.rig:
        for name, loader in scene.rig.loaders.items():
            if name in yard.hooks:
                _loader(yard, scene.rig, name, loader)
        _groups(yard, scene.rig)
    return yard


def box(mass: float, size: Vector) -> Vector:
    """Moments of inertia of a uniform box about its centre [kg m2]."""
    x, y, z = (s * s for s in size)
    return (mass / 12 * (y + z), mass / 12 * (x + z), mass / 12 * (x + y))


def exit_height(crane: schema.Crane, hook: str) -> float:
    """World z where the ropes of a hook leave its trolley [m]."""
    return crane.upper_exit if HOOKS[hook][0] == UPPER else crane.lower_exit


def trolley_start(yard: Yard, name: str, crane: schema.Crane, trolley: str) -> float:
    """y of a trolley at the start: as written, or above the mean of the lugs its loaders carry [m]."""
    written = crane.upper_trolley if trolley == UPPER else crane.lower_trolley
    block, rig = yard.scene.block, yard.scene.rig
    if written is not None or block is None or rig is None:
        return written if written is not None else sum(crane.girder) / 2
    hung = [loader for loader, (c, h) in yard.hooks.items() if c == name and HOOKS[h][0] == trolley]
    lugs = [lug for loader in hung for lug in rig.loaders[loader].lugs or () if lug in block.lugs]
    if not lugs:
        return sum(crane.girder) / 2
    return block.at[1] + sum(block.lugs[lug][1] for lug in lugs) / len(lugs)


def _hang(yard: Yard, rig: schema.Rig) -> None:
    """Who hangs on which hook."""
    known = [f"{crane} {hook}" for crane in yard.scene.cranes for hook in HOOKS]
    taken: dict[str, str] = {}
    for name, loader in rig.loaders.items():
        path: Path = ("rig", "loaders", name, "hook")
        words = " ".join(loader.hook.split())
        if words not in known:
            yard.fault(path, f"there is no hook '{loader.hook}'", closest(words, known))
        elif words in taken:
            yard.fault(path, f"the hook {words} already carries {taken[words]}")
        else:
            taken[words] = name
            crane, hook = words.split()
            yard.hooks[name] = (crane, hook)
        if name in yard.scene.cranes:
            yard.fault(path[:-1], f"the name '{name}' is given twice: a crane has it, too", on_key=True)
    used: dict[str, str] = {}
    for name, loader in rig.loaders.items():
        for i, lug in enumerate(loader.lugs or ()):
            path = ("rig", "loaders", name, "lugs", i)
            lugs = yard.scene.block.lugs if yard.scene.block else {}
            if lug not in lugs:
                yard.fault(path, f"the block has no lug '{lug}'", closest(lug, lugs))
            elif lug in used:
                yard.fault(path, f"the lug {lug} already carries a sling of {used[lug]}")
            used.setdefault(lug, name)


def _crane(yard: Yard, name: str, crane: schema.Crane, *, tandem: bool) -> plan.Crane:
    where = yard.source.where(("cranes", name))
    omega = 2 * math.pi * crane.servo_frequency

    def axis(start: float, ends: tuple[float, float], mass: float) -> plan.Axis:
        kp, kv = mass * omega**2, 2 * crane.servo_damping * mass * omega
        return plan.Axis(start=start, lower=ends[0], upper=ends[1], accel=crane.ramp, kp=kp, kv=kv)

    def trolley(which: str, mass: float, height: float, capacity: float) -> plan.Trolley:
        size = (2 * crane.hook_spacing, crane.trolley_length, 4.0)
        body = plan.Inertia(mass=mass, com=(0.0, 0.0, height), moments=box(mass, size))
        y = trolley_start(yard, name, crane, which)
        key = f"{which} trolley"
        place = yard.source.where(("cranes", name, key))
        slide = axis(y, crane.girder, mass)
        kind: plan.Literal[upper, lower] = "upper" if which == UPPER else "lower"
        return plan.Trolley(name=kind, body=body, axis=slide, capacity=capacity, where=place)

    hooks = []
    for loader, (owner, hook) in yard.hooks.items():
        if owner == name:
            place = yard.source.where(("rig", "loaders", loader, "hook"))
            which: plan.Literal[upper, lower] = "upper" if HOOKS[hook][0] == UPPER else "lower"
            hooks.append(
                plan.Hook(
                    name=hook,
                    rope=f"{name}.{hook}",
                    trolley=which,
                    accel=crane.ramp,
                    shortest=crane.shortest_rope,
                    drum=crane.drum,
                    highest=crane.highest_hook,
                    capacity=crane.hook_capacity,
                    block_mass=crane.hook_block,
                    where=place,
                )
            )
    portal = (crane.width, crane.span, crane.upper_exit)
    middle = (0.0, crane.span / 2, 0.7 * crane.upper_exit)
    moving = crane.main_mass + crane.upper_mass + crane.lower_mass
    return plan.Crane(
        name=name,
        main=plan.Inertia(mass=crane.main_mass, com=middle, moments=box(crane.main_mass, portal)),
        gantry=axis(crane.at, crane.rails, moving),
        upper=trolley(UPPER, crane.upper_mass, crane.upper_exit, crane.upper_capacity),
        lower=trolley(LOWER, crane.lower_mass, crane.lower_exit, crane.lower_capacity),
        hooks=tuple(sorted(hooks, key=lambda hook: hook.name)),
        capacity=crane.capacity * (crane.tandem if tandem else 1.0),
        where=where,
    )


def _loader(yard: Yard, rig: schema.Rig, name: str, loader: schema.Loader) -> None:
    path: Path = ("rig", "loaders", name)
    crane_name, hook = yard.hooks[name]
    crane = yard.scene.cranes[crane_name]
    top, gravity = exit_height(crane, hook), yard.scene.gravity
    mass = crane.hook_block + loader.upper_mass + loader.lower_mass
    block = yard.scene.block
    lugs = [lug for lug in loader.lugs or () if block and lug in block.lugs]
    strain = mass * gravity / (crane.falls * crane.fall_EA)
    if loader.rope is not None:
        hangs = loader.rope * (1 + strain)
    elif block and lugs:
        lug_z = block.at[2] + sum(block.lugs[lug][2] for lug in lugs) / len(lugs)
        hangs = top - (lug_z + loader.sling + loader.height - rig.slack)
    else:
        hangs = top - crane.highest_hook
    x = crane.at + HOOKS[hook][1] * crane.hook_spacing
    y = trolley_start(yard, name=crane_name, crane=crane, trolley=HOOKS[hook][0])
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
    _slings(yard, rig, name, loader, lugs)


def _rope(yard: Yard, name: str, loader: schema.Loader, L0: float) -> None:
    crane_name, hook = yard.hooks[name]
    crane, block = yard.scene.cranes[crane_name], yard.scene.block
    trolley, side = HOOKS[hook]
    x, z, half = side * crane.hook_spacing, exit_height(crane, hook), loader.falls_apart / 2
    lines = tuple(
        Line(Point(f"{crane_name}.{trolley}", (x + d, 0.0, z)), Point(f"{name}.upper", (d, 0.0, 0.0)), 0.5)
        for d in (-half, half)
    )
    carried = crane.hook_block + loader.upper_mass + loader.lower_mass
    carried += block.mass / len(yard.hooks) if block else 0.0
    EA = crane.falls * crane.fall_EA
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
            rated=crane.falls * crane.fall_breaking / crane.rope_factor,
            where=yard.source.where(("rig", "loaders", name, "hook")),
        )
    )


def _slings(yard: Yard, rig: schema.Rig, name: str, loader: schema.Loader, lugs: list[str]) -> None:
    block = yard.scene.block
    if block:
        lugs = by_beam(lugs, {lug: block.lugs[lug][0] for lug in lugs})
    bottom = -(loader.height - loader.hinge)
    half_mass = (yard.loaders[-1].upper.mass + loader.lower_mass) / 2
    for i, side in enumerate((-1, 1)):
        yard.slings.append(
            plan.Sling(
                name=f"{name}.sling-{i + 1}",
                loader=name,
                beam=Point(f"{name}.lower", (side * loader.beam / 2, 0.0, bottom)),
                lug=lugs[i] if i < len(lugs) else "",
                L0=loader.sling,
                EA=rig.sling.EA,
                damping=2 * rig.sling.damping * math.sqrt(rig.sling.EA / loader.sling * half_mass),
                rated=rig.sling.breaking / rig.sling.factor,
                where=yard.source.where(("rig", "loaders", name, "sling")),
            )
        )


def by_beam(lugs: list[str], u: dict[str, float]) -> list[str]:
    """Two lugs in the order of the beam's ends, smaller u first."""
    return sorted(lugs, key=lambda lug: u[lug])


def _block(yard: Yard, block: schema.Block) -> plan.Block:
    pads, stools = [], block.supports
    n, half = len(stools.at), block.size[2] / 2
    k = block.mass * yard.scene.gravity / (n * stools.settlement)
    d = 2 * stools.damping * math.sqrt(k * block.mass / n)
    for face, side in ((LOWER, -1), (UPPER, 1)):
        for i, (u, v) in enumerate(stools.at):
            support = Support(
                f"block.{face}-{i + 1}",
                Point("block", (u, v, side * half)),
                stools.height,
                k,
                d,
                stools.friction,
                k if stools.friction else 0.0,
                d if stools.friction else 0.0,
            )
            where = yard.source.where(("block", "supports", "at", i))
            pads.append(plan.Pad(support=support, face=face, closed=face == LOWER, where=where))
    return plan.Block(
        body=plan.Inertia(
            mass=block.mass, com=block.com, moments=block.inertia or box(block.mass, block.size)
        ),
        pose=_resting(block),
        lugs=tuple(
            plan.Lug(name=lug, p=p, where=yard.source.where(("block", "lugs", lug)))
            for lug, p in block.lugs.items()
        ),
        pads=tuple(pads),
        where=yard.source.where(("block",)),
    )


def _resting(block: schema.Block) -> tuple[float, float, float, float, float, float, float]:
    """Pose of the block in equilibrium on its stools: k sum(depth) = weight, with depth = a + b u + c v."""
    places = np.array([(1.0, u, v) for u, v in block.supports.at])
    load = len(places) * block.supports.settlement * np.array([1.0, block.com[0], block.com[1]])
    a, b, c = (float(x) for x in np.linalg.lstsq(places.T @ places, load, rcond=None)[0])
    x, y, z = block.at
    norm = math.sqrt(1 + (b * b + c * c) / 4)
    return (x, y, z - a, -c / 2 / norm, b / 2 / norm, 0.0, 1 / norm)


def _groups(yard: Yard, rig: schema.Rig) -> None:
    on_hook = {" ".join(yard.hooks[loader]): loader for loader in yard.hooks}
    for name, members in rig.groups.items():
        found = []
        for i, member in enumerate(members):
            words = " ".join(member.split())
            if words not in on_hook:
                path: Path = ("rig", "groups", name, i)
                yard.fault(path, f"no loader hangs on a hook '{member}'", closest(words, on_hook))
            else:
                found.append(on_hook[words])
        yard.groups[name] = tuple(dict.fromkeys(found))
