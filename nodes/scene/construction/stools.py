"""The blocks of a scene file as parts of the plan: lying in equilibrium on their stools, and what of them bends.

Stiffness of a support = its equal share of the weight over the settlement; damping from the ratio given.  As a beam a
block bends from end to end along its x, and its frame is the mean of it; modes of a table stand at its lugs and pads.
The displacements of all lugs within it are sampled, and of a beam those of its ends and its middle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from heavylift.kernel.algebra.dense import dot, least_norm, singular_values
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.flexible import Beam, Flexible, Gauge, Modal, check_flexible
from heavylift.kernel.description.mechanics import WORLD, Body, Joint, Point, Support, System, Vector
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.checks import check_inertia
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.bending import block_body
from heavylift.nodes.plan.mechanism import Cargo
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.environment import Vessel
from heavylift.nodes.scene.keys.parts.flexible import Hull
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path

from .yard import LOWER, UPPER, Yard, box

SAME = 1e-9  # relative, of masses that are equal
SINGULAR = 1e-12  # singular value, relative, of stools in one line


def build_block(yard: Yard, block: schema.Block, base: Path = ("block",)) -> plan.Block:
    """A block with its lugs and pads; `base`: where it stands in the scene, its name last."""
    pads, stools, name = [], block.supports, str(base[-1])
    n, half = len(stools.at), block.size[2] / 2
    k = block.mass * yard.scene.gravity / (n * stools.settlement)
    d = 2 * stools.damping * math.sqrt(k * block.mass / n)
    for face, side in ((LOWER, -1), (UPPER, 1)):
        for i, (u, v) in enumerate(stools.at):
            support = Support(
                f"{name}.{face}-{i + 1}",
                Point(name, (u, v, side * half)),
                stools.height,
                k,
                d,
                stools.friction,
                k if stools.friction else 0.0,
                d if stools.friction else 0.0,
                "" if block.on == WORLD else block.on,
            )
            where = yard.source.where((*base, "supports", "at", i))
            pads.append(plan.Pad(support=support, face=face, closed=face == LOWER, where=where))
    xx, yy, zz, xy, xz, yz = (*(block.inertia or box(block.mass, block.size)), 0.0, 0.0, 0.0)[:6]
    body = plan.Inertia(mass=block.mass, com=block.com, moments=(xx, yy, zz), products=(xy, xz, yz))
    try:
        check_inertia(Body(name, block.mass, inertia=body.matrix))
    except KernelError as error:
        yard.source.fault((*base, "inertia"), str(error))
    return plan.Block(
        name=name,
        body=body,
        size=block.size,
        slices=tuple(block.shape.slices) if block.shape else (),
        pose=_resting(block, yard.scene.vessels.get(block.on)),
        lugs=tuple(
            plan.Lug(name=lug, p=p, where=yard.source.where((*base, "lugs", lug))) for lug, p in block.lugs.items()
        ),
        pads=tuple(pads),
        flexible=flexible_of(yard, block, body, pads, base),
        where=yard.source.where(base),
        com_where=yard.source.where((*base, "com")),
    )


def block_machine(yard: Yard, name: str) -> plan.Mechanism:
    """One of several blocks as a machine made of parts: a body on a free joint above its stools."""
    block = build_block(yard, yard.scene.blocks[name], ("blocks", name))
    pads = [pad for pad in block.pads if pad.closed]
    system = System(
        bodies=(block_body(name, block.body, block.flexible),),
        joints=(Joint(f"{name}.free", "free", WORLD, name, q0=block.pose, v0=(0.0,) * 6),),
        supports=tuple(pad.support for pad in pads),
        gravity=yard.scene.gravity,
    )
    boxes = block.slices or (((0.0, 0.0, 0.0), block.size),)
    shapes = tuple(plan.Shape(body=name, centre=centre, size=size) for centre, size in boxes)
    closed = tuple(pad.support.name for pad in pads)
    lugs = {f"{name}.{lug}": p for lug, p in yard.scene.blocks[name].lugs.items()}
    cargo = Cargo(body=name, com=block.body.com, lugs=lugs)
    return plan.Mechanism(name=name, system=system, closed=closed, shapes=shapes, cargo=(cargo,), where=block.where)


def _resting(block: schema.Block, on: Vessel | None) -> tuple[float, float, float, float, float, float, float]:
    """Pose of the block in equilibrium on its stools: k sum(depth) = weight, with depth = a + b u + c v."""
    places = [(1.0, u, v) for u, v in block.supports.at]
    total = len(places) * block.supports.settlement
    load = [total, total * block.com[0], total * block.com[1]]
    A = [[dot(p, q) for q in zip(*places, strict=True)] for p in zip(*places, strict=True)]
    a, b, c = least_norm(A, load, SINGULAR * max(singular_values(A)))
    x, y, z = on.place(block.at) if on else block.at
    norm = math.sqrt(1 + (b * b + c * c) / 4)
    i, j, w = -c / 2 / norm, b / 2 / norm, 1 / norm
    if on is None or not on.heading:
        return (x, y, z - a, i, j, 0.0, w)
    d, s = float(cos(0.5 * on.heading)), float(sin(0.5 * on.heading))
    return (x, y, z - a, d * i - s * j, d * j + s * i, s * w, d * w)


def flexible_of(
    yard: Yard, block: schema.Block, body: plan.Inertia, pads: list[plan.Pad], base: Path
) -> Flexible | None:
    """What bends of a block with its mass properties and pads, if anything does; what is wrong is a fault."""
    if block.beam is None and not block.modes:
        return None
    key: Path = (*base, "beam" if block.beam else "modes")
    if block.beam and block.modes:
        yard.source.fault((*base, "modes"), "a flexible block has either a 'beam' or 'modes'", on_key=True)
        return None
    made = _beam(yard, block, block.beam, body, key) if block.beam else _modes(yard, block, pads, base)
    if made is None:
        return None
    try:
        check_flexible(str(base[-1]), made)
        check_inertia(block_body(str(base[-1]), body, made))
    except KernelError as error:
        told = "; give the beam a 'mass', that of what bends with it, or the block its 'inertia'" if made.beam else ""
        yard.source.fault(key, f"{error}{told}", on_key=True)
    return made


def _beam(yard: Yard, block: schema.Block, hull: Hull, body: plan.Inertia, key: Path) -> Flexible | None:
    length, bends = block.size[0], hull.mass or block.mass
    if bends > block.mass * (1.0 + SAME):
        told = f"the block has {block.mass / 1e3:g} t, of which no {bends / 1e3:g} t can bend"
        yard.source.fault((*key, "mass"), told)
        return None
    if any(block.com) and bends > block.mass * (1.0 - SAME):
        told = "the mass of a uniform beam is not aside, as 'com' says: give the beam a 'mass', less than the block's"
        yard.source.fault(key, told, on_key=True)
        return None
    polar = body.moments[0] / length * (bends / block.mass)
    beam = Beam(length, bends / length, *hull.stiffness, polar, hull.elements, start=-length / 2)
    along = {"end-1": -length / 2, "middle": 0.0, "end-2": length / 2}
    for lug, p in block.lugs.items():
        if abs(p[0]) > length / 2:
            told = f"the lug stands {p[0]:g} m along a beam that ends at {length / 2:g} m"
            yard.source.fault((*key[:-1], "lugs", lug), told)
    gauges = (*_gauges(block.lugs), *(Gauge(name, (x, 0.0, 0.0)) for name, x in along.items()))
    return Flexible(hull.modes, beam, frame="free", damping=hull.damping, loads=tuple(hull.loads), gauges=gauges)


def _modes(yard: Yard, block: schema.Block, pads: list[plan.Pad], base: Path) -> Flexible | None:
    places = {**block.lugs, **{pad.support.name.partition(".")[2]: pad.support.point.p for pad in pads}}
    named = dict.fromkeys(word for mode in block.modes.values() for word in mode.shape)
    for name, mode in block.modes.items():
        for word in (word for word in mode.shape if word not in places):
            path = (*base, "modes", name, "shape", word)
            yard.source.fault(path, f"the block has no lug or stool '{word}'", closest(word, places), on_key=True)
    if any(word not in places for word in named):
        return None
    modes = block.modes.values()
    still = (0.0, 0.0, 0.0)
    modal = Modal(
        tuple(places[word] for word in named),
        tuple(tuple(mode.shape.get(word, still) for word in named) for mode in modes),
        tuple(mode.frequency for mode in modes),
        tuple(mode.mass for mode in modes),
        tuple(mode.damping for mode in modes),
    )
    return Flexible(len(block.modes), modal=modal, gauges=tuple(_gauges({word: places[word] for word in named})))


def _gauges(places: dict[str, Vector]) -> Iterator[Gauge]:
    return (Gauge(name, p) for name, p in places.items())
