"""Findings about the equilibrium path other than loads: instability, falling loads, stages of zero duration, a path
that ends early."""

from collections.abc import Mapping
from itertools import pairwise
from math import degrees, inf, pi, radians, sqrt
from typing import Any

from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description.findings import IN_A_RUN, NOT_CHECKED, RESTLESS, Check, State, clock, finding
from heavylift.nodes.models.commander.actuator_registry import turn_of
from heavylift.nodes.models.commander.conditions import terms
from heavylift.nodes.plan import plan
from heavylift.nodes.plan.actions import Move, SlingsCondition, Turn, UnhookSling
from heavylift.nodes.plan.connections import holders, lowering, lug_places, ties_on

from .aiming import world
from .static_path import Followed

PLUMB = 0.1  # [m] out of which a hook is named
TURNED = radians(2.0)  # beside the ordered angle a block has not turned as ordered; stretch leaves 0.7 in `turnover`
ENDED = 1e-9  # [rad] from the ordered angle, a turn has ended
GROWTH = 1e-4  # [1/s2] of an eigenvalue of the tangent stiffness that is instability, not rounding


def path_findings(built: plan.Plan, path: Followed) -> list[Check]:
    """Return all findings about an equilibrium path, in order of occurrence."""
    if built.lists:
        return [*path.found]
    checks = (_unstable, _falls, _at_once, _lands, _turns, _tripped, _cut, _unfollowed)
    return [x for check in checks for x in check(built, path)]


def _unstable(built: plan.Plan, path: Followed) -> list[Check]:
    found = next((x for x in path.states if x.stiffness is not None and x.stiffness < -GROWTH), None)
    times = [t for t in (path.unstable, found.t if found else None) if t is not None]
    if not times:
        return []
    state = next((x for x in path.states if x.t >= min(times)), path.states[-1])
    value = min((x.stiffness for x in path.states if x.stiffness is not None), default=None)
    sentence = "what hangs is not stable at rest: the smallest push would make it tip over"
    numbers: dict[str, Any] = {"value": value, "limit": 0.0, "unit": "1/s2"}
    return [_finding(built, state.action, "red", "unstable", "scene", sentence, state.t, **numbers)]


def _falls(built: plan.Plan, path: Followed) -> list[Check]:
    found = []
    for t, sentence in path.notes:
        state = next((x for x in path.states if x.t >= t), path.states[-1])
        found.append(_finding(built, state.action, "amber", "fall", "scene", sentence, t))
    return found


def _at_once(built: plan.Plan, path: Followed) -> list[Check]:
    """Return a finding for each stage whose moves end at once, because the condition that ends them holds already."""
    found = []
    times = [x.before.t for x in path.acted] + ([path.states[-1].t] if path.known and path.states else [])
    for number, (begin, end) in enumerate(pairwise(times), 1):
        action = built.actions[number - 1]
        waits = [o.until for o in action.orders if isinstance(o, Move | Turn) and o.until is not None]
        tight = all(
            isinstance(term, SlingsCondition) and term.state == "taut" for until in waits for term in terms(until)
        )
        if any(isinstance(o, Move) and o.trims for o in action.orders):
            continue
        if waits and end == begin and len(waits) == len(action.orders) and not (tight and begin == 0.0):
            words = " and ".join(dict.fromkeys(term.text for until in waits for term in terms(until)))
            sentence = f"the stage '{action.stage or number}' ends at once: '{words}' holds already as it begins"
            found.append(_finding(built, number, "red", "stage", action.stage or f"action {number}", sentence, begin))
    return found


def _lands(built: plan.Plan, path: Followed) -> list[Check]:
    """Return a finding for each load that comes down on its supports while no order lowers it."""
    found: dict[tuple[str, int], Check] = {}
    pads = {s.name: s.point.body for machine in built.machines if machine.cargo for s in machine.system.supports}
    lugs = {point: name for name, point in lug_places(built.machines).items()}
    ties = [tie for machine in built.machines for tie in machine.ties]
    for before, x in pairwise(path.states):
        orders = built.actions[x.action - 1].orders if x.action else ()
        turned = {order.block for order in orders if isinstance(order, Turn)}
        stood, stands = ({pads[s] for s, force in y.supports.items() if s in pads and force > 0.0} for y in (before, x))
        for body in sorted(stands - stood) if orders and not any(isinstance(o, UnhookSling) for o in orders) else ():
            taut = {tie.rope: lugs.get(tie.lower, "") for tie in ties if tie.lower and before.tensions.get(tie.rope)}
            hooks, machines = holders(built.machines, body, {**x.hooked, **taut})
            winches, drives = lowering(machines)
            lowers = any(x.speeds.get(hook.rope, 0.0) > 0.0 for hook in hooks)
            lowers |= any(x.speeds.get(name, 0.0) for name in (*winches, *(drive.name for drive in drives)))
            if body in turned or not lowers:
                name = built.actions[x.action - 1].stage or f"action {x.action}"
                sentence = (
                    f"{body} comes down on its supports in '{name}', which does not lower it: hoist it higher first"
                )
                found.setdefault((body, x.action), _finding(built, x.action, "red", "landing", body, sentence, x.t))
    return [*found.values()]


def _turns(built: plan.Plan, path: Followed) -> list[Check]:
    """Return a finding for each turn that leaves its block at another angle when it ends on the path; one that was
    stopped does not end."""
    found, own = list[Check](), turn_of(built)
    for number, to in ((n, x.to) for n, a in enumerate(built.actions, 1) for x in a.orders if isinstance(x, Turn)):
        ended = (x for x in path.states if x.action >= number and abs(x.references.get(own, inf) - to) < ENDED)
        found += [y for x in (*ended,)[:1] for y in missed_turns(built, number, x.poses, x.t)]
    return found


def missed_turns(built: plan.Plan, number: int, poses: Mapping[str, tuple[Any, Any]], t: float) -> list[Check]:
    """Return a finding for each block that ends a turn in action `number` at another angle than ordered.

    `poses`: position and rotation matrix of each body at the end t [s] of the turn."""
    found = []
    for order in (x for x in built.actions[number - 1].orders if isinstance(x, Turn) and x.until is None):
        if order.block not in poses:
            continue
        R = poses[order.block][1]
        away = (float(atan2(float(R[1][2]), float(R[2][2]))) - order.to + pi) % (2.0 * pi) - pi
        if abs(away) > TURNED:
            stands = f"{order.block} stands at {degrees(order.to + away):.1f} degrees after its turn to"
            sentence = f"{stands} {degrees(order.to):g} degrees: hold it by hooks on both sides of the axis of turning"
            at = {"value": degrees(abs(away)), "limit": degrees(TURNED), "unit": "deg"}
            found.append(_finding(built, number, "red", "turn", order.block, sentence, t, **at))
    return found


def _tripped(built: plan.Plan, path: Followed) -> list[Check]:
    """Return a finding for each interlock that trips on the path."""
    found, known = [], {x.name: x for x in built.interlocks}
    for name, t in {name: t for t, name in reversed(path.tripped)}.items():
        state = next((x for x in reversed(path.states) if x.t <= t), path.states[-1])
        severity, sentence = known[name].message()
        found.append(_finding(built, state.action, severity, "interlock", name, sentence, t))
    return sorted(found, key=lambda x: x.t or 0.0)


def _cut(built: plan.Plan, path: Followed) -> list[Check]:
    if not path.states or (not path.cut and (built.end is None or path.why or not built.actions)):
        return []
    last = path.states[-1]
    if not path.cut:  # lift-off takes longer in a run, where girders sag
        sentence = (
            f"its actions end at {clock(last.t, 1)} at rest, the scene at {clock(built.end or 0.0, 1)}; a run checks"
        )
        return [_finding(built, last.action, "none", "end", "actions", sentence, None, why=IN_A_RUN)]
    ends = "the action list never comes to its end" if built.end is None else f"the scene ends at {built.end:g} s"
    sentence = f"{ends}: {path.cut}" if built.end is None else f"{ends} before its action list is done: {path.cut}"
    return [_finding(built, last.action, "red", "cut", "end", sentence, built.end)]


def _unfollowed(built: plan.Plan, path: Followed) -> list[Check]:
    """Return a finding for each lift whose action list can be followed only in part."""
    if not path.why or not any(machine.cargo for machine in built.machines):
        return []
    action, t = (path.states[-1].action, path.states[-1].t) if path.states else (0, 0.0)
    why = _out_of_plumb(built, path) or path.why
    sentence = f"the lift is not checked at rest from {clock(t, 1)} on: {why}; `heavylift run` checks it"
    return [_finding(built, action, "amber", "unfollowed", "scene", sentence, t, why=NOT_CHECKED)]


def _out_of_plumb(built: plan.Plan, path: Followed) -> str:
    """Describe the hook that is farthest out of plumb of its lugs where no position of rest was found, and how to mend
    it; "" if the path ended for another reason, or if all hooks are above their lugs."""
    if RESTLESS not in path.why or not path.states:
        return ""
    x, known, worst = path.states[-1], lug_places(built.machines), (PLUMB, "")
    for machine, hook in ((m, hook) for m in built.machines for hook in m.hooks):
        ends = [tie.lower or known.get(x.hooked.get(tie.rope, "")) for tie in ties_on(built.machines, hook)]
        lines = [line for rope in machine.system.straight_ropes if rope.name == hook.rope for line in rope.lines]
        tops = [world(x, p.body, p.p) for line in lines for p in (line.a, line.b) if p.body == hook.on]
        lugs = [world(x, p.body, p.p) for p in ends if p is not None]
        if not lugs or not tops:
            continue
        u, v = (sum(p[i] for p in lugs) / len(lugs) - sum(p[i] for p in tops) / len(tops) for i in (0, 1))
        away, to = sqrt(u * u + v * v), f"{u:.2f} m along x and {v:.2f} m along y"
        message = f"no position of rest is found, and the hook {hook.rope} is {away:.2f} m out of plumb"
        worst = max(worst, (away, f"{message}; move it by {to}, above its lugs, before it lifts"))
    return worst[1]


def _finding(
    built: plan.Plan, action: int, state: State, quantity: str, who: str, sentence: str, t: float | None, **more: Any
) -> Check:
    """Return a finding with the line and stage of an action; `more`: further fields, such as its value and limit."""
    of = built.actions[action - 1] if action else None
    where, stage = (of.where, of.stage) if of else ("", "")
    return finding(state, quantity, who, sentence, where=where, stage=stage, t=t, **more)
