"""Geometric checks of a scene: portals, trolleys, ropes, hooks, lugs, slings, the block on its supports; and static
overloads.

Each check is a function that yields (subject, place in the scene, sentence); it gets the state at the start or, along
the action list, the states before and after an action. A subject is reported once for each check; if several subjects
have the same error at one place, the first is reported in full and the others are named.

Positions are checked only at the end of moves. A winch or drive that stops by itself at its end position is reported,
but the scene is not refused. The same holds for overloads after a sling has broken and for quantities that an interlock
guards: such scenes are run to study these cases.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product
from math import inf, sqrt
from typing import TypeAlias

import msgspec
import numpy as np
from heavylift.kernel.algebra import dense
from heavylift.kernel.constraints.contact.pairs import gap
from heavylift.kernel.description.contacts import Box, Contact
from heavylift.kernel.description.mechanics import WORLD, Joint, Point, Rope, Vector, merge
from heavylift.nodes.limits.geometry import passes_through
from heavylift.nodes.limits.judging import uses_on_path
from heavylift.nodes.limits.messages import REFUSED, sentence
from heavylift.nodes.limits.standards import FERRULE
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import parts
from heavylift.nodes.plan.connections import lug_places
from heavylift.nodes.plan.limit import Use
from heavylift.nodes.plan.shapes import Shapes
from heavylift.nodes.scene.keys import schema
from heavylift.nodes.scene.keys.parts import kinematics
from heavylift.nodes.statics import Followed, goal_states
from heavylift.nodes.statics.aiming import goal
from heavylift.nodes.statics.state import StaticState
from heavylift.recordings.format.spellings import BEAMS

Violations: TypeAlias = Iterator[tuple[str, str, str]]


@dataclass
class Findings:
    """Collects the errors that checks find in the states of a scene, in the order of occurrence."""

    seen: set[tuple[str, str]] = field(default_factory=set)
    sentences: dict[tuple[str, str, str], str] = field(default_factory=dict)
    others: dict[tuple[str, str, str], list[str]] = field(default_factory=dict)

    def take(self, check: str, violations: Violations, stage: str = "", where: str = "") -> None:
        """Add the errors found by a check to the collected errors.

        `where`: line of the action that causes the errors, reported instead of the place of the subject."""
        for subject, place, message in violations:
            if (check, subject) in self.seen:
                continue
            self.seen.add((check, subject))
            key = (check, where or place, stage)
            if where and key in self.sentences:
                self.others.setdefault(key, []).append(subject)
            else:
                self.sentences.setdefault(key, message)

    def list(self) -> list[tuple[str, str]]:
        """Return (place in the scene, sentence) of each collected error."""
        found = []
        for key, message in self.sentences.items():
            _, where, stage = key
            likewise = f"; likewise {', '.join(self.others[key])}" if key in self.others else ""
            found.append((where, message + likewise + (f" ({stage})" if stage else "")))
        return found


X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
TOUCH = 1e-6  # [m]
REACHED = 6e-3  # [m] by which a sling may be too short: it stretches more than that
BESIDE = 0.05  # of its length, that a hook may hang beside the lug of a sling that is too short
Places: TypeAlias = Mapping[str, float]  # where drives stand [m]
SURFACE = 0.01  # so deep below a face a sling still lies on it, and a block on supports that yield [m]


def start_checks(scene: schema.Scene, built: plan.Plan) -> list[tuple[str, str]]:
    """Return the errors in the state at the start, as (place in the scene, sentence). Slings are checked only if cranes
    and blocks are placed correctly."""
    found = Findings()
    found.take("hooks", _under_hooks(scene, built))
    found.take("ropes", _ropes_overloaded(built))
    found.take("obstacles", _inside_obstacles(scene, built))
    start = {a.name: a.start for machine in built.machines for a in machine.actuators}
    found.take("meet", _meet(built, start, start))
    if not found.sentences:
        found.take("slings", _slings_reach(scene, built))
    return found.list()


def goal_checks(found: Findings, built: plan.Plan, before: StaticState, action: plan.Action) -> None:
    """Check for penetration where the moves of an action end, and add the errors found."""
    after = goal(built, action, before)
    found.take("meet", _meet(built, before.references, after.references), action.stage, action.where)


def step_checks(scene: schema.Scene, built: plan.Plan, states: Sequence[StaticState]) -> list[tuple[str, str]]:
    """Return the errors in the states along the equilibrium path, as (place in the scene, sentence)."""
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
    """Yield an error for each block without a hook above it, if the positions of all hooks are known."""
    hooks = [hook.ends for machine in built.machines for hook in machine.hooks]
    eyes = [ends[1] for ends in hooks if ends]
    for name, block in scene.all_blocks.items() if scene.rig and len(eyes) == len(hooks) else ():
        (x, y, _), (a, b, _) = scene.put(name)[0], block.size
        if not any(abs(p[0] - x) <= a and abs(p[1] - y) <= b for p in eyes):
            message = f"the {named(name)} at x = {x:g} m, y = {y:g} m lies under no hook"
            places = ", ".join(f"{p[0]:g} / {p[1]:g} m" for p in eyes)
            where = next(m.where for m in built.machines if m.name == name)
            yield (name, where, f"{message}: hooks hang at {places or 'no place, the rig has no ' + BEAMS}")


def named(block: str) -> str:
    """Return the name under which messages refer to a block."""
    return block if block == "block" else f"block {block}"


def _ropes_overloaded(built: plan.Plan) -> Violations:
    """Yield an error for each hook rope whose tension at the start exceeds its rated tension."""
    for hook in (hook for machine in built.machines for hook in machine.hooks):
        tension = hook.below * built.gravity
        if hook.rated and tension > hook.rated:
            message = f"the rope {hook.rope} begins stretched with {tension / 1e3:.0f} kN"
            message += f", rated for {hook.rated / 1e3:.0f} kN"
            hangs = next(m.name for m in built.machines for body in m.system.bodies if body.name == hook.eye.body)
            yield hook.rope, hook.where, f"{message}: {hangs} and the hook block alone are too heavy for it"


def _inside_obstacles(scene: schema.Scene, built: plan.Plan) -> Violations:
    """Yield an error for each part of a machine that begins inside an obstacle which it may not touch."""
    if not scene.obstacles or scene.lifts:
        return
    shapes = Shapes(built)
    touches = [*built.may_touch, *(x for action in built.actions[:1] for x in action.may_touch)]
    at = kinematics.poses(merge([x.system for x in built.machines], built.gravity))
    places = {x: kinematics.place(Point(x.body, x.centre), at) for x in shapes.solids}
    radii = {x: 0.5 * dense.norm(x.size) for x in places}  # of the balls around all
    for a, b in product(places, (x for x in places if x.body in scene.obstacles)):
        near = dense.norm((places[a] - places[b]).tolist()) < radii[a] + radii[b]
        if not near or a.body in scene.all_blocks or a.form != "box" or shapes.relation(a, b) != "apart":
            continue
        if any(len({*x.names} & shapes.called(a)) and len({*x.names} & shapes.called(b)) for x in touches):
            continue
        one, other = Box(a.body, a.size, a.centre, a.R), Box(b.body, b.size, b.centre, b.R)
        depth = -gap(Contact("start", one, other), at[a.body], at[b.body])
        if depth > SURFACE + shapes.overlap(a, b):
            where = next(m.where for m in built.machines if m.name == a.machine)
            yield a.body, where, f"{a.thing} begins {depth:.2f} m inside of '{b.thing}': move one of them"


def reach(sling: str, length: float, lug: str, upper: Sequence[float], p: Sequence[float]) -> str:
    """Return an error message if a sling does not reach its lug; "" if it does."""
    dx, dy, dz = (a - b for a, b in zip(upper, p, strict=True))
    gap, other = sqrt(dx * dx + dy * dy + dz * dz) - length, sqrt(dx * dx + dy * dy)
    if gap <= REACHED:
        return ""
    if other > BESIDE * length:
        message = f"the hook stands {other:.1f} m beside the lug {lug}, too far for the {length:g} m of {sling}"
        return f"{message} ({gap * 1000:.0f} mm are missing): move crane or trolley first"
    message = f"{sling} is {gap * 1000:.0f} mm too short for the lug {lug}"
    return f"{message}: lower the hook or take a longer sling than {length:g} m"


def _slings_reach(scene: schema.Scene, built: plan.Plan) -> Violations:
    """Yield an error for each sling hooked at the start that does not reach its lug, is overloaded or passes through
    the block."""
    lugs, at = lug_places(built.machines), kinematics.poses(merge([x.system for x in built.machines], built.gravity))
    # as slack is counted: before blocks sink into their supports
    at |= {name: (np.array(p), np.array(axes)) for name in scene.all_blocks for p, axes in [scene.put(name)]}
    for machine in (machine for machine in built.machines if machine.ties):
        straight = {rope.name: rope for rope in machine.system.ropes}
        for tie in (tie for tie in machine.ties if tie.lug and tie.rope in straight):
            lug, rope, block = lugs[tie.lug], straight[tie.rope], scene.all_blocks[lugs[tie.lug].body]
            (a, b, c), place = kinematics.place(tie.upper, at).tolist(), tuple(kinematics.place(lug, at).tolist())
            message = reach(tie.rope, rope.L0, tie.lug, (a, b, c), place) or _overstretched(tie, rope, (a, b, c), place)
            if message:
                theirs = [(each.lug, lugs[each.lug].p) for each in machine.ties if each.lug and " beside " in message]
                places = ", ".join(f"{name} ({p[0]:g}, {p[1]:g}, {p[2]:g}) m" for name, p in theirs)
                yield machine.name, tie.where, f"{message}{f'; its lugs are {places}' if places else ''}"
                continue
            u, v, w = (max(0.0, side / 2 - SURFACE) for side in block.size)
            (x, y, z), R = at[lug.body]
            i, j, k = dense.product(R.T.tolist(), [a - x, b - y, c - z])
            inside = passes_through((i, j, k), lug.p, (u, v, w))
            if inside > 0.0 and block.shape is None:  # else the box is not the block
                message = f"{tie.rope} would go through {inside:.2g} m of the block on its straight way to the lug "
                yield tie.rope, tie.where, f"{message}{tie.lug}: put the lug on a face that the hook reaches"


def _overstretched(tie: plan.Tie, rope: Rope, beam: Vector, lug: Vector) -> str:
    """Describe a sling whose tension at the start exceeds its rated tension; "" if there is none."""
    gap = sqrt(sum((a - b) * (a - b) for a, b in zip(beam, lug, strict=True))) - rope.L0
    tension = rope.EA * gap / rope.L0
    if not tie.rated or tension <= tie.rated:
        return ""
    message = f"{tie.rope} begins stretched by {gap * 1e3:.3g} mm with {tension / 1e3:.0f} kN, rated for"
    return f"{message} {tie.rated / 1e3:.0f} kN: lower the hook or take a longer sling than {rope.L0:g} m"


# at the start and after each action


def _meet(built: plan.Plan, before: Places, after: Places) -> Violations:
    """Yield an error for machines on the same rails or girder that overlap or pass each other, unless side by side."""
    sliding = [
        (machine, joint, drive.name)
        for machine in built.machines
        for drive in machine.system.drives
        for joint in machine.system.joints
        if joint.name == drive.joint and joint.kind == "prismatic" and {drive.name} <= before.keys() & after.keys()
    ]
    for (one, a, drive), (two, b, other) in combinations(sliding, 2):
        if (a.parent, a.axis) != (b.parent, b.axis) or a.axis not in (X, Y):
            continue
        i, moved = (X, Y).index(a.axis), [places[other] - places[drive] for places in (after, before)]
        met = []
        for p, q in product(_boxes(one, a), _boxes(two, b)):
            least = (p[1][i] + q[1][i]) / 2
            gap, was = (distance + q[0][i] - p[0][i] for distance in moved)
            next_to = any(_between(p, q, k) >= -TOUCH for k in range(3) if k != i)
            if not next_to and (abs(gap) < least - TOUCH or gap * was < 0):
                met.append((least - abs(gap), abs(gap), least))
        if met:
            _, gap, least = max(met)
            names = (one.name, two.name) if a.parent == WORLD else (plan.driven(drive), plan.driven(other))
            message = f"{names[0]} and {names[1]} overlap: {gap:g} m from middle to middle"
            yield " ".join(names), two.where, f"{message}, but they need {least:g} m"


def _boxes(machine: plan.Mechanism, joint: Joint) -> list[tuple[Vector, Vector]]:
    """Return centres and edges [m] of the boxes of a sliding body when its coordinate is 0."""
    at = joint.p_PJ
    boxes = ((x.centre, x.size) for x in machine.shapes if x.body == joint.child)
    return [((x + at[0], y + at[1], z + at[2]), size) for (x, y, z), size in boxes]


def _between(p: tuple[Vector, Vector], q: tuple[Vector, Vector], i: int) -> float:
    """Return the gap between two boxes along axis i [m]; negative if they overlap."""
    return abs(p[0][i] - q[0][i]) - (p[1][i] + q[1][i]) / 2


def _clear(built: plan.Plan, state: StaticState, where: str) -> Violations:
    """Yield an error for each suspended block that passes through the ground."""
    for block, cargo in ((machine, cargo) for machine in built.machines for cargo in machine.cargo):
        if any(state.supports.get(s.name, 0.0) > 0.0 for s in block.system.supports):
            continue
        p, R = state.poses[cargo.body]
        lowest = p[2] - sum(abs(R[2][i]) * side / 2 for i, side in enumerate(cargo.size))
        if lowest < -SURFACE:
            message = f"the {named(cargo.body)} would sweep {-lowest:.2f} m into the ground: hoist it higher first"
            yield cargo.body, where, message


SAME = {"rope tension": "rope factor"}  # of hoist ropes, which are reported once
PLACES = ("rails", "girder", "rope length", "hook height")  # quantities that drives are moved to


def overloads(built: plan.Plan, statics: Followed) -> list[tuple[str, str]]:
    """Return (place in the scene, sentence) of each static overload."""
    checked = (x for x in built.limits if x.known and x.quantity in REFUSED)
    refused = [x for x in checked if x.source != "assumed" and FERRULE not in x.source]  # that somebody has written
    if not refused or not statics.states:
        return []
    places = msgspec.structs.replace(built, limits=tuple(refused))
    if found := _refused(built, uses_on_path(places, goal_states(built, statics))):
        return found
    guarded = {rope for interlock in built.interlocks if interlock.stops for rope in interlock.hooks}
    loads = (x for x in refused if x.quantity not in PLACES and not guarded.intersection(x.elements))
    parting = next((n for n, action in enumerate(built.actions, 1) if parts(action)), inf)
    states = [x for x in statics.states if x.action < parting]
    return _refused(built, uses_on_path(msgspec.structs.replace(built, limits=tuple(loads)), states))


def _refused(built: plan.Plan, uses: Sequence[Use]) -> list[tuple[str, str]]:
    found = Findings()
    for use in (use for use in uses if use.beyond):
        limit, action = use.limit, built.actions[use.action - 1] if use.action else None
        where, stage = (action.where, use.stage) if action else ("", "")
        violation = (limit.subject, where or limit.where, sentence(use, ran=False))
        found.take(SAME.get(limit.quantity, limit.quantity), iter([violation]), stage, where)
    return found.list()
