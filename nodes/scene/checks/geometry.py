"""Whether a scene fits: portals, trolleys, ropes, hooks, lugs, slings, the block on its stools.

Each check is one function that yields (subject, where, sentence); it sees the start or, of the followed
action list, the states before and after an action.  A subject is reported once per check.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise
from math import copysign, pi, sqrt

from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description.mechanics import Vector
from heavylift.nodes.limits.geometry import passes_through
from heavylift.nodes.limits.sentences import past_the_end
from heavylift.nodes.plan import plan
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.statics.static_state import State, Step

from .findings import Findings, Violations

SAME_LEVEL = 5.0  # trolleys whose ropes leave closer together in height run into each other [m]
TOUCH = 1e-6  # [m]
REACHED = 6e-3  # [m] by which a sling may be too short: it stretches more than that
BESIDE = 0.05  # of its length, that a hook may hang beside the lug of a sling that is too short
SURFACE = 0.01  # so deep below a face a sling still lies on it, and a block on stools that yield [m]


def start_checks(scene: schema.Scene, built: plan.Plan) -> list[tuple[str, str]]:
    """What does not fit before anything moves; slings are judged where cranes and block stand well."""
    found = Findings()
    assert scene.block is not None
    assert built.block is not None
    found.take("ends", _beyond_ends(built))
    if found.sentences:  # what hangs on such a crane is elsewhere, too
        return found.list()
    for fits in (_on_stools, _stools_below_mass, _lugs_outside, _under_hooks):
        found.take(fits.__name__, fits(scene.block, built.block, built))
    found.take("ropes", _ropes_overloaded(built))
    start = _start(scene, built)
    for check in _PLACES:
        found.take(check.__name__, check(scene, built, start, start))
    if not found.sentences:
        found.take("slings", _slings_reach(scene.block, built.block, built))
    return found.list()


def goal_checks(
    found: Findings, scene: schema.Scene, built: plan.Plan, before: State, after: State, action: plan.Action
) -> None:
    """Where the moves of an action that have a known end must not lead to."""
    for check in _PLACES:
        found.take(check.__name__, check(scene, built, before, after), action.stage, action.where)


def step_checks(scene: schema.Scene, built: plan.Plan, steps: Sequence[Step]) -> list[tuple[str, str]]:
    """What does not fit on the way."""
    found = Findings()
    for step in steps:
        found.take("ground", _block_clear(scene, built, step), step.static.stage, step.where)
    return found.list()


def _start(scene: schema.Scene, built: plan.Plan) -> State:
    """Where everything is written to stand at the start."""
    assert scene.block is not None
    return State(
        cranes={c.name: c.gantry.start for c in built.cranes},
        trolleys={(c.name, t.name): t.axis.start for c in built.cranes for t in (c.upper, c.lower)},
        ropes={rope.name: rope.L0 for rope in built.rig.hook_ropes},
        lugs={sling.name: sling.lug for sling in built.rig.slings if sling.lug},
        at=scene.block.at,
        theta=0.0,
        grounded=True,
    )


# at the start


def _beyond_ends(built: plan.Plan) -> Violations:
    """Cranes stand on their rails, trolleys on their girder."""
    for crane in built.cranes:
        trolleys = ((f"{crane.name} {x.name}", x.axis, "y", "girder", x.where) for x in (crane.upper, crane.lower))
        for subject, axis, along, of, where in ((crane.name, crane.gantry, "x", "rails", crane.where), *trolleys):
            if not axis.lower - TOUCH <= axis.start <= axis.upper + TOUCH:
                yield subject, where, past_the_end(subject, along, axis.start, of, (axis.lower, axis.upper))


def _on_stools(given: schema.Block, block: plan.Block, built: plan.Plan) -> Violations:
    """The block stands on its stools: neither above nor sunk into them."""
    gap = given.at[2] - given.size[2] / 2 - given.supports.height
    if abs(gap) > TOUCH:
        how = f"{gap:g} m above" if gap > 0 else f"{-gap:g} m deep in"
        z = given.supports.height + given.size[2] / 2
        yield "block", block.where, f"the block is {how} its stools: put its middle at z = {z:g} m"


def _stools_below_mass(given: schema.Block, block: plan.Block, built: plan.Plan) -> Violations:
    """All stools bear: the centre of mass is inside them, and they are under the block."""
    u, v, _ = given.com
    rows = [(x, y) for x, y in given.supports.at]
    a, b = (max(abs(c[i]) for c in rows) for i in (0, 1))
    if a > given.size[0] / 2 or b > given.size[1] / 2:
        yield "stools", block.pads[0].where, "a stool stands beside the block"
    elif not _inside((u, v), rows):
        message = f"the centre of mass at u = {u:g} m, v = {v:g} m is not above the stools: the block would tip"
        yield "stools", block.pads[0].where, message


def _lugs_outside(given: schema.Block, block: plan.Block, built: plan.Plan) -> Violations:
    """No lug is inside the block."""
    half = tuple(side / 2 for side in given.size)
    for lug in block.lugs:
        depths = [h - abs(x) for h, x in zip(half, lug.p, strict=True)]
        if min(depths) > TOUCH:
            axis = "uvw"[depths.index(min(depths))]
            message = f"the lug {lug.name} is inside the block, {min(depths):g} m below its face at {axis}"
            yield (
                lug.name,
                lug.where,
                f"{message} = {copysign(half['uvw'.index(axis)], lug.p[depths.index(min(depths))]):g} m",
            )


def _under_hooks(given: schema.Block, block: plan.Block, built: plan.Plan) -> Violations:
    """Some hook is above the block."""
    x, y, _ = given.at
    a, b, _ = given.size
    over = [p for p in (loader.pose for loader in built.loaders) if abs(p[0] - x) <= a and abs(p[1] - y) <= b]
    if not over:
        message = f"the block at x = {x:g} m, y = {y:g} m lies under no hook"
        hooks = ", ".join(f"{loader.pose[0]:g} / {loader.pose[1]:g} m" for loader in built.loaders)
        yield ("block", block.where, f"{message}: hooks hang at {hooks or 'no place, the rig has no loaders'}")


def _ropes_overloaded(built: plan.Plan) -> Violations:
    """No hook rope begins with more than its rated tension, from what hangs on it alone."""
    loaders = {loader.name: loader for loader in built.loaders}
    for rope in built.rig.hook_ropes:
        loader = loaders[rope.carries]  # whose upper body holds the hook block
        tension = (loader.upper.mass + loader.lower.mass) * built.gravity
        if rope.rated and tension > rope.rated:
            message = f"the rope {rope.name} begins stretched with {tension / 1e3:.0f} kN"
            message += f", rated for {rope.rated / 1e3:.0f} kN"
            yield rope.name, rope.where, f"{message}: {loader.name} and the hook block alone are too heavy for it"


def reach(sling: str, length: float, lug: str, upper: Sequence[float], p: Sequence[float]) -> str:
    """A sentence if a sling is too short for its lug or hangs too far beside it, else nothing."""
    dx, dy, dz = (a - b for a, b in zip(upper, p, strict=True))
    gap, beside = sqrt(dx * dx + dy * dy + dz * dz) - length, sqrt(dx * dx + dy * dy)
    if gap <= REACHED:
        return ""
    if beside > BESIDE * length:
        message = f"the hook stands {beside:.1f} m beside the lug {lug}, too far for the {length:g} m of {sling}"
        return f"{message} ({gap * 1000:.0f} mm are missing): move crane or trolley first"
    message = f"{sling} is {gap * 1000:.0f} mm too short for the lug {lug}"
    return f"{message}: lower the hook or take a longer sling than {length:g} m"


def _slings_reach(given: schema.Block, block: plan.Block, built: plan.Plan) -> Violations:
    """Each sling that is hooked at the start reaches its lug, not overstretched and not through the block."""
    loaders, lugs = {x.name: x for x in built.loaders}, {lug.name: lug.p for lug in block.lugs}
    u, v, w = (max(0.0, side / 2 - SURFACE) for side in given.size)
    x, y, z = given.at  # as slack is counted: before the block sinks into its stools
    for sling in built.rig.slings:
        if not sling.lug or sling.over:
            continue
        eye, hinge, own, lug = loaders[sling.loader].pose, loaders[sling.loader].hinge, sling.beam.p, lugs[sling.lug]
        beam = (eye[0] + hinge[0] + own[0], eye[1] + hinge[1] + own[1], eye[2] + hinge[2] + own[2])
        place = (x + lug[0], y + lug[1], z + lug[2])
        message = reach(sling.name, sling.L0, sling.lug, beam, place) or _overstretched(sling, beam, place)
        if message:
            yield sling.loader, sling.where, message
            continue
        inside = passes_through(_from((x, y, z), beam), lug, (u, v, w))
        if inside > 0.0:
            message = (
                f"{sling.name} would go through {inside:.2g} m of the block on its straight way to the lug {sling.lug}"
            )
            yield sling.name, sling.where, f"{message}: put the lug on a face that the hook reaches"


def _from(origin: Vector, p: Vector) -> Vector:
    return (p[0] - origin[0], p[1] - origin[1], p[2] - origin[2])


def _overstretched(sling: plan.Sling, beam: Vector, lug: Vector) -> str:
    """A sentence if a sling begins with more than its rated tension, else nothing."""
    gap = sqrt(sum((a - b) * (a - b) for a, b in zip(beam, lug, strict=True))) - sling.L0
    tension = sling.EA * gap / sling.L0
    if not sling.rated or tension <= sling.rated:
        return ""
    message = f"{sling.name} begins stretched by {gap * 1e3:.3g} mm with {tension / 1e3:.0f} kN, rated for"
    return f"{message} {sling.rated / 1e3:.0f} kN: lower the hook or take a longer sling than {sling.L0:g} m"


# at the start and after each action


def _portals(scene: schema.Scene, built: plan.Plan, before: State, after: State) -> Violations:
    """Cranes on the same rails neither overlap nor pass through each other."""
    for one, two in combinations(built.cranes, 2):
        least = (scene.cranes[one.name].width + scene.cranes[two.name].width) / 2
        gap = after.cranes[two.name] - after.cranes[one.name]
        was = before.cranes[two.name] - before.cranes[one.name]
        if abs(gap) < least - TOUCH or gap * was < 0:
            message = f"the portals of {one.name} and {two.name} overlap: {abs(gap):g} m from centre to centre"
            yield f"{one.name} {two.name}", two.where, f"{message}, but {least:g} m from buffer to buffer"


def _trolleys_meet(scene: schema.Scene, built: plan.Plan, before: State, after: State) -> Violations:
    """Trolleys of one level neither touch nor pass; on two levels the lower one passes beneath the upper."""
    for crane in built.cranes:
        given = scene.cranes[crane.name]
        if abs(given.upper_exit - given.lower_exit) >= SAME_LEVEL:
            continue
        gap, was = (s.trolleys[crane.name, "lower"] - s.trolleys[crane.name, "upper"] for s in (after, before))
        if abs(gap) < given.trolley_length - TOUCH or gap * was < 0:
            message = f"the trolleys of {crane.name} run on one level and would go through each other"
            least = f"{given.trolley_length:g} m from middle to middle, not {abs(gap):g} m"
            yield crane.name, crane.lower.where, f"{message}: they need {least}"


_PLACES = (_portals, _trolleys_meet)


def _block_clear(scene: schema.Scene, built: plan.Plan, step: Step) -> Violations:
    """The block does not sweep through the ground while it hangs."""
    if scene.block is None or step.static.grounded:
        return
    assert built.block is not None
    p, R = step.static.poses[built.block.name]
    lowest = p[2] - sum(abs(R[2][i]) * side / 2 for i, side in enumerate(scene.block.size))
    if lowest < -SURFACE:
        yield "block", step.where, f"the block would sweep {-lowest:.2f} m into the ground: hoist it higher first"


def _inside(p: tuple[float, float], points: list[tuple[float, float]]) -> bool:
    """Whether p is inside the convex hull: no direction has all points on its one side."""
    if p in points:
        return True
    angles = sorted(atan2(y - p[1], x - p[0]) for x, y in points)
    gaps = [(b - a) for a, b in pairwise([*angles, angles[0] + 2 * pi])]
    return bool(max(gaps) <= pi + 1e-9)
