"""Whether a scene fits: portals, trolleys, ropes, hooks, lugs, slings, the block on its stools.

Each check is one function that yields (subject, where, sentence); it sees the start or, of the followed
action list, the states before and after an action.  A subject is reported once per check.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from math import sqrt
from typing import TypeAlias

from heavylift.kernel.description.mechanics import Rope, Vector
from heavylift.nodes.limits.geometry import passes_through
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.mechanism import lug_places
from heavylift.nodes.plan.spellings import BEAMS
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.nodes.statics.goals import goal
from heavylift.nodes.statics.state import StaticState

from .findings import Findings, Violations

SAME_LEVEL = 5.0  # trolleys whose ropes leave closer together in height run into each other [m]
TOUCH = 1e-6  # [m]
REACHED = 6e-3  # [m] by which a sling may be too short: it stretches more than that
BESIDE = 0.05  # of its length, that a hook may hang beside the lug of a sling that is too short
Places: TypeAlias = Mapping[str, float]  # where drives stand [m]
SURFACE = 0.01  # so deep below a face a sling still lies on it, and a block on stools that yield [m]


def start_checks(scene: schema.Scene, built: plan.Plan) -> list[tuple[str, str]]:
    """What does not fit before anything moves; slings are judged where cranes and blocks stand well."""
    found = Findings()
    found.take("hooks", _under_hooks(scene, built))
    found.take("ropes", _ropes_overloaded(built))
    start = {a.name: a.start for machine in built.machines for a in machine.actuators}
    for check in _PLACES:
        found.take(check.__name__, check(scene, built, start, start))
    if not found.sentences:
        found.take("slings", _slings_reach(scene, built))
    return found.list()


def goal_checks(
    found: Findings, scene: schema.Scene, built: plan.Plan, before: StaticState, action: plan.Action
) -> None:
    """Where the moves of an action that have a known end must not lead to."""
    after = goal(built, action, before)
    for check in _PLACES:
        violations = check(scene, built, before.references, after.references)
        found.take(check.__name__, violations, action.stage, action.where)


def step_checks(scene: schema.Scene, built: plan.Plan, states: Sequence[StaticState]) -> list[tuple[str, str]]:
    """What does not fit on the way."""
    found = Findings()
    level = not scene.vessels and not scene.floor  # the ground is at z = 0
    for state in states if level else ():
        action = built.actions[state.action - 1] if state.action else None
        found.take(
            "ground", _clear(built, state, action.where if action else ""), state.stage, action.where if action else ""
        )
    return found.list()


# at the start


def _under_hooks(scene: schema.Scene, built: plan.Plan) -> Violations:
    """Some hook is above each block, where all are known."""
    hooks = [hook.ends for machine in built.machines for hook in machine.hooks]
    eyes = [ends[1] for ends in hooks if ends]
    for name, block in scene.all_blocks.items() if scene.cranes and len(eyes) == len(hooks) else ():
        (x, y, _), (a, b, _) = block.at, block.size
        if not any(abs(p[0] - x) <= a and abs(p[1] - y) <= b for p in eyes):
            message = f"the {_named(name)} at x = {x:g} m, y = {y:g} m lies under no hook"
            told = ", ".join(f"{p[0]:g} / {p[1]:g} m" for p in eyes)
            where = next(m.where for m in built.machines if m.name == name)
            yield (name, where, f"{message}: hooks hang at {told or 'no place, the rig has no ' + BEAMS}")


def _named(block: str) -> str:
    return block if block == "block" else f"block {block}"


def _ropes_overloaded(built: plan.Plan) -> Violations:
    """No hook rope begins with more than its rated tension, from what hangs on it alone."""
    for hook in (hook for machine in built.machines for hook in machine.hooks):
        tension = hook.below * built.gravity
        if hook.rated and tension > hook.rated:
            message = f"the rope {hook.rope} begins stretched with {tension / 1e3:.0f} kN"
            message += f", rated for {hook.rated / 1e3:.0f} kN"
            hangs = next(m.name for m in built.machines for body in m.system.bodies if body.name == hook.eye.body)
            yield hook.rope, hook.where, f"{message}: {hangs} and the hook block alone are too heavy for it"


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


def _slings_reach(scene: schema.Scene, built: plan.Plan) -> Violations:
    """Each sling that is hooked at the start reaches its lug, not overstretched and not through the block."""
    lugs = lug_places(built.machines)
    for machine in (machine for machine in built.machines if machine.levels and machine.ties):
        at, straight = kinematics.poses(machine.system), {rope.name: rope for rope in machine.system.ropes}
        for tie in (tie for tie in machine.ties if tie.lug and tie.rope in straight):
            lug, rope = lugs[tie.lug], straight[tie.rope]
            block = scene.all_blocks[lug.body]
            x, y, z = block.at  # as slack is counted: before the block sinks into its stools
            a, b, c = kinematics.place(tie.upper, at).tolist()
            place = (x + lug.p[0], y + lug.p[1], z + lug.p[2])
            message = reach(tie.rope, rope.L0, tie.lug, (a, b, c), place) or _overstretched(tie, rope, (a, b, c), place)
            if message:
                theirs = [(each.lug, lugs[each.lug].p) for each in machine.ties if each.lug and " beside " in message]
                places = ", ".join(f"{name} ({p[0]:g}, {p[1]:g}, {p[2]:g}) m" for name, p in theirs)
                yield machine.name, tie.where, f"{message}{f'; its lugs are {places}' if places else ''}"
                continue
            u, v, w = (max(0.0, side / 2 - SURFACE) for side in block.size)
            inside = passes_through((a - x, b - y, c - z), lug.p, (u, v, w))
            if inside > 0.0:
                message = f"{tie.rope} would go through {inside:.2g} m of the block on its straight way to the lug "
                yield tie.rope, tie.where, f"{message}{tie.lug}: put the lug on a face that the hook reaches"


def _overstretched(tie: plan.Tie, rope: Rope, beam: Vector, lug: Vector) -> str:
    """A sentence if a sling begins with more than its rated tension, else nothing."""
    gap = sqrt(sum((a - b) * (a - b) for a, b in zip(beam, lug, strict=True))) - rope.L0
    tension = rope.EA * gap / rope.L0
    if not tie.rated or tension <= tie.rated:
        return ""
    message = f"{tie.rope} begins stretched by {gap * 1e3:.3g} mm with {tension / 1e3:.0f} kN, rated for"
    return f"{message} {tie.rated / 1e3:.0f} kN: lower the hook or take a longer sling than {rope.L0:g} m"


# at the start and after each action


def _portals(scene: schema.Scene, built: plan.Plan, before: Places, after: Places) -> Violations:
    """Cranes on the same rails neither overlap nor pass through each other."""
    cranes = [machine for machine in built.machines if machine.name in scene.cranes]
    for one, two in combinations(cranes, 2):
        least = (scene.cranes[one.name].width + scene.cranes[two.name].width) / 2
        gantries = one.actuators[0].name, two.actuators[0].name
        gap, was = (places[gantries[1]] - places[gantries[0]] for places in (after, before))
        if abs(gap) < least - TOUCH or gap * was < 0:
            message = f"the portals of {one.name} and {two.name} overlap: {abs(gap):g} m from centre to centre"
            yield f"{one.name} {two.name}", two.where, f"{message}, but {least:g} m from buffer to buffer"


def _trolleys_meet(scene: schema.Scene, built: plan.Plan, before: Places, after: Places) -> Violations:
    """Trolleys of one level neither touch nor pass; on two levels the lower one passes beneath the upper."""
    for crane in (machine for machine in built.machines if machine.name in scene.cranes):
        given, (upper, lower) = scene.cranes[crane.name], crane.actuators[1:3]
        if abs(given.upper_exit - given.lower_exit) >= SAME_LEVEL:
            continue
        gap, was = (places[lower.name] - places[upper.name] for places in (after, before))
        if abs(gap) < given.trolley_length - TOUCH or gap * was < 0:
            message = f"the trolleys of {crane.name} run on one level and would go through each other"
            least = f"{given.trolley_length:g} m from middle to middle, not {abs(gap):g} m"
            yield crane.name, lower.where, f"{message}: they need {least}"


_PLACES = (_portals, _trolleys_meet)


def _clear(built: plan.Plan, state: StaticState, where: str) -> Violations:
    """No block sweeps through the ground while it hangs."""
    for block, cargo in ((machine, cargo) for machine in built.machines for cargo in machine.cargo):
        if any(state.supports.get(s.name, 0.0) > 0.0 for s in block.system.supports):
            continue
        p, R = state.poses[cargo.body]
        lowest = p[2] - sum(abs(R[2][i]) * side / 2 for i, side in enumerate(cargo.size))
        if lowest < -SURFACE:
            told = f"the {_named(cargo.body)} would sweep {-lowest:.2f} m into the ground: hoist it higher first"
            yield cargo.body, where, told
