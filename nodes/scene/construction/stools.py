"""The blocks of a scene file as parts of the plan: lying in equilibrium on their stools.

Stiffness of a support = its equal share of the weight over the settlement; damping from the ratio given.
"""

from __future__ import annotations

import math

from heavylift.kernel.algebra.dense import dot, least_norm, singular_values
from heavylift.kernel.description.mechanics import WORLD, Body, Joint, Point, Support, System, Vector
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.checks import check_inertia
from heavylift.nodes.models.parts.bending import block_body
from heavylift.nodes.plan import plan
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.text.source import Path

from .bending import flexible_of
from .yard import LOWER, UPPER, Yard, box

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
    if block.inertia:
        _check_moments(yard, block, base)
    body = plan.Inertia(mass=block.mass, com=block.com, moments=block.inertia or box(block.mass, block.size))
    return plan.Block(
        name=name,
        body=body,
        size=block.size,
        pose=_resting(block, yard.scene.vessels[block.on].at if block.on in yard.scene.vessels else (0.0, 0.0, 0.0)),
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
    shape = plan.Shape(body=name, centre=(0.0, 0.0, 0.0), size=block.size)
    closed = tuple(pad.support.name for pad in pads)
    return plan.Mechanism(name=name, system=system, closed=closed, shapes=(shape,), where=block.where)


def _check_moments(yard: Yard, block: schema.Block, base: Path) -> None:
    """Some body must be able to have them."""
    assert block.inertia is not None
    x, y, z = block.inertia
    try:
        check_inertia(Body(str(base[-1]), block.mass, inertia=((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))))
    except KernelError as error:
        yard.source.fault((*base, "inertia"), str(error))


def _resting(block: schema.Block, origin: Vector) -> tuple[float, float, float, float, float, float, float]:
    """Pose of the block in equilibrium on its stools: k sum(depth) = weight, with depth = a + b u + c v; `origin`: from
    which its place counts."""
    places = [(1.0, u, v) for u, v in block.supports.at]
    total = len(places) * block.supports.settlement
    load = [total, total * block.com[0], total * block.com[1]]
    A = [[dot(p, q) for q in zip(*places, strict=True)] for p in zip(*places, strict=True)]
    a, b, c = least_norm(A, load, SINGULAR * max(singular_values(A)))
    x, y, z = (p + q for p, q in zip(block.at, origin, strict=True))
    norm = math.sqrt(1 + (b * b + c * c) / 4)
    return (x, y, z - a, -c / 2 / norm, b / 2 / norm, 0.0, 1 / norm)
