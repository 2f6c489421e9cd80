"""The columns of a run from which limits are checked."""

from collections.abc import Iterator, Mapping, Sequence
from math import atan2, ceil, cos, exp, inf, pi, sin, sqrt

import numpy as np
from heavylift.kernel.description.findings import NOT_CHECKED, Check, finding
from heavylift.kernel.description.mechanics import Support
from heavylift.nodes.limits.signals import SignalColumns, hooked_in
from heavylift.nodes.plan.connections import holders, lowering
from heavylift.nodes.plan.mechanism import OBSTACLES, Hoist, Mechanism
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.shapes import Shapes
from numpy.typing import NDArray

from .history import History, RunHistory, blocks
from .rigid_contacts import BOUNCE, RigidTouch, pressing, velocity
from .rotating import matrices

Floats = NDArray[np.float64]
STILL = 1e-5  # [m/s, rad/s] slower than anything that is ordered, faster than what a servo trembles
SPAN = 1e-3  # [s] over which a winch winds at least what its speed follows from: times are whole nanoseconds


def signals_of_run(
    plan: Plan,
    t: Floats,
    tensions: Mapping[str, Floats],
    poses: Mapping[str, Floats],
    rigs: Sequence[object],
    *,
    stages: Sequence[tuple[float, str]] = (),
    peaks: Mapping[str, tuple[float, float]] | None = None,
    crossings: Mapping[str, tuple[float, float]] | None = None,
    lengths: Mapping[str, Floats] | None = None,
) -> SignalColumns:
    """Return the columns of a run from which limits are checked.

    t (n,) [s], tensions (n,) [N], poses (n, 7) [m, quaternion x y z w], rope lines with the time from which they hang
    (`Rig`), exact peaks [N] and their times [s], overloads reported by load cells [N] and their times [s], unstretched
    lengths (n,) [m].
    """
    return SignalColumns(
        t=t,
        tensions=tensions,
        poses={name: (pose[:, :3], matrices(pose[:, 3:])) for name, pose in poses.items()},
        lengths=lengths or {},
        hooked=hooked_in(plan, [(rig.t_ns * 1e-9, rig.lines) for rig in rigs]),  # type: ignore[attr-defined]
        stages=stages,
        peaks=peaks or {},
        crossings=crossings or {},
        dynamic=True,
    )


def impacts(plan: Plan, past: RunHistory, rigid: Sequence[RigidTouch] = ()) -> dict[str, tuple[float, float]]:
    """Return, by name, the largest landing forces [N] of blocks on supports and obstacles, with the time [s].

    `rigid`: contacts of blocks with rigid things.

    A pad yields as a spring with a damper, whose force at the instant of contact gives the speed; the whole mass lands
    on the pads that touch then, less what ropes and other supports carry. An obstacle yields as a spring.
    """
    found: dict[str, tuple[float, float]] = {}
    loads = pressing(plan, past)
    for other, (force, t) in loads.items():
        _note(found, f"{other} support load", [force], t)
    yields = stiffness_of(plan)
    strands, pads = Shapes(plan).strands.values(), {s.name: s for m in plan.machines for s in m.system.supports}
    for limit in (x for x in plan.limits if x.quantity == "impact"):
        weight = (limit.value or 0.0) / limit.factor
        ropes = [x.rope for x in strands if limit.subject in x.ends]
        for x in (x for x in rigid if x.block == limit.subject and x.speed is not None and x.other in yields):
            carried = sum(float(x.part.tensions[rope][x.i]) for rope in ropes if rope in x.part.tensions)
            free = max(0.0, weight - carried) * max(0.0, x.up)
            force = landing_force(weight / plan.gravity, free, yields[x.other], 0.0, x.speed or 0.0)
            _note(found, f"{limit.subject} impact", [force], x.t)
            _note(found, f"{x.other} support load", [force], x.t)
        names = [name for name in limit.elements if name in pads and pads[name].d > 0.0]
        k, d = (np.array([getattr(pads[name], key) for name in names]) for key in ("k", "d"))
        for part in blocks(past) if names else ():
            F = np.array([part.tensions.get(name, np.zeros(len(part.t))) for name in names])
            pull = sum((part.tensions[rope] for rope in ropes if rope in part.tensions), np.zeros(len(part.t)))
            new = (F[:, 1:] > 0.0) & (F[:, :-1] == 0.0)
            for i in np.flatnonzero(new.any(axis=0)):
                on, now, t = new[:, i], F[:, i + 1], float(part.t[i + 1])
                others = float(now[~on].sum())
                free, speed = max(0.0, weight - others - float(pull[i + 1])), float((now[on] / d[on]).max())
                force = landing_force(weight / plan.gravity, free, float(k[on].sum()), float(d[on].sum()), speed)
                one = max(force * float(k[on].max() / k[on].sum()), float(now.max()))
                for what, value in (("impact", force + others), ("support load", one)):
                    _note(found, f"{limit.subject} {what}", [value], t)
    return found


def touches(plan: Plan, past: RunHistory, rigid: Sequence[RigidTouch] = ()) -> dict[str, tuple[float, float]]:
    """Return the largest landing speed and lift-off hoisting speed [m/s] of each block, by name, with times [s]."""
    found: dict[str, tuple[float, float]] = {}
    for block, part, i, touched, _ in _arrivals(plan, past):
        speeds = _sinking(plan, part, touched, i) if touched else _wound(plan, block, part, i)
        _note(found, f"{block} {'landing' if touched else 'lift-off'} speed", speeds, float(part.t[i]))
    for x in rigid:
        if x.speed is not None:
            _note(found, f"{x.block} landing speed", [x.speed], x.t)
        elif x.below:
            _note(found, f"{x.block} lift-off speed", _wound(plan, x.block, x.part, x.i), x.t)
    return found


def _note(found: dict[str, tuple[float, float]], key: str, values: Sequence[float], t: float) -> None:
    if values and max(values) > found.get(key, (-inf, t))[0]:
        found[key] = max(values), t


def unknown_forces(plan: Plan, past: RunHistory, rigid: Sequence[RigidTouch]) -> Iterator[Check]:
    """Yield a row for each contact of a block with an obstacle whose stiffness or capacity is missing for a check."""
    obstacles = {x.body for machine in plan.machines if machine.name == OBSTACLES for x in machine.shapes}
    rated, yields = {x.subject for x in plan.limits if x.quantity == "support load" and x.known}, stiffness_of(plan)
    hits = {(x.block, x.other): x.t for x in reversed(rigid) if x.speed is not None and x.other not in yields}
    for (block, other), t in hits.items():
        remedy = f"give 'stiffness' of {other}" if other in obstacles else "look at it; its speed is checked"
        yield _open("impact", f"{block} on {other}", f"force of {block} as it hits {other}: {remedy}", t)
    for other, (_, t) in pressing(plan, past).items():
        if other in obstacles - rated:
            yield _open("support load", other, f"force on {other}: give its 'capacity'", t)


def _open(quantity: str, subject: str, message: str, t: float) -> Check:
    return Check(quantity=quantity, subject=subject, state="amber", why=NOT_CHECKED, t=t, sentence=message)


def stiffness_of(plan: Plan) -> dict[str, float]:
    """Return the stiffness [N/m] of the obstacles that have one."""
    return {x.body: x.stiffness for machine in plan.machines for x in machine.shapes if x.stiffness}


def dropped(plan: Plan, past: RunHistory, turning: Sequence[tuple[str, float, float]]) -> Iterator[Check]:
    """Yield a finding for each block that lands on the ground during a turn, or while no hook or drive lowers it.

    `turning`: blocks with the intervals [s] in which they are ordered to turn.
    """
    seen = set[str]()
    for block, part, i, touched, first in _arrivals(plan, past):
        if not touched or not first or block in seen or any(pad.on for pad, _ in touched):
            continue
        (hooks, machines), k, t = _holders(plan, block, part, i), _before(part, i), float(part.t[i])
        still, wound = STILL * (t - float(part.t[k])), {name: float(L[i] - L[k]) for name, L in part.lengths.items()}
        winches, drives = lowering(machines)
        pays = any(wound.get(hook.rope, 0.0) > still for hook in hooks)
        pays |= any(abs(wound.get(rope, 0.0)) > still for rope in winches)
        joints = {drive.joint for drive in drives}
        luffing = any(abs(x[i]) > STILL for name, x in part.speeds.items() if name.rpartition(".")[0] in joints)
        if any(who == block and begin <= t <= end for who, begin, end in turning) or not (pays or luffing):
            seen.add(block)
            message = f"{block} came down on its supports in a stage that does not lower it: hoist it higher first"
            yield finding("red", "landing", block, message, t=t)


Touched = Sequence[tuple[Support, float]]  # supports with their forces [N]


def _arrivals(plan: Plan, past: RunHistory) -> Iterator[tuple[str, History, int, Touched, bool]]:
    """Yield each landing of a block on some of its supports, except bounces, and each lift-off: block, part of the
    history, number of the sample in that part, the supports that touch then (none at lift-off), and whether the block
    stood on none before."""
    pads = {s.name: s for m in plan.machines for s in m.system.supports}
    for limit in (x for x in plan.limits if x.quantity == "landing speed"):
        own = [pads[name] for name in limit.elements if name in pads]
        top = np.full(len(own), -inf)  # of the point above each support, since that left it [m]
        for part in (x for x in blocks(past) if own and own[0].point.body in x.poses):
            F = np.array([part.tensions.get(pad.name, np.zeros(len(part.t))) for pad in own])
            on, z = F > 0.0, _heights(part.poses[own[0].point.body], own)
            left = np.zeros(len(own), np.intp)
            for i in (np.flatnonzero((on[:, 1:] != on[:, :-1]).any(axis=0)) + 1).tolist():
                now, before, touched = on[:, i], on[:, i - 1], list[tuple[Support, float]]()
                for j in np.flatnonzero(now != before).tolist():
                    if before[j]:
                        left[j], top[j] = i, -inf
                    elif max(top[j], *z[j, left[j] : i]) - z[j, i] >= BOUNCE:
                        touched.append((own[j], float(F[j, i])))
                if not before.any():  # the others fall from where they are now
                    left[~now], top[~now] = i, -inf
                if touched or not now.any():
                    yield limit.subject, part, i, touched, not before.any()
            for j in np.flatnonzero(~on[:, -1]).tolist() if len(part.t) else ():
                top[j] = max(top[j], *z[j, left[j] :])


def _heights(poses: Floats, own: Sequence[Support]) -> Floats:
    """Return the heights (supports, n) [m] of the points of a body above its supports, from its poses (n, 7)."""
    up = matrices(poses[:, 3:])[:, 2]
    return np.array([poses[:, 2] + up @ np.array(pad.point.p) for pad in own])


def _sinking(plan: Plan, part: History, touched: Touched, i: int) -> list[float]:
    """Return how fast [m/s] the points of a block that touch supports, given with their forces [N], sink at sample i
    towards the ground or deck there; where velocities are unknown, by the dampers of the supports."""
    body, k = touched[0][0].point.body, _before(part, i)
    joint = next((j.name for m in plan.machines for j in m.system.joints if j.child == body), "")
    decks, found = {pad.on for pad, _ in touched if pad.on}, list[float]()
    p, R = part.poses[body][i, :3], matrices(part.poses[body][i : i + 1, 3:])[0]
    for pad, _ in touched:
        at = p + R @ np.array(pad.point.p)
        v = velocity(part, body, joint, at, i)
        if v is None or (decks and (k == i or not decks <= {*part.poses})):
            return [force / pad.d for pad, force in touched if pad.d > 0.0]
        sinks = -float(v[2])
        if pad.on:
            (now, then), (S, before) = part.poses[pad.on][[i, k], :3], matrices(part.poses[pad.on][[i, k], 3:])
            sinks += float(((S - before) @ (S.T @ (at - now)) + now - then)[2] / (part.t[i] - part.t[k]))
        found.append(sinks)
    return found


def _wound(plan: Plan, block: str, part: History, i: int) -> list[float]:
    """Return the speeds [m/s] at which hooks that hold a block are wound up at sample i, from the rope lengths just
    before."""
    before, found = _before(part, i), []
    seconds = (round(part.t[i] * 1e9) - round(part.t[before] * 1e9)) * 1e-9  # exact also late in a run
    for hook in _holders(plan, block, part, i)[0]:
        if before < i and hook.rope in part.lengths:
            found.append(float(part.lengths[hook.rope][before] - part.lengths[hook.rope][i]) / seconds)
    return [speed for speed in found if speed > 0.0]


def _holders(plan: Plan, block: str, part: History, i: int) -> tuple[list[Hoist], list[Mechanism]]:
    """Return the hooks that hold a block at sample i, and the machines that are connected with it."""
    hooked = hooked_in(plan, [(rig.t_ns * 1e-9, rig.lines) for rig in part.rigs])
    return holders(plan.machines, block, next((lugs for start, lugs in reversed(hooked) if start <= part.t[i]), {}))


def _before(part: History, i: int) -> int:
    """Return the number of the last sample that is at least SPAN before sample i."""
    return max(0, int(np.searchsorted(part.t, part.t[i] - SPAN, side="right")) - 1)


def rehits(plan: Plan, past: RunHistory, lands: Sequence[tuple[float, float]]) -> Iterator[Check]:
    """Yield a warning for each block that touches the deck of a vessel again after lift-off, with number and speed of
    the impacts.

    `lands`: intervals [s] in which the block is set down on purpose.
    """
    pads = {s.name: s for m in plan.machines for s in m.system.supports if s.on and s.d > 0.0}
    for limit in (x for x in plan.limits if x.quantity == "impact"):
        names = [name for name in limit.elements if name in pads]
        d, lifted, hits = np.array([[pads[name].d] for name in names]), False, list[tuple[float, float]]()
        for part in blocks(past) if names else ():
            F = np.array([part.tensions.get(name, np.zeros(len(part.t))) for name in names])
            on = np.asarray((F > 0.0).any(axis=0))
            for i in np.flatnonzero(on[1:] != on[:-1]) + 1:
                t = float(part.t[i])
                meant = any(begin <= t <= end for begin, end in lands)
                if on[i] and lifted and not meant:
                    hits.append((float((F[:, i : i + 1] / d).max()), t))
                lifted = not meant and (lifted or not on[i])
        if hits:
            times = "once" if len(hits) == 1 else f"{len(hits)} times"
            speed = 60.0 * max(hits)[0]
            message = (
                f"{limit.subject} touched the deck again {times} after it was lifted off, at up to {speed:.2g} m/min"
            )
            yield finding("amber", "re-hit", limit.subject, f"{message}: hoist faster, or in a lower sea", t=hits[0][1])


def landing_force(mass: float, free: float, k: float, d: float, speed: float) -> float:
    """Return the largest force [N] in a spring-damper support during the landing of a mass.

    Spring k [N/m], damper d [N s/m], mass [kg] with uncarried weight `free` [N] landing at `speed` [m/s]: F = free - m
    a, m a'' + d a' + k a = 0.
    """
    a = free / mass - d * speed / mass
    slope = -(k * speed + d * a) / mass
    decay, square = d / (2.0 * mass), k / mass - (d / (2.0 * mass)) ** 2
    least, first = a, free - mass * a
    if square > 0.0:
        w = sqrt(square)
        b = (slope + decay * a) / w
        t = atan2(b * w - a * decay, a * w + b * decay) / w  # where a' = 0
        t += pi / w * max(0.0, ceil(-t * w / pi))
        for x in (t, t + pi / w):
            least = min(least, exp(-decay * x) * (a * cos(w * x) + b * sin(w * x)))
    return max(first, free - mass * least)
