"""Frames that `rig` hangs on the hooks of machines: hook rope, frame by its type, slings.

At the start each frame is at rest below its hook's position on its stretched rope; its slings have the given `slack`
and are straight or bend over edges.
"""

import math
from dataclasses import replace

import msgspec
import numpy as np
from heavylift.kernel.algebra.dense import norm, product
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.forces import InputSignal, Reeving, Sheave
from heavylift.kernel.description.mechanics import WORLD, Line, Point, Rope, System, Vector, merge
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.mechanism import BrakeLatch, Cell, Heavy
from heavylift.nodes.scene.construction.rigging.edges import key_of, lugs_of, rated
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.nodes.scene.keys.parts.joints import ABOVE, Free
from heavylift.nodes.scene.keys.parts.machines import FrameParts, MachineKeys
from heavylift.nodes.scene.keys.parts.mechanics import HookKeys
from heavylift.nodes.scene.text.faults import closest, raise_faults
from heavylift.nodes.scene.text.source import Path
from heavylift.recordings.format.spellings import BEAMS

from .mechanism import build_mechanism
from .rigging.edges import SPREAD, along_edges, height_of
from .rigging.hooks import check_drums, hoist_of, winch_of
from .scene_builder import SceneBuilder, by_beam

Edges = tuple[Sheave, ...]


def on_hook(
    builder: SceneBuilder, rig: schema.RigKeys, name: str, given: schema.FrameKeys, crane: plan.Mechanism
) -> tuple[plan.Mechanism, plan.Mechanism]:
    """Build a frame that hangs on a hook; return the rope and hook to add to the crane, and the frame as a machine.

    `crane`: the crane without these parts."""
    path: Path = ("rig", BEAMS, name)
    called, known = ".".join(builder.hooks[name]), lugs_of(builder.scene)
    lugs = by_beam([x for x in given.lugs or () if x in known], {lug: p.p[0] for lug, p in known.items()})
    held = builder.scene.all_blocks[known[lugs[0]].body] if lugs else None
    deck = builder.scene.vessels.get(held.on) if held else None
    yaw = deck.heading if deck else 0.0
    hook = builder.scene.machines[crane.name].hooks[called]
    check_drums(builder.source, ("machines", crane.name, "hooks", called), hook)
    frame = _frame(builder, name, given.parts, hook.block, yaw)
    raise_faults(builder.source, builder.source.faults)
    system, at = frame.system, kinematics.poses(frame.system)
    start = kinematics.poses(merge([*(vessel.system for vessel in builder.vessels), crane.system], 0.0))
    x, y, top = kinematics.place(Point(hook.on, hook.at), start).tolist()
    if hook.over_edges:
        message = f"the rope of {called} bends over edges: hang `rigging` on it, no frame"
        builder.source.fault((*path, "hook"), message)
    drum = Point(hook.drum.body, hook.drum.at) if hook.drum else None
    away = norm((kinematics.place(drum, start) - (x, y, top)).tolist()) / hook.falls if drum else 0.0
    mass = sum(body.mass for body in system.bodies)
    ends = [Point(end.body, end.at) for end in given.parts.slings]
    if given.lugs and len(given.lugs) != len(ends):
        builder.source.fault((*path, "lugs"), f"{len(ends)} slings hang on it: name a lug for each of them")
    strain = mass * builder.scene.gravity / (hook.falls * hook.fall_EA)
    if given.rope is not None:
        hangs = given.rope * (1 + strain)
    elif held:
        lug_z = held.at[2] + (deck.at[2] if deck else 0.0) + sum(known[lug].p[2] for lug in lugs) / len(lugs)
        height = -sum(float(kinematics.place(end, at)[2]) for end in ends) / len(ends)
        hangs = top - (lug_z + given.sling + height - rig.slack)
    else:
        hangs = top - hook.highest if hook.highest is not None else hook.shortest
    if hangs <= 0.0:
        excess = f"{-hangs:.2f} m too long for the height of the crane above the block"
        builder.source.fault(path, f"its slings are at least {excess}", on_key=True)
        raise_faults(builder.source, builder.source.faults)
    over: list[Edges] = [()] * len(ends)
    if given.over_edges:
        over, hangs = _over(builder, rig, name, given, at, [known[lug] for lug in lugs], (x, y, top), hangs)
    pose = (x, y, top - hangs, *_turned(yaw))
    ahead = product(start[hook.on][1].T.tolist(), [float(cos(yaw)), float(sin(yaw)), 0.0])
    rope = _rope(builder, called, hook, given, mass, (hangs + away) / (1 + strain), ahead)
    where = builder.source.where((*path, "hook"))
    winch = winch_of(rope.name, hook, rope.L0, away, hook.shortest + away, "")
    hoist = hoist_of(rope.name, hook, Point(given.parts.eye.body), rope.L0, builder.scene.gravity, where)
    falls = (x, y, top), pose[:3]
    afloat = any(joint.parent in builder.scene.vessels for joint in crane.system.joints)  # whose rest is to be found
    hoist = msgspec.structs.replace(hoist, ends=None if afloat else falls, below=mass)
    heavy = Heavy(
        rope=rope.name, line=hoist.line, beside=tuple((span.b.p[0], 0.0, 0.0) for span in rope.lines[:2]),
        ends=falls, below=0.0 if afloat else mass, on=hook.on, lead=away,
    )  # fmt: skip
    free = replace(system.joints[0], q0=pose)
    frame = msgspec.structs.replace(frame, system=replace(system, joints=(free, *system.joints[1:])))
    hung = plan.Mechanism(
        name=crane.name, system=System(ropes=(rope,)), actuators=(winch,), taut=(called,), hooks=(hoist,),
        heavy=(heavy,),
    )  # fmt: skip
    return hung, _slung(builder, rig, name, given, frame, lugs, over)


def _turned(yaw: float) -> tuple[float, float, float, float]:
    """Return the quaternion of a rotation by `yaw` [rad] about the vertical."""
    return 0.0, 0.0, float(sin(0.5 * yaw)), float(cos(0.5 * yaw))


def _frame(builder: SceneBuilder, name: str, parts: FrameParts, block: float, yaw: float) -> plan.Mechanism:
    """Return the bodies and joints of a frame together with the hook block; the origin is its suspension point, `yaw`
    [rad] its heading."""
    base, eye = ("rig", BEAMS, name, "parts"), parts.eye.body
    ends: dict[Path, str] = {("slings", i): end.body for i, end in enumerate(parts.slings)}
    for key, body in ({("eye",): eye} | ends).items():
        if body not in parts.bodies:
            builder.source.fault((*base, *key, "body"), f"there is no body '{body}'", closest(body, parts.bodies))
    raise_faults(builder.source, builder.source.faults)
    own = parts.bodies[eye]
    bodies, below = {eye: own.model_copy(update={"mass": (own.mass or 0.0) + block})}, [eye]
    for body in below:  # from the eye down
        below += [x.child for x in parts.joints.values() if x.parent == body and x.child not in below]
    bodies |= {body: parts.bodies[body] for body in (*below, *parts.bodies) if body in parts.bodies and body != eye}
    still = (0.0, 0.0, 0.0)
    free = Free.model_construct(
        type="free", child=eye, position=still, attitude=_turned(yaw), velocity=still, rate=still
    )
    hung = parts.model_copy(update={"bodies": bodies, "joints": {f"{name}.free": free, **parts.joints}})
    made = build_mechanism(builder.source, hung, builder.scene.gravity, base=base)
    raise_faults(builder.source, builder.source.faults)
    shapes = tuple(msgspec.structs.replace(shape, thing=name) for shape in made.shapes)
    return msgspec.structs.replace(made, name=name, shapes=shapes)


def _slung(
    builder: SceneBuilder, rig: schema.RigKeys, name: str, given: schema.FrameKeys, frame: plan.Mechanism,
    lugs: list[str],
    over: list[Edges],
) -> plan.Mechanism:  # fmt: skip
    """Return a frame with its slings; brakes that lock an empty frame are engaged if no sling is hooked."""
    known, path, EA = lugs_of(builder.scene), ("rig", BEAMS, name), rig.sling.EA
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
            ropes.append(Rope(sling, (Line(upper, to),), EA, given.sling, damping, hooked=bool(lug)))
        most, where = rated(rig.sling, builder.scene.gravity), builder.source.where((*path, "sling"))
        ties.append(plan.Tie(rope=sling, upper=upper, lug=key_of(lug, to) if lug else "", rated=most, where=where))
    names, locks = tuple(tie.rope for tie in ties), {f"{name}.{x}" for x in given.parts.locked_while_empty}
    brakes = tuple(replace(x, engaged=not lugs) if x.name in locks else x for x in frame.system.brakes)
    if unknown := locks - {brake.name for brake in brakes}:
        there = f"there is no brake '{min(unknown).removeprefix(f'{name}.')}'"
        builder.source.fault((*path, "parts", "locked while empty"), there, on_key=True)
    own, load = replace(frame.system, brakes=brakes), given.capacity * builder.scene.gravity
    return msgspec.structs.replace(
        frame,
        system=merge([own, System(ropes=tuple(ropes), forces=tuple(bent))], builder.scene.gravity),
        ties=tuple(ties),
        cells=(Cell(name=f"{name}.load", body=ties[0].upper.body, ropes=names, rated=load),),
        latches=tuple(BrakeLatch(brake=brake.name, ties=names) for brake in brakes if brake.name in locks),
        where=builder.source.where(path),
    )


def _over(
    builder: SceneBuilder, rig: schema.RigKeys, name: str, given: schema.FrameKeys, own: kinematics.Poses,
    lugs: list[Point], exit_: Vector, hangs: float,
) -> tuple[list[Edges], float]:  # fmt: skip
    """Return the edges over which each sling bends, and how far the beam hangs below the upper end of its rope [m],
    starting from the guess `hangs`. `own`: poses of the frame's bodies relative to its eye."""
    path = ("rig", BEAMS, name)
    if len(lugs) < len(given.parts.slings):
        builder.source.fault(
            (*path, "over edges"), "slings can bend over edges only if they hang on 'lugs' from the start"
        )
        return [()] * len(given.parts.slings), hangs
    ends = [(Point(end.body, end.at), lug) for end, lug in zip(given.parts.slings, lugs, strict=True)]
    x, y, top = exit_
    R, blocks, eye = np.eye(3), builder.scene.all_blocks, np.array([x, y, top - hangs])
    at = {WORLD: (np.zeros(3), R)} | {body: (eye + p, Q) for body, (p, Q) in own.items() if body != WORLD}
    puts = {block: builder.scene.put(block) for block in blocks}
    at |= {block: (np.array(p), np.array(axes)) for block, (p, axes) in puts.items()}
    coms = {block: given.com for block, given in blocks.items()}
    over = [
        along_edges(builder.source, path, given.over_edges, builder.scene.edges, pair, coms, lambda: at)
        for pair in ends
    ]
    if len({edge.at.body for edge in over[0]}) > 1:
        message = "the block turns freely, so its slings bend over edges of one body only"
        builder.source.fault((*path, "over edges"), message)
    if builder.source.faults or given.rope is not None:
        return over, hangs

    def height(i: int) -> float:
        (dx, dy, dz), lug = kinematics.place(ends[i][0], own).tolist(), ends[i][1]

        def rope(z: float) -> Reeving:
            upper = Point(WORLD, (x + dx, y + dy, z + dz))
            return Reeving(f"{name}.sling-{i + 1}", upper, over[i], lug, rig.sling.EA, InputSignal(given.sling))

        low = float(at[lug.body][0][2]) + lug.p[2] - dz + SPREAD
        return height_of(rope, low, given.sling, rig.slack, at, "over its edges")

    try:
        return over, top - min(map(height, range(len(ends))))
    except ValueError as error:
        builder.source.fault((*path, "sling"), str(error))
        return over, hangs


def _rope(
    builder: SceneBuilder, name: str, hook: HookKeys, given: schema.FrameKeys, carried: float, L0: float,
    ahead: list[float],
) -> Rope:  # fmt: skip
    """Return the rope of a hook: its falls as two parallel lines, separated along the direction `ahead`, and the line
    to its drum, if any."""
    half, eye, blocks = given.parts.eye.apart / 2, given.parts.eye.body, builder.scene.all_blocks
    lines = []
    for d in (-half, half):
        x, y, z = (p + d * along for p, along in zip(hook.at, ahead, strict=True))
        lines.append(Line(Point(hook.on, (x, y, z)), Point(eye, (d, 0.0, 0.0)), 0.5))
    if hook.drum:
        lines.append(Line(Point(hook.on, hook.at), Point(hook.drum.body, hook.drum.at), 1.0 / hook.falls))
    carried += sum(block.mass for block in blocks.values()) / len(builder.hooks)
    EA = hook.falls * hook.fall_EA
    damping = 2 * hook.damping * math.sqrt(EA / max(L0, 1e-3) * carried)
    return Rope(name, tuple(lines), EA, L0, damping, winch=True)


def placed(builder: SceneBuilder, name: str, given: MachineKeys) -> MachineKeys:
    """Return a machine's keys; a joint start `above its lugs` becomes the coordinate above the lugs of the load."""

    def start(joint: str) -> dict[str, float]:
        above = getattr(given.joints[joint], "start", 0.0) == ABOVE
        return {"start": _above(builder, name, given, joint)} if above else {}

    joints = {joint: x.model_copy(update=start(joint)) for joint, x in given.joints.items()}
    return given.model_copy(update={"joints": joints})


def _above(builder: SceneBuilder, name: str, given: MachineKeys, joint: str) -> float:
    """Return the world coordinate y [m] at which the child of a joint is above the mean of its frames' lugs; without
    lugs, the middle of its range."""
    rig, known, child = builder.scene.rig, lugs_of(builder.scene), given.joints[joint].child
    hung = [
        frame for frame, (of, hook) in builder.hooks.items() if of == name and given.hooks[f"{of}.{hook}"].on == child
    ]
    lugs = [known[lug] for frame in hung if rig for lug in rig.beams[frame].lugs or () if lug in known]
    if not lugs:
        return sum(next((x.range for x in given.drives.values() if x.joint == joint and x.range), (0.0, 0.0))) / 2
    blocks = builder.scene.all_blocks
    y = blocks[lugs[0].body].at[1]
    return y + sum(lug.p[1] + (blocks[lug.body].at[1] - y) for lug in lugs) / len(lugs)
