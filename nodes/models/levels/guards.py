"""Cases in which a simplification does not change the motion: no order moves the simplified parts, or the lift is
mirror-symmetric.

Each guard reads a whole plan and returns "" if its pass may change the motion, else the reason why it cannot. A lift is
mirror-symmetric about a vertical plane if each body is its own mirror image, and each rope, sling and support has a
partner: then nothing leaves the plane, and a model of the motion in this plane is exact.
"""

from collections.abc import Callable, Sequence
from functools import cached_property

from heavylift.kernel.algebra.dense import dot, product
from heavylift.kernel.description.forces import Wind
from heavylift.kernel.description.mechanics import WORLD, Body, Joint, Point, Vector, merge
from heavylift.nodes.plan.actions import Hookup, Move, Turn, UnhookSling
from heavylift.nodes.plan.fidelity import ASKEW, NORMAL, leaves
from heavylift.nodes.plan.mechanism import Mechanism
from heavylift.nodes.plan.plan import Plan

DIGITS = 9  # of places that are equal [m]
SAME = 1e-9  # relative, of moments
STILL, MIRRORED, UNTURNED, NONE = "nothing moves it", "by symmetry", "nothing is turned", "there is none"
SIMPLE = ("free", "fixed", "prismatic", "revolute")


def guard_locked(plan: Plan) -> str:
    """Return the reason why locking the joints leaves the motion unchanged, or "" if it may change the motion.

    The reason is that no order moves their drives, or that the lift is mirror-symmetric."""
    drives = {drive.joint: drive for machine in plan.machines for drive in machine.system.drives}
    moved, names = ordered(plan), {*plan.fidelity.locked}
    joints = [joint for machine in plan.machines for joint in machine.system.joints if joint.name in names]
    found = {STILL} if joints else set[str]()
    for joint in joints:
        drive = drives.get(joint.name)
        if drive is None or drive.kind != "prescribed" or drive.wave or drive.waves or drive.name in moved:
            found.add(guard_motion(plan) if leaves(joint, joint.axis, plan.fidelity.motion) else "")
    return "" if "" in found else max(found, default="")


def unless(models: Callable[[Mechanism], bool]) -> Callable[[Plan], str]:
    """Return a test by which a simplification is exact if `models` is false for all machines of the plan."""
    return lambda plan: "" if any(map(models, plan.machines)) else NONE


def guard_supports(plan: Plan) -> str:
    """Return the reason why leaving out supports leaves the motion unchanged, or "" if it may change the motion."""
    return "" if any(isinstance(order, Turn) for action in plan.actions for order in action.orders) else UNTURNED


def guard_motion(plan: Plan) -> str:
    """Return the reason why restricting motion to a plane leaves the motion unchanged, or "" if it may change it."""
    return MIRRORED if plan.fidelity.motion != "spatial" and _Mirror(plan).holds() else ""


def ordered(plan: Plan) -> set[str]:
    """Return the actuators that orders, user models or logs move; if a block is turned, all drives."""
    orders = [order for action in plan.actions for order in action.orders]
    moves = [order for order in orders if isinstance(order, Move)]
    found = {move.actuator for move in moves} | {kept.actuator for move in moves for kept in move.keeps}
    found |= {led.move.actuator for own in plan.models for led in own.leads} | {log.actuator for log in plan.driven}
    if any(isinstance(order, Turn) for order in orders):
        found |= {drive.name for machine in plan.machines for drive in machine.system.drives}
    return found


class _Mirror:
    """Test of a plan for mirror symmetry about the vertical plane of its motion through the first free body."""

    def __init__(self, plan: Plan) -> None:
        self.plan, self.motion, self.ordered = plan, plan.fidelity.motion, ordered(plan)
        self.normal = NORMAL[self.motion]
        self.i = self.normal.index(1.0)
        self.whole = merge([machine.system for machine in plan.machines], plan.gravity)

    @cached_property
    def frames(self) -> dict[str, tuple[list[list[float]], list[float]]]:
        """Rotation matrix and origin of each body at the start, by name of the body."""
        from heavylift.kernel.model.program import Program  # slow to import

        program = Program(self.whole)
        found = {WORLD: ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0, 0.0, 0.0])}
        for body in self.whole.bodies:
            R, p = program.poses_at_start(body.name)
            found[body.name] = R.astype(float).tolist(), p.astype(float).tolist()
        return found

    @cached_property
    def at(self) -> float:
        """Position of the mirror plane along its normal [m]."""
        free = {joint.child for joint in self.whole.joints if joint.kind == "free"}
        body = next((body for body in self.whole.bodies if body.name in free and body.mass), None)
        return self._place(body.name, body.com)[self.i] if body else 0.0

    def _place(self, body: str, p: Sequence[float]) -> list[float]:
        R, origin = self.frames[body]
        return [a + b for a, b in zip(origin, product(R, p), strict=True)]

    def holds(self) -> bool:
        """Return whether the lift and its orders are mirror-symmetric."""
        system = self.whole
        simple = not (system.contacts or system.reevings or self.plan.models or self.plan.lists)
        rigid = not (any(m.bends for m in self.plan.machines) and self.plan.fidelity.girder == "elastic")
        return (
            simple and rigid and all(map(self._joint, system.joints)) and all(map(self._body, system.bodies))
            and self._forces() and self._orders()
            and len(self.partners) == len(system.straight_ropes) + len(system.supports)
        )  # fmt: skip

    def _axis(self, joint: Joint) -> Vector:
        x, y, z = product(self.frames[joint.parent][0], product(joint.R_PJ, joint.axis))
        return x, y, z

    def _joint(self, joint: Joint) -> bool:
        """Return whether a joint moves only in the plane, or nothing moves it out of the plane."""
        if joint.kind not in SIMPLE or (joint.kind == "free" and any(joint.v0)):
            return False
        axis = self._axis(joint)
        along = abs(dot(axis, self.normal))
        square = joint.kind in ("free", "fixed") or along < ASKEW or along > 1.0 - ASKEW
        if not square or not leaves(joint, axis, self.motion):
            return square
        system, q = self.whole, joint.q0[0] if joint.q0 else 0.0
        ends = (stop.lower + stop.upper - 2.0 * q for stop in system.stops if stop.joint == joint.name)
        pulled = any(spring.k and spring.q_rest != q for spring in system.springs if spring.joint == joint.name)
        drives = (drive for drive in system.drives if drive.joint == joint.name)
        driven = any(drive.wave or drive.waves or drive.name in self.ordered for drive in drives)
        return not (any(joint.v0) or pulled or driven or any(abs(end) > ASKEW for end in ends))

    def _body(self, body: Body) -> bool:
        """Return whether a body is its own mirror image."""
        R = self.frames[body.name][0]
        normal = product([list(column) for column in zip(*R, strict=True)], self.normal)
        moved = product(body.inertia, normal)
        apart = max(abs(a - dot(moved, normal) * b) for a, b in zip(moved, normal, strict=True))
        placed = not body.mass or abs(self._place(body.name, body.com)[self.i] - self.at) < ASKEW
        return body.flexible is None and placed and apart <= SAME * max(map(abs, moved))

    def _forces(self) -> bool:
        """Return whether all forces act in the plane."""
        out = {joint.name for joint in self.whole.joints if leaves(joint, self._axis(joint), self.motion)}
        for force in self.whole.forces:
            if isinstance(force, Wind):
                place = self._place(force.at.body, force.at.p)[self.i]
                if abs(force.direction[self.i]) > ASKEW or abs(place - self.at) > ASKEW:
                    return False
            elif not force.along or force.along[0] in out:
                return False
        return True

    def _point(self, point: Point, sign: float) -> tuple[str, ...]:
        p = self._place(point.body, point.p)
        p[self.i] = sign * (p[self.i] - self.at)
        return (point.body, *(f"{round(x, DIGITS) + 0.0:.{DIGITS}f}" for x in p))

    def _keys(self, sign: float) -> dict[str, tuple[object, ...]]:
        """Return a comparison key for each rope and support, reflected if `sign` is -1: two of them with equal keys
        have the same effect."""
        found = dict[str, tuple[object, ...]]()
        for rope in self.whole.straight_ropes:
            lines = sorted((self._point(x.a, sign), self._point(x.b, sign), x.share) for x in rope.lines)
            own = (getattr(rope, key, None) for key in ("EA", "L0", "length", "damping", "hooked", "mass"))
            found[rope.name] = (*own, rope.name if rope.winch else "", *lines)
        for pad in self.whole.supports:
            found[pad.name] = (self._point(pad.point, sign), pad.height, pad.k, pad.d, pad.mu, pad.kt, pad.dt, pad.on)
        return found

    @cached_property
    def partners(self) -> dict[str, str]:
        """The mirror image (a rope or support) of each rope or support, by name."""
        images = {repr(key): name for name, key in self._keys(-1.0).items()}
        return {name: images[repr(key)] for name, key in self._keys(1.0).items() if repr(key) in images}

    def _orders(self) -> bool:
        """Return whether each sling is unhooked in the same action as its mirror image, and no order hooks a sling or
        turns the block out of the plane."""
        for action in self.plan.actions:
            off = {order.sling for order in action.orders if isinstance(order, UnhookSling)}
            hooks = any(isinstance(order, Hookup) for order in action.orders)
            turned = any(isinstance(order, Turn) for order in action.orders) and self.motion != "across"
            if hooks or turned or any(self.partners.get(sling) not in off for sling in off):
                return False
        return True
