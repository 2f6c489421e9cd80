"""The hooks of a machine and the slings on them: hook blocks that hang vertically at rest at the start."""

from dataclasses import dataclass, field
from math import sqrt

from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.elementary import atan2, cos, sin
from heavylift.kernel.description import mechanics as k
from heavylift.kernel.description.forces import InputSignal, Reeving
from heavylift.nodes.limits.reeving import ROLLING, drum_ends, lead_factor
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.mechanism import Heavy, Tie
from heavylift.nodes.scene.construction.checking import Checking
from heavylift.nodes.scene.construction.scene_builder import box, ramp_of
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.nodes.scene.keys.parts.mechanics import HookKeys
from heavylift.nodes.scene.keys.parts.rigging import SlingKeys
from heavylift.nodes.scene.text.source import Path, SourceText

from .edges import along_edges
from .hook_ratings import rope_factor
from .tree import RiggingTree

TOUCH = 1e-9  # [m]
WIRE = 7.92 / 93.5e6  # kg/m of a wire rope over its EA [N], as portals have it: 44 mm 6x36, 890.6 mm2 and 105 GPa


@dataclass
class Hung:
    """The parts that hooks add to a machine: hook blocks with their joints, ropes, slings, winches."""

    bodies: list[k.Body] = field(default_factory=list)
    joints: list[k.Joint] = field(default_factory=list)
    ropes: list[k.Rope] = field(default_factory=list)
    reevings: list[Reeving] = field(default_factory=list)
    actuators: list[plan.Actuator] = field(default_factory=list)
    hooks: list[plan.Hoist] = field(default_factory=list)
    heavy: list[Heavy] = field(default_factory=list)
    shapes: list[plan.Shape] = field(default_factory=list)
    ties: list[Tie] = field(default_factory=list)


def hang(checks: Checking, whole: k.System, tree: RiggingTree | None, gravity: float) -> Hung:
    """Return the hook blocks, ropes and slings of a machine.

    `whole`: all other parts of the machine, and the machines around it."""
    at, found = kinematics.poses(whole), Hung()
    for name, hook in checks.given.hooks.items():
        path: Path = (*checks.base, "hooks", name)
        checks.known((*path, "on"), hook.on)
        if hook.drum:
            checks.known((*path, "drum", "body"), hook.drum.body)
        if hook.radius_from:
            checks.known((*path, "radius from"), hook.radius_from)
        if name in checks.bodies:
            checks.fault(path, f"the name '{name}' is given twice: a body has it, too", on_key=True)
        try:
            radius = bool(hook.chart)
        except ValueError as error:
            radius = True
            checks.fault((*path, "capacity charts"), str(error), on_key=True)
        if radius and not hook.radius_from:
            checks.fault(path, "a chart by radius needs 'radius from', the body that slews", on_key=True)
        if hook.over_edges and (hook.drum or hook.apart):
            message = "a hook rope over edges is one line: remove 'drum' and 'apart'"
            checks.fault((*path, "over edges"), message, on_key=True)
        check_drums(checks.source, path, hook)
        if hook.shortest >= hook.longest:
            checks.fault((*path, "longest"), "the longest rope must be longer than the shortest")
        if not checks.source.faults:
            _hang_one(checks, found, name, hook, tree, whole, at, gravity)
    return found


def check_drums(source: SourceText, path: Path, hook: HookKeys) -> None:
    """Add an error unless the falls of a hook can be divided equally among the rope ends on its drum."""
    if hook.drum_ends and hook.falls % hook.drum_ends:
        message = f"{hook.falls} falls cannot be shared by {hook.drum_ends} drum ends: give an even number of falls"
        source.fault((*path, "drum ends"), f"{message}, or 'drum ends: 1'", on_key=True)


def _hang_one(
    checks: Checking,
    found: Hung,
    name: str,
    hook: HookKeys,
    tree: RiggingTree | None,
    around: k.System,
    at: kinematics.Poses,
    gravity: float,
) -> None:
    path: Path = (*checks.base, "hooks", name)
    where = checks.source.where(path)
    tip = tuple(kinematics.place(k.Point(hook.on, hook.at), at).tolist())
    along = at[hook.on][1][:, 1]
    yaw = 0.5 * float(atan2(-float(along[0]), float(along[1])))
    length = _plumb(name, hook, tip, tree)
    rigging = tree.of_hook(name) if tree else {}
    if not checks.source.faults and length <= 0.0:
        message = f"with slings so long its hook block hangs {-length:.3g} m above where its rope begins"
        checks.fault(path, f"{message}: shorten them, or take a higher crane", on_key=True)
    if checks.source.faults:
        return
    pose = (tip[0], tip[1], tip[2] - length, 0.0, 0.0, float(sin(yaw)), float(cos(yaw)))
    size = (hook.height / 2, max(hook.apart, hook.height / 2), hook.height)
    middle = (0.0, 0.0, -hook.height / 2)
    x, y, z = box(hook.block, size)
    found.bodies.append(k.Body(name, hook.block, middle, ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))))
    found.joints.append(k.Joint(f"{name}.free", "free", k.WORLD, name, q0=pose, v0=(0.0,) * 6))
    found.shapes.append(plan.Shape(body=name, centre=middle, size=size))
    lines, away = _lines(name, hook), 0.0
    if hook.drum:
        drum = k.Point(hook.drum.body, hook.drum.at)
        lines.append(k.Line(k.Point(hook.on, hook.at), drum, 1.0 / hook.falls))
        away = norm((kinematics.place(drum, at) - tip).tolist()) / hook.falls
    EA = hook.falls * hook.fall_EA
    L0 = (length + away) / (1.0 + hook.block * gravity / EA)
    mass = hook.block + (tree.carried(name) if tree else 0.0)
    damping = 2.0 * hook.damping * sqrt(EA / L0 * mass)
    if hook.over_edges:
        both, coms = (k.Point(hook.on, hook.at), k.Point(name)), {body.name: body.com for body in around.bodies}
        edges = along_edges(checks.source, path, hook.over_edges, checks.edges, both, coms, lambda: at)
        found.reevings.append(Reeving(name, both[0], edges, both[1], EA, InputSignal(L0, driven=True), damping))
    else:
        found.ropes.append(k.Rope(name, tuple(lines), EA, L0, damping, winch=True))
    for why, bad in (("shorter", length < hook.shortest - TOUCH), ("longer", length > hook.longest + TOUCH)):
        if bad:
            ends = f"{hook.shortest:g} to {hook.longest:g} m"
            checks.fault(
                path, f"its rope would be {why} than can be at the start: {length:.4g} m, of {ends}", on_key=True
            )
    found.actuators.append(winch_of(name, hook, L0, away, min(hook.shortest + away, L0), where))
    for key, given in rigging.items():
        _slings(found, key, given, name, hook, tree)
    other = ((0.0, 0.0, 0.0),) * (2 if hook.apart else 1)
    found.heavy.append(Heavy(rope=name, line=mass_of(hook), on=hook.on, beside=other))
    found.hooks.append(hoist_of(name, hook, k.Point(name), L0, gravity, where))


def winch_of(name: str, hook: HookKeys, L0: float, away: float, lower: float, where: str) -> plan.Actuator:
    """Return the winch of a hook.

    `L0`: length of the hook rope at the start [m]; `away`: part of this length that runs to the drum [m]."""
    return plan.Actuator(
        name=name, start=L0, accel=ramp_of(hook.ramp)[0], lower=lower, upper=hook.longest + away, verb="hoist",
        speed=hook.speed, loaded=hook.loaded_speed, highest=hook.highest, emergency=hook.emergency, where=where,
    )  # fmt: skip


def hoist_of(name: str, hook: HookKeys, eye: k.Point, L0: float, gravity: float, where: str) -> plan.Hoist:
    """Return the hook of the plan for the keys of a machine type.

    `eye`: point where the rope holds the hook block; `L0`: length of the rope at the start [m]."""
    ends, efficiency = drum_ends(hook.falls, hook.drum_ends), hook.sheave_efficiency or ROLLING
    breaking, line = hook.fall_breaking or 0.0, mass_of(hook)
    most = breaking / rope_factor(hook)[0] - line / hook.falls * gravity * L0  # of its most loaded part
    return plan.Hoist(
        rope=name, eye=eye, block_mass=hook.block, capacity=hook.capacity or 0.0,
        axis=k.Point(hook.radius_from) if hook.radius_from else None, chart=tuple(hook.chart or ()), on=hook.on,
        falls=hook.falls, drum_ends=ends, efficiency=efficiency, breaking=breaking, line=line,
        rated=max(hook.falls * most / lead_factor(hook.falls, ends, efficiency), 0.0), where=where,
    )  # fmt: skip


def mass_of(hook: HookKeys) -> float:
    """Return the mass per length [kg/m] of all falls of a hook rope together, for model levels with heavy ropes."""
    return hook.falls * (hook.fall_mass or WIRE * hook.fall_EA)


def _lines(name: str, hook: HookKeys) -> list[k.Line]:
    """Return the falls as one line, or as two lines at a distance from each other."""
    sides = (-hook.apart / 2, hook.apart / 2) if hook.apart else (0.0,)
    x, y, z = hook.at
    return [
        k.Line(k.Point(hook.on, (x, y + d, z)), k.Point(name, (0.0, d, 0.0)), 1.0 / len(sides)) for d in sides
    ]  # fmt: skip


def _plumb(name: str, hook: HookKeys, tip: tuple[float, ...], tree: RiggingTree | None) -> float:
    """Return how far a hook hangs below the tip at the start [m]: as given, else as its slings require, else as high as
    possible."""
    asked = tree.height(name, lambda _: [tip[0], tip[1], 0.0]) if tree else None
    if hook.hangs is not None or asked is None:
        low = hook.shortest if hook.highest is None else tip[2] - hook.highest
        return hook.hangs or max(hook.shortest, low)
    return tip[2] - asked - hook.height


def _slings(found: Hung, key: str, given: SlingKeys, name: str, hook: HookKeys, tree: RiggingTree | None) -> None:
    """Add the slings of a rigging entry that lead from the hook to lugs of blocks."""
    assert tree is not None
    found.ties += tree.ties(key)
    for sling, (i, lug, hooked) in tree.ropes(key).items():
        EA, length = given.sling.EA, given.lengths[i]
        eye = k.Point(name, (0.0, 0.0, -hook.height))
        damping = 2.0 * given.sling.damping * sqrt(EA / length * hook.block)
        if hooked and given.over_edges:
            found.reevings.append(Reeving(sling, eye, tree.edges(key, i), lug, EA, InputSignal(length), damping))
        else:
            found.ropes.append(k.Rope(sling, (k.Line(eye, lug),), EA, length, damping, hooked=hooked))
