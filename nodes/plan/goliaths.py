"""Goliaths, block loaders and blocks of a plan as machines made of parts, which is what models are built from.

A crane is a main body on rails with two trolleys on servos, from which its hook ropes hang; a loader a frame of two
bodies with a hinge that has stops, a damper and a brake, and its slings; a block a body above its stools.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import sqrt

import msgspec
from heavylift.kernel.description.forces import Reeving, Signal
from heavylift.kernel.description.mechanics import (
    WORLD,
    Body,
    Brake,
    Drive,
    Joint,
    JointSpring,
    Line,
    Point,
    Rope,
    Stop,
    System,
    Vector,
)

from .bending import block_body
from .mechanism import Actuator, Cargo, Cell, Girder, Heavy, Hoist, Latch, Mechanism, Shape, Tie
from .plan import ActionList, Axis, Block, Crane, Hook, HookRope, Inertia, Loader, Plan, Sling

LEG, GIRDER = 4.0, 8.0  # widths of a portal's legs and of its girder [m]
DECK = 2.0  # from the exits of the ropes to the girder, which lies between their two levels [m]
TROLLEY = 4.0  # height of a trolley [m]
THIN = 1.0  # edge of what has no other [m]
X: Vector = (1.0, 0.0, 0.0)
Y: Vector = (0.0, 1.0, 0.0)
REST6 = (0.0,) * 6


Known = tuple[Plan, tuple[Mechanism, ...]]
_last: list[Known] = []  # of the plan that was asked for last, which is asked for again and again


def machines(plan: Plan) -> tuple[Mechanism, ...]:
    """All machines of a plan as parts, in the order of their nodes."""
    known = next(iter(_last), None)
    if known is None or known[0] is not plan:
        known = plan, tuple(machine(plan, x) for x in plan.machines)
        _last[:] = [known]
    return known[1]


def machine(plan: Plan, given: Crane | Loader | Block | Mechanism) -> Mechanism:
    """A machine of a plan as parts."""
    match given:
        case Crane():
            return _crane(plan, given)
        case Loader():
            return _loader(plan, given)
        case Block():
            return _block(plan, given)
    return given


def of_lift(plan: Plan, lift: ActionList) -> Plan:
    """What the machines of one of several lifts need of a plan."""
    block = next((block for block in plan.blocks if block.name in lift.machines), None)
    return msgspec.structs.replace(plan, block=block, blocks=(), fidelity=lift.fidelity, start=lift.start)


def _body(name: str, inertia: Inertia) -> Body:
    return Body(name, inertia.mass, inertia.com, inertia.matrix)


def _crane(plan: Plan, crane: Crane) -> Mechanism:
    name, main = crane.name, f"{crane.name}.main"
    hooks = {rope.name: hook for rope in plan.rig.hook_ropes for hook in crane.hooks if hook.rope == rope.name}
    ropes = [rope for rope in plan.rig.hook_ropes if rope.name in hooks]
    axes = {f"{name}.gantry.drive": crane.gantry}
    axes |= {f"{name}.{t.name}-slide.drive": t.axis for t in (crane.upper, crane.lower)}
    slides = [_slide(f"{name}.gantry", WORLD, main, (*crane.at, 0.0), X, crane.gantry)]
    bodies, girders = [_body(main, crane.main)], [f"{name}.{t.name}-slide" for t in (crane.upper, crane.lower)]
    for trolley, slide in zip((crane.upper, crane.lower), girders, strict=True):
        bodies.append(_body(f"{name}.{trolley.name}", trolley.body))
        slides.append(_slide(slide, main, bodies[-1].name, (0.0, 0.0, 0.0), Y, trolley.axis))
    system = System(
        bodies=tuple(bodies),
        joints=tuple(joint for joint, _ in slides),
        drives=tuple(drive for _, drive in slides),
        ropes=tuple(Rope(r.name, r.lines, r.EA, r.L0, r.damping, winch=True) for r in ropes),
        gravity=plan.gravity,
    )
    actuators = [
        Actuator(
            name=drive, start=a.start, accel=a.accel, lower=a.lower, upper=a.upper, pulses=a.pulses,
            emergency=a.emergency,
        )
        for drive, a in axes.items()
    ]  # fmt: skip
    actuators += [
        Actuator(
            name=rope.name, start=rope.L0, accel=hook.accel, lower=hook.shortest, upper=hook.drum,
            highest=hook.highest, emergency=hook.emergency,
        )
        for rope in ropes
        for hook in (hooks[rope.name],)
    ]  # fmt: skip
    girder = Girder(
        body=main, slides=tuple(girders), mass=crane.girder.mass, stiffness=crane.girder.stiffness,
        span=crane.girder.span, height=crane.girder.height, damping=crane.girder.damping,
    )  # fmt: skip
    return Mechanism(
        name=name,
        system=system,
        actuators=tuple(actuators),
        taut=tuple(hooks),
        hooks=tuple(_hook(crane, hooks[rope.name], rope) for rope in ropes),
        heavy=tuple(_heavy(plan, crane, hooks[rope.name], rope) for rope in ropes),
        cells=tuple(_cells(plan, crane, [hook for hook in crane.hooks if hook.rope in hooks])),
        girders=(girder,),
        shapes=(*_portal(crane, ropes), *_trolleys(crane)),
        where=crane.where,
    )


def _portal(crane: Crane, ropes: Sequence[HookRope]) -> Iterator[Shape]:
    """Girder between the two levels of rope exits (about its axis if nothing hangs from it), two pairs of legs on the
    rails under cross beams, each on a sill as long as the portal is wide over its buffers."""
    exits, axis = [line.a.p[2] for r in ropes for line in r.lines], crane.girder.height
    low, high = (min(exits) + DECK, max(exits) - DECK) if exits else (axis - LEG, axis + LEG)
    span, half = 2.0 * crane.main.com[1], crane.width / 2 - LEG

    def box(part: str, centre: Vector, size: Vector) -> Shape:
        return Shape(body=f"{crane.name}.main", centre=centre, size=size, thing=f"portal of {crane.name}", part=part)

    yield box("girder", (0.0, span / 2, (low + high) / 2), (GIRDER, span + LEG, max(high - low, LEG)))
    for x in (-half, half):
        for y in (0.0, span):
            yield box("leg", (x, y, low / 2), (LEG, LEG, low))
    for y in (0.0, span):
        yield box("sill", (0.0, y, LEG / 4), (crane.width, LEG, LEG / 2))
        yield box("cross beam", (0.0, y, low + LEG / 2), (crane.width - LEG, LEG, LEG))


def _trolleys(crane: Crane) -> Iterator[Shape]:
    for trolley in (crane.upper, crane.lower):
        x, y, _ = edges(trolley.body.mass, trolley.body.moments)
        body, thing = f"{crane.name}.{trolley.name}", f"{trolley.name} trolley of {crane.name}"
        yield Shape(body=body, centre=trolley.body.com, size=(x, y, TROLLEY), thing=thing)


def _frame(plan: Plan, loader: Loader, slings: Sequence[Sling]) -> Iterator[Shape]:
    """Hook block from the eye down to the hinge, as wide as its ropes are apart; beam between its slings."""
    x, y, z = loader.hinge
    apart = [abs(line.b.p[0]) for r in plan.rig.hook_ropes if r.carries == loader.name for line in r.lines]
    wide = 2.0 * max(apart, default=THIN / 2) or THIN
    upper, lower, thing = f"{loader.name}.upper", f"{loader.name}.lower", loader.name
    size = (wide, min(wide, 2.0), max(-z, THIN))
    yield Shape(body=upper, centre=(x / 2, y / 2, z / 2), size=size, thing=thing, part="hook block")
    beams = [s.beam.p for s in slings] or [(0.0, 0.0, -THIN)]
    mid = [sum(p[i] for p in beams) / len(beams) for i in range(3)]
    size = (max(p[0] for p in beams) - min(p[0] for p in beams) + THIN, THIN, max(-mid[2], THIN))
    yield Shape(body=lower, centre=(mid[0], mid[1], mid[2] / 2), size=size, thing=thing, part="beam")


def edges(mass: float, moments: Vector) -> Vector:
    """Edges of the uniform box of a mass [kg] and moments of inertia about its middle [kg m2]."""
    total = sum(moments)
    x, y, z = (round(sqrt(max(0.0, 6.0 * (total - 2.0 * m) / mass)), 9) for m in moments)
    return x, y, z


def _slide(name: str, parent: str, child: str, at: Vector, axis: Vector, motion: Axis) -> tuple[Joint, Drive]:
    """A sliding joint with its servo."""
    joint = Joint(name, "prismatic", parent, child, at, axis=axis, q0=(motion.start,), v0=(0.0,))
    return joint, Drive(f"{name}.drive", name, "servo", motion.kp, motion.kv)


def _hook(crane: Crane, hook: Hook, rope: HookRope) -> Hoist:
    return Hoist(
        rope=rope.name,
        eye=rope.eye,
        block_mass=hook.block_mass,
        capacity=hook.capacity,
        on=f"{crane.name}.{hook.trolley}",
        line=rope.line,
        falls=rope.falls,
        drum_ends=rope.drum_ends,
        efficiency=rope.efficiency,
        breaking=rope.breaking,
        where=hook.where,
    )


def _heavy(plan: Plan, crane: Crane, hook: Hook, rope: HookRope) -> Heavy:
    """A hook rope with where it begins and ends at the start, and what hangs on it then."""
    loader = next(x for x in plan.loaders if x.name == rope.carries)
    trolley = crane.upper if hook.trolley == "upper" else crane.lower
    n, (dx, dy) = len(rope.lines), crane.at
    x, y, z = (sum(line.a.p[i] for line in rope.lines) / n for i in range(3))
    ex, ey, ez = (sum(line.b.p[i] for line in rope.lines) / n + loader.pose[i] for i in range(3))
    return Heavy(
        rope=rope.name,
        line=rope.line,
        beside=tuple((line.b.p[0], 0.0, 0.0) for line in rope.lines),
        ends=((x + crane.gantry.start + dx, y + trolley.axis.start + dy, z), (ex, ey, ez)),
        below=loader.upper.mass + loader.lower.mass,
        on=f"{crane.name}.{hook.trolley}",
    )


def _cells(plan: Plan, crane: Crane, hooks: list[Hook]) -> Iterator[Cell]:
    """Load cells of all hooks together, and of those of a trolley that has several; rated for the blocks, too."""
    groups = {"main": (crane.capacity, hooks)} if hooks else {}
    for trolley in (crane.upper, crane.lower):
        own = [hook for hook in hooks if hook.trolley == trolley.name]
        if len(own) > 1:
            groups[trolley.name] = (trolley.capacity, own)
    for of, (capacity, own) in groups.items():
        body, ropes = f"{crane.name}.{of}", tuple(hook.rope for hook in own)
        rated = (capacity + sum(hook.block_mass for hook in own)) * plan.gravity
        yield Cell(name=f"{body}.load", body=body, ropes=ropes, rated=rated)


def _loader(plan: Plan, loader: Loader) -> Mechanism:
    name, slings = loader.name, [sling for sling in plan.rig.slings if sling.loader == loader.name]
    upper, lower, hinge = f"{name}.upper", f"{name}.lower", f"{name}.hinge"
    hooked = any(sling.lug for sling in slings)
    lugs = {lug.name: lug.p for lug in plan.block.lugs} if plan.block else {}
    cargo = plan.block.name if plan.block else WORLD
    ropes, over = list[Rope](), list[Reeving]()
    for s in slings:
        lug = Point(cargo, lugs.get(s.lug, (0.0, 0.0, 0.0)))
        if s.over:
            over.append(Reeving(s.name, s.beam, s.over, lug, s.EA, Signal(s.L0), s.damping, bool(s.lug)))
        else:
            ropes.append(Rope(s.name, (Line(s.beam, lug),), s.EA, s.L0, s.damping, hooked=bool(s.lug)))
    free = Joint(f"{name}.free", "free", WORLD, upper, q0=loader.pose, v0=REST6)
    turn = Joint(hinge, "revolute", upper, lower, loader.hinge, axis=Y, q0=(0.0,), v0=(0.0,))
    stops = loader.stop_lower, loader.stop_upper, loader.stop_k, loader.stop_d
    brake = Brake(f"{hinge}.lock", hinge, loader.lock_moment, loader.lock_k, loader.lock_d, not hooked)
    system = System(
        bodies=(_body(upper, loader.upper), _body(lower, loader.lower)),
        joints=(free, turn),
        springs=(JointSpring(f"{hinge}.damper", hinge, d=loader.damping),),
        stops=(Stop(f"{hinge}.stop", hinge, *stops),),
        brakes=(brake,),
        ropes=tuple(ropes),
        forces=tuple(over),
        gravity=plan.gravity,
    )
    names = tuple(s.name for s in slings)
    cell = Cell(name=f"{name}.load", body=lower, ropes=names, rated=loader.capacity_N)
    return Mechanism(
        name=name,
        system=system,
        taut=tuple(s.name for s in slings if s.lug and s.taut),
        ties=tuple(Tie(rope=s.name, upper=s.beam, lug=s.lug, rated=s.rated, where=s.where) for s in slings),
        cells=(cell,) if names else (),
        latches=(Latch(brake=brake.name, ties=names),),
        shapes=tuple(_frame(plan, loader, slings)),
        where=loader.where,
    )


def _block(plan: Plan, block: Block) -> Mechanism:
    joint = Joint(f"{block.name}.free", "free", WORLD, block.name, q0=block.pose, v0=REST6)
    system = System(
        bodies=(block_body(block.name, block.body, block.flexible),),
        joints=(joint,),
        supports=tuple(pad.support for pad in block.pads),
        gravity=plan.gravity,
    )
    cargo = Cargo(
        body=block.name,
        com=block.body.com,
        lugs={lug.name: lug.p for lug in block.lugs},
        faces={pad.support.name: pad.face for pad in block.pads},
        turned=plan.start,
    )
    closed = tuple(pad.support.name for pad in block.pads if pad.closed)
    shapes = tuple(Shape(body=block.name, centre=centre, size=size) for centre, size in boxes_of(block))
    return Mechanism(name=block.name, system=system, closed=closed, cargo=(cargo,), shapes=shapes, where=block.where)


def boxes_of(block: Block) -> tuple[tuple[Vector, Vector], ...]:
    """Middles and edges [m]: the slices or the box of a scene, or that of mass and inertia."""
    own = (
        ((0.0, 0.0, 0.0), block.size)
        if any(block.size)
        else (block.body.com, edges(block.body.mass, block.body.moments))
    )
    return block.slices or (own,)
