"""The blocks of a scene file as parts of the plan: in equilibrium on their supports, rigid or flexible.

The stiffness of a support is its equal share of the weight divided by the given settlement; its damping follows from
the given ratio. As a beam, a block bends from end to end along its x axis, relative to its mean frame; tabulated modes
are given at its lugs and supports. The elastic displacements of all lugs are recorded, and for a beam also those of its
ends and middle.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

from heavylift.kernel.algebra.dense import dot, least_norm, singular_values
from heavylift.kernel.algebra.elementary import atan2, cos, sin
from heavylift.kernel.description.flexible import Beam, Flexible, Gauge, Modal, check_flexible
from heavylift.kernel.description.forces import Immersion
from heavylift.kernel.description.mechanics import WORLD, Body, Joint, Point, Support, System, Vector
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.checks import check_inertia
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.bending import block_body
from heavylift.nodes.plan.mechanism import Cargo
from heavylift.nodes.plan.verbs import VERBS
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.environment import Vessel
from heavylift.nodes.scene.keys.parts.flexible import Hull
from heavylift.nodes.scene.keys.seas import Splash
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path

from .scene_builder import LOWER, UPPER, SceneBuilder, box

SAME = 1e-9  # relative, of masses that are equal
TOUCH = 1e-6  # [m]
SINGULAR = 1e-12  # singular value, relative, of supports in one line


def block_machine(builder: SceneBuilder, base: Path) -> plan.Mechanism:
    """Return a block as a machine: a body on a free joint above its supports.

    A block that is turned over can be set down on its other face. `base`: path of the block in the scene."""
    name, alone, where = str(base[-1]), len(base) == 1, builder.source.where(base)
    block = builder.scene.block if alone else builder.scene.blocks[name]
    assert block is not None
    turns = alone or any(
        VERBS[phrase.verb].becomes == "turn"
        for action in builder.scene.actions
        for target, phrase in action.orders.items()
        if target == name
    )
    supports, stools = dict[str, list[Support]](), block.supports
    n, half = len(stools.at), block.size[2] / 2
    k = block.mass * builder.scene.gravity / (n * stools.settlement)
    d = 2 * stools.damping * math.sqrt(k * block.mass / n)
    for face, side in ((LOWER, -1), (UPPER, 1)):
        for i, (u, v) in enumerate(stools.at):
            support = Support(
                f"{name}.{face}-{i + 1}", Point(name, (u, v, side * half)), stools.height, k, d, stools.friction,
                k if stools.friction else 0.0, d if stools.friction else 0.0, "" if block.on == WORLD else block.on,
            )  # fmt: skip
            supports.setdefault(face, []).append(support)
    xx, yy, zz, xy, xz, yz = (*(block.inertia or box(block.mass, block.size)), 0.0, 0.0, 0.0)[:6]
    rigid = Body(name, block.mass, block.com, ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
    try:
        check_inertia(Body(name, block.mass, inertia=rigid.inertia))
    except KernelError as error:
        builder.source.fault((*base, "inertia"), str(error))
    for sentence, path in _misfits(block, name):
        builder.source.fault((*base, *path), sentence, on_key=True)
    flexible = flexible_of(builder, block, rigid, [s for of in supports.values() for s in of], base)
    stands, pose = supports[LOWER], _resting(block, builder.scene.vessels.get(block.on))
    system = System(
        bodies=(block_body(rigid, flexible),),
        joints=(Joint(f"{name}.free", "free", WORLD, name, q0=pose, v0=(0.0,) * 6),),
        supports=tuple(stands + supports[UPPER] if turns else stands),
        forces=() if block.splash is None else (immersion(name, block, block.splash),),
        gravity=builder.scene.gravity,
    )
    words = {lug: lug if alone else f"{name}.{lug}" for lug in block.lugs}
    marks = {word: builder.source.where((*base, "lugs", lug)) for lug, word in words.items()}
    cargo = Cargo(
        body=name, mass=block.mass, com=block.com, moments=(xx, yy, zz), size=block.size,
        lugs={word: block.lugs[lug] for lug, word in words.items()},
        marks=marks | {"": builder.source.where((*base, "com"))},
        faces={s.name: face for face, of in supports.items() for s in of} if turns else {},
        turned=0.0 if turns else None,
        amplitude=tuple(block.splash.amplitude) if block.splash else (),
    )  # fmt: skip
    boxes = block.shape.slices if block.shape and block.shape.slices else [((0.0, 0.0, 0.0), block.size)]
    return plan.Mechanism(
        name=name,
        system=system,
        closed=tuple(s.name for s in stands),
        shapes=tuple(plan.Shape(body=name, centre=centre, size=size) for centre, size in boxes),
        cargo=(cargo,),
        where=where,
    )


def _misfits(given: schema.Block, name: str) -> Iterator[tuple[str, Path]]:
    """Yield (error, path) for a block that is not at the height of its supports, for supports beside the block or not
    around its centre of mass, and for lugs inside the block."""
    (u, v, _), half, supports = given.com, [side / 2 for side in given.size], given.supports.at
    gap, own = given.at[2] - half[2] - given.supports.height, name if name == "block" else f"block {name}"
    if abs(gap) > TOUCH:
        how = f"{gap:g} m above" if gap > 0 else f"{-gap:g} m deep in"
        yield f"the {own} is {how} its supports: put its middle at z = {given.supports.height + half[2]:g} m", ()
    if any(max(abs(place[i]) for place in supports) > half[i] for i in (0, 1)):
        yield "a support stands beside the block", ("supports", "at", 0)
    elif not _inside((u, v), supports):
        message = f"the centre of mass at u = {u:g} m, v = {v:g} m is not above the supports"
        yield f"{message}: the block would tip", ("supports", "at", 0)
    for lug, p in given.lugs.items() if given.shape is None else ():  # a shape has its faces within the box
        depths = [h - abs(x) for h, x in zip(half, p, strict=True)]
        if min(depths) > TOUCH:
            i = depths.index(min(depths))
            message = f"the lug {lug} is inside the block, {min(depths):g} m below its face at {'uvw'[i]}"
            yield f"{message} = {math.copysign(half[i], p[i]):g} m", ("lugs", lug)


def _inside(p: tuple[float, float], points: list[tuple[float, float]]) -> bool:
    """Return whether the point p is inside the convex hull of points."""
    if p in points:
        return True
    angles = sorted(float(atan2(y - p[1], x - p[0])) for x, y in points)
    gaps = [(b - a) for a, b in pairwise([*angles, angles[0] + 2 * math.pi])]
    return bool(max(gaps) <= math.pi + 1e-9)


def _resting(block: schema.Block, on: Vessel | None) -> tuple[float, float, float, float, float, float, float]:
    """Return the pose (position, quaternion x y z w) of a block in equilibrium on its supports: k sum(depth) = weight,
    where the depth at (u, v) is a + b u + c v."""
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


def immersion(name: str, block: schema.Block, given: Splash) -> Immersion:
    """Return the buoyancy force law of an upright block, applied at the block's centre of mass."""
    depths, forces = zip(*given.buoyancy, strict=True)
    below = 0.5 * block.size[2] + block.com[2]
    return Immersion(f"{name}.water", Point(name, block.com), below, given.level, depths, forces)


def flexible_of(
    builder: SceneBuilder, block: schema.Block, body: Body, stools: list[Support], base: Path
) -> Flexible | None:
    """Return the flexible part of a block; None if the block is rigid. Errors are added to the scene."""
    if block.beam is None and not block.modes:
        return None
    key: Path = (*base, "beam" if block.beam else "modes")
    if block.beam and block.modes:
        builder.source.fault((*base, "modes"), "a flexible block has either a 'beam' or 'modes'", on_key=True)
        return None
    made = _beam(builder, block, block.beam, body, key) if block.beam else _modes(builder, block, stools, base)
    if made is None:
        return None
    try:
        check_flexible(str(base[-1]), made)
        check_inertia(block_body(body, made))
    except KernelError as error:
        message = (
            "; give the beam a 'mass', that of what bends with it, or the block its 'inertia'" if made.beam else ""
        )
        builder.source.fault(key, f"{error}{message}", on_key=True)
    return made


def _beam(builder: SceneBuilder, block: schema.Block, hull: Hull, body: Body, key: Path) -> Flexible | None:
    length, bends = block.size[0], hull.mass or block.mass
    if bends > block.mass * (1.0 + SAME):
        message = f"the block has {block.mass / 1e3:g} t, of which no {bends / 1e3:g} t can bend"
        builder.source.fault((*key, "mass"), message)
        return None
    if any(block.com) and bends > block.mass * (1.0 - SAME):
        message = (
            "a uniform beam has its centre of mass on its axis, not at 'com': give the beam a 'mass' below the block's"
        )
        builder.source.fault(key, message, on_key=True)
        return None
    polar = body.inertia[0][0] / length * (bends / block.mass)
    beam = Beam(length, bends / length, *hull.stiffness, polar, hull.elements, start=-length / 2)
    along = {"end-1": -length / 2, "middle": 0.0, "end-2": length / 2}
    for lug, p in block.lugs.items():
        if abs(p[0]) > length / 2:
            message = f"the lug stands {p[0]:g} m along a beam that ends at {length / 2:g} m"
            builder.source.fault((*key[:-1], "lugs", lug), message)
    gauges = (*_gauges(block.lugs), *(Gauge(name, (x, 0.0, 0.0)) for name, x in along.items()))
    return Flexible(hull.modes, beam, frame="free", damping=hull.damping, loads=tuple(hull.loads), gauges=gauges)


def _modes(builder: SceneBuilder, block: schema.Block, stools: list[Support], base: Path) -> Flexible | None:
    places = {**block.lugs, **{s.name.partition(".")[2]: s.point.p for s in stools}}
    named = dict.fromkeys(word for mode in block.modes.values() for word in mode.shape)
    for name, mode in block.modes.items():
        for word in (word for word in mode.shape if word not in places):
            path = (*base, "modes", name, "shape", word)
            builder.source.fault(path, f"the block has no lug or support '{word}'", closest(word, places), on_key=True)
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
