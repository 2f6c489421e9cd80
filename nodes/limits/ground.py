"""Loads of a machine on the ground, from the statics of all bodies connected to it by joints, as columns over n
instants.

Weights and rope pulls give one resultant force with its position on the ground; inertia of the machine itself and wind
on it are not included. That force V [N] at x, y [m] from the middle of the base is shared by

    two tracks    by the lever between them; below each along its length by the trapezoid of a rigid body on springs,
                  or by the triangle beyond the middle third
    four corners  V/4 (1 +- 2x/l +- 2y/w), as of a rigid base on equal springs; if one corner would be pulled, by the
                  other three, whose loads do not depend on stiffness

The moment of a drive about the axis of its joint is caused by the weights and rope pulls on all bodies that the joint
carries; for starting, the moment that accelerates the machine's inertia is added. Wind is not included.

The module also covers statically indeterminate load sharing, and the factors that standards give for it.

A block on more than three hooks or slings distributes its weight according to their stiffness: a millimetre of length
matters. The printed shares hold for the given lengths.
"""

from collections.abc import Iterator

import numpy as np
from heavylift.kernel.algebra.dense import product
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import WORLD, Joint, Line, Point, Vector
from heavylift.nodes.models.commander.conditions import terms
from heavylift.nodes.plan.actions import Action, LandedCondition, LiftedCondition, Move
from heavylift.nodes.plan.limit import RatedLimit
from heavylift.nodes.plan.mechanism import Footing, Mechanism, beneath, ties_on
from heavylift.nodes.plan.plan import Plan

from .signals import Column, SignalColumns, place
from .standards import HOISTING, SHARING, daf, hoisting_factor

CORNERS = {"front left": (1.0, 1.0), "front right": (1.0, -1.0), "rear left": (-1.0, 1.0), "rear right": (-1.0, -1.0)}
SIDES = {"left": 1.0, "right": -1.0}
PARTS = 24  # of the way that a machine slews between two instants of a path at rest, which are looked at


def corner_load(V: Column, x: Column, y: Column, base: tuple[float, float], corner: str) -> Column:
    """Return the load (n,) [N] on a corner of a base of the given (length, width) under a vertical force V at (x,
    y)."""
    (along, across), u, v = CORNERS[corner], 2.0 * x / base[0], 2.0 * y / base[1]
    a, b = along * u, across * v
    four = V / 4.0 * (1.0 + a + b)
    loaded = (
        V
        / 2.0
        * np.where(
            (a >= 0.0) & (b >= 0.0),
            a + b,
            np.where(a >= 0.0, 1.0 - np.abs(v), np.where(b >= 0.0, 1.0 - np.abs(u), 0.0)),
        )
    )
    return np.asarray(np.where(np.abs(u) + np.abs(v) <= 1.0, four, np.clip(loaded, 0.0, V)))


def track_pressure(V: Column, x: Column, y: Column, base: tuple[float, float], breadth: float, side: str) -> Column:
    """Return the largest pressure (n,) [Pa] below one track of a base of the given (length, track distance); infinite
    if the machine tips."""
    length, apart = base
    own, e = np.clip(V / 2.0 * (1.0 + 2.0 * SIDES[side] * y / apart), 0.0, V), np.abs(x)
    with np.errstate(divide="ignore", invalid="ignore"):
        triangle = np.where(e < length / 2.0, 2.0 * own / (3.0 * breadth * (length / 2.0 - e)), np.inf)
    return np.asarray(np.where(e <= length / 6.0, own / (breadth * length) * (1.0 + 6.0 * e / length), triangle))


def distance_to_tipping(x: Column, y: Column, base: tuple[float, float], *, lifts: bool) -> Column:
    """Return how far the force is from the middle of the base, as a fraction (n,) of the distance at which the machine
    tips or, with `lifts`, at which one corner loses contact."""
    u, v = np.abs(2.0 * x / base[0]), np.abs(2.0 * y / base[1])
    return np.asarray(u + v if lifts else np.maximum(u, v))


def stood(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Column | None:
    """Return the quantity that a limit checks for the footing of a machine (n,): pressure [Pa], wheel load [kg] or
    fraction of the distance to tipping; None if data are missing."""
    machine = next((m for m in plan.machines if m.name in limit.elements), None)
    footing = machine.footing if machine else None
    if machine is None or footing is None:
        return None
    found = signals.once(("resultant", machine.name), lambda: resultant(plan, machine, signals))
    if found is None:
        return None
    values = [_of(plan, limit, footing, V, x, y) for V, x, y in _slewed(machine, signals, *found)]
    return np.asarray(np.maximum.reduce(values))


def _of(plan: Plan, limit: RatedLimit, footing: Footing, V: Column, x: Column, y: Column) -> Column:
    """Return the quantity of a footing's limit from the resultant force V [N] on the ground at x, y [m]."""
    base = footing.length, footing.width
    if limit.quantity == "uplift":
        return distance_to_tipping(x, y, base, lifts=footing.kind == "wheels")
    if footing.kind == "wheels":
        return np.asarray(corner_load(V, x, y, base, limit.over) / footing.each / plan.gravity)
    if footing.kind == "tracks":
        below, area = track_pressure(V, x, y, base, footing.each, limit.over), footing.each * footing.length
    else:
        below, area = corner_load(V, x, y, base, limit.over) / footing.each, footing.each
    if footing.mat:
        below = (below * area + footing.mat[1] * plan.gravity) / footing.mat[0]
    return np.asarray(below)


def _slewed(
    machine: Mechanism | None, signals: SignalColumns, V: Column, x: Column, y: Column
) -> Iterator[tuple[Column, Column, Column]]:
    """Yield the resultant force on the ground and its position; on an equilibrium path also for intermediate angles
    while the machine slews."""
    yield V, x, y
    actuators = machine.actuators if machine and not signals.dynamic else ()
    for slewer in (a.name for a in actuators if a.verb == "slew" and a.name in signals.lengths):
        distance = np.append(0.0, np.diff(signals.lengths[slewer]))
        for part in range(1, PARTS if (distance != 0.0).any() else 0):
            c, s = (np.array([float(f(x)) for x in distance * part / PARTS]) for f in (cos, sin))
            yield V, x * c + y * s, y * c - x * s


def resultant(plan: Plan, machine: Mechanism, signals: SignalColumns) -> tuple[Column, Column, Column] | None:
    """Return the resultant force on the ground (n,) [N] and its position in the frame of the base (n,) [m]; None if a
    body or rope is not recorded."""
    footing = machine.footing
    assert footing is not None
    middle = place(signals, Point(footing.body, footing.at))
    forces = list(_forces(plan, machine, signals, standing(machine)))
    if middle is None or not forces or any(p is None or F is None for p, F in forces):
        return None
    V, Mx, My = np.zeros(len(signals.t)), np.zeros(len(signals.t)), np.zeros(len(signals.t))
    for p, F in forces:
        assert p is not None
        assert F is not None
        d = p - middle
        V = V - F[:, 2]
        Mx = Mx + d[:, 1] * F[:, 2] - d[:, 2] * F[:, 1]
        My = My + d[:, 2] * F[:, 0] - d[:, 0] * F[:, 2]
    ex, ey, R = My / V, -Mx / V, signals.poses[footing.body][1]
    x, y = ex * R[:, 0, 0] + ey * R[:, 1, 0], ex * R[:, 0, 1] + ey * R[:, 1, 1]
    return V, x, y


def _forces(
    plan: Plan, machine: Mechanism, signals: SignalColumns, own: set[str]
) -> Iterator[tuple[Column | None, Column | None]]:
    """Yield points (n, 3) [m] and forces (n, 3) [N]: the weights of the bodies in `own` and the pulls of ropes that
    lead to other bodies."""
    n = len(signals.t)
    for body in (body for body in machine.system.bodies if body.name in own):
        weight = np.zeros((n, 3))
        weight[:, 2] = -body.mass * plan.gravity
        yield place(signals, Point(body.name, body.com)), weight
    for rope in (rope for m in plan.machines for rope in m.system.straight_ropes):
        for line in rope.lines:
            inside = line.a.body in own, line.b.body in own
            if inside[0] != inside[1] and rope.name in signals.tensions:
                yield _pull(signals, line if inside[0] else Line(line.b, line.a, line.share), rope.name)


def _pull(signals: SignalColumns, line: Line, rope: str) -> tuple[Column | None, Column | None]:
    """Return the point and the force of a rope line at its first end; None for each that is not recorded."""
    a, b = place(signals, line.a), place(signals, line.b)
    if a is None or b is None:
        return a, None
    d = b - a
    size = np.sqrt(d[:, 0] * d[:, 0] + d[:, 1] * d[:, 1] + d[:, 2] * d[:, 2])
    return a, np.asarray(d * (line.share * signals.tensions[rope] / np.maximum(size, 1e-9))[:, None])


def standing(machine: Mechanism) -> set[str]:
    """Return the names of the bodies that are connected to the base of a machine by joints."""
    footing = machine.footing
    pairs = [
        (j.parent, j.child) for j in machine.system.joints if j.kind != "free" and WORLD not in (j.parent, j.child)
    ]
    found, before = {footing.body} if footing else set[str](), 0
    while len(found) > before:
        before = len(found)
        found |= {body for pair in pairs if {*pair} & found for body in pair}
    return found


def drive_moment(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Column | None:
    """Return the moment (n,) [N m] with which the drive or brake of a revolute joint holds the bodies that the joint
    carries; for a limit over "start", the moment of the acceleration ramp is added."""
    (child,) = limit.elements
    machine, joint = next((m, j) for m in plan.machines for j in m.system.joints if j.child == child)
    carried = {child} | {b.name for b in machine.system.bodies if any(j is joint for j in beneath(machine, b.name))}
    middle, tip = (place(signals, Point(joint.parent, p)) for p in (joint.p_PJ, _tip(joint)))
    forces = list(_forces(plan, machine, signals, carried))
    if middle is None or tip is None or any(p is None or F is None for p, F in forces):
        return None
    axis = tip - middle
    found = np.zeros(len(signals.t))
    for p, F in forces:
        assert p is not None  # asked above
        assert F is not None
        found = found + np.sum(np.cross(p - middle, F) * axis, axis=1)
    if limit.over != "start":
        return np.abs(found)
    drive = next(drive.name for drive in machine.system.drives if drive.joint == joint.name)
    moves = (x for action in plan.actions for x in action.orders if isinstance(x, Move) and x.actuator == drive)
    ramp = max((x.accel for x in moves), default=next(a.accel for a in machine.actuators if a.name == drive))
    inertia = np.zeros(len(signals.t))
    for body in (body for body in machine.system.bodies if body.name in carried and body.name in signals.poses):
        centre = place(signals, Point(body.name, body.com))
        assert centre is not None  # its pose is among the signals
        d, own = np.cross(centre - middle, axis), signals.poses[body.name][1]
        e = np.sum(own * axis[:, :, None], axis=1)  # the axis in the body
        turned = np.sum(e[:, :, None] * np.array(body.inertia), axis=1)
        inertia = inertia + body.mass * np.sum(d * d, axis=1) + np.sum(e * turned, axis=1)
    return np.asarray(np.abs(found) + ramp * inertia)


def _tip(joint: Joint) -> Vector:
    """Return the point, in the frame of the joint's parent, that is one metre along the joint axis from the joint."""
    x, y, z = (p + a for p, a in zip(joint.p_PJ, product(joint.R_PJ, joint.axis), strict=True))
    return x, y, z


DETERMINATE = 3  # hangers of a rigid body whose shares follow from equilibrium alone


def indeterminate(plan: Plan) -> int:
    """Return the number of hooks on a block if their shares of the load are statically indeterminate, else 0."""
    most = 0
    for cargo in (cargo for machine in plan.machines for cargo in machine.cargo):
        hooks = (hook for machine in plan.machines for hook in machine.hooks)
        holds = (any(tie.lug in cargo.lugs for tie in ties_on(plan.machines, hook)) for hook in hooks)
        most = max(most, sum(holds))
    return most if most > DETERMINATE else 0


def shared(plan: Plan) -> list[str]:
    """Return sentences about indeterminate load sharing and the factors that standards give for it."""
    many = indeterminate(plan)
    if not many:
        return []
    message = f"{many} hooks carry the block: their shares are statically indeterminate"
    message += ", computed from the given lengths and stiffness"
    required = "; ".join(f"{s.when}: {s.message} ({s.source})" for s in SHARING.values())
    return [message, f"factors of standards for parts that should carry equal loads: {required}"]


def dynamics_required(plan: Plan) -> tuple[float, str] | None:
    """Return the dynamic amplification factor that a standard requires for the block, and its source; None if no block
    is lifted or its place is not given."""
    masses = [cargo.mass for machine in plan.machines for cargo in machine.cargo]
    return daf(plan.place, max(masses)) if masses else None


def touching(plan: Plan, kind: type[LiftedCondition] | type[LandedCondition]) -> list[tuple[Action, float]]:
    """Return the actions that hoist until a block is lifted, or that lower it until it has landed (as `kind` says),
    each with its speed [m/s]."""
    moves = ((action, x) for action in plan.actions for x in action.orders if isinstance(x, Move))
    winding = ((action, x) for action, x in moves if x.verb in ("hoist", "lower"))
    return [(action, abs(x.speed)) for action, x in winding if any(isinstance(y, kind) for y in terms(x.until))]


def touch_speed(plan: Plan, limit: RatedLimit, signals: SignalColumns) -> Column:
    """Return the highest ordered hook speed (n,) [m/s] in the stages with lift-off or landing."""
    values = np.full(len(signals.t), np.nan)
    for action, speed in touching(plan, LiftedCondition if limit.quantity == "lift-off speed" else LandedCondition):
        here = signals.within(action.stage)
        values[here] = np.where(values[here] > speed, values[here], speed)
    return values


def hoisting_factors(plan: Plan) -> list[str]:
    """Return, as text for each hoisting class, the factor that EN 13001-2 requires at the highest lift-off speed of the
    plan."""
    speeds = [speed for _, speed in touching(plan, LiftedCondition)]
    if not speeds:
        return []
    each = ", ".join(f"{name} {hoisting_factor(max(speeds), name):.3f}" for name in HOISTING)
    return [f"EN 13001-2, 4.2.2.2, lifts off at {max(speeds) * 60:g} m/min: phi_2 = {each}"]
