"""Linear screening: by how much levels without lumps miss the swings along the path at rest, before anything is run.

The path is the one that was followed to check the scene, so nothing is compiled or followed once more. From action to
action, what is lifted is a pendulum below its hook ropes, led along the speed ramps of all moves. Of a rope of mass m
whose ends move at u and v, the kinetic energy is m (u2 + u v + v2) / 6; without lumps the product is left out
(`kernel.forces.ropes`). So frequencies are right, but a ramp drives a load of mass M only by M + m / 3 instead of
M + m / 2, and all that it swings is too little by that ratio. This bounds nothing, it shows at which level runs begin.
"""

from collections.abc import Iterator, Sequence
from math import copysign, dist, hypot, sqrt
from typing import NamedTuple

from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.profile import trapezoid
from heavylift.nodes.plan.actions import Action, Move
from heavylift.nodes.plan.fidelity import Fidelity, Question
from heavylift.nodes.plan.mechanism import Cargo
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.statics import Followed, StaticState, follow

from .figures import PART, SMALL
from .measuring import WITNESSED

CARRIES = 1.0  # [N] of a rope below which nothing hangs on it


class Ramp(NamedTuple):
    """A constant acceleration [m/s2] of the suspension point of a load, between two times [s]."""

    start: float
    end: float
    acceleration: float


class LedPendulum(NamedTuple):
    """State of a pendulum with a moving pivot: displacement [m], speed [m/s], angular frequency [rad/s]."""

    y: float = 0.0
    v: float = 0.0
    w: float = 0.0

    @property
    def amplitude(self) -> float:
        """Amplitude [m] of the free swing if the pivot no longer accelerates."""
        return hypot(self.y, self.v / self.w) if self.w else 0.0

    def led(self, ramps: Sequence[Ramp], w: float, start: float, end: float) -> "LedPendulum":
        """Return the pendulum's state at time `end` [s], after its pivot has moved with these accelerations since time
        `start` [s]."""
        if not w:
            return LedPendulum()
        c, s = cos(w * (end - start)), sin(w * (end - start))
        y, v = self.y * c + self.v / w * s, self.v * c - self.y * w * s
        for ramp in ramps:
            since, until = max(ramp.start, start), min(ramp.end, end)
            if since < until:
                first, last = w * (end - since), w * (end - until)
                y += ramp.acceleration * (cos(first) - cos(last)) / w**2
                v -= ramp.acceleration * (sin(first) - sin(last)) / w
        return LedPendulum(y, v, w)


def plausible(levels: Sequence[Fidelity], plan: Plan, question: Question) -> Sequence[Fidelity]:
    """Return the model levels whose estimated swing error is within the accuracy; all if none is, or if no swing is
    requested."""
    richer = [level for level in levels if level.ropes == "massive"]
    alike = len(richer) in (0, len(levels)) or not {"swing", "position"} & {*question.ask}
    return levels if alike or WITNESSED * swing_error(plan) <= question.accuracy else richer


def swing_error(plan: Plan) -> float:
    """Return an estimate of the largest relative error of swings due to massless ropes; 0 if no load swings below heavy
    ropes."""
    hung = any(row.line and not row.why and not row.lead for machine in plan.machines for row in machine.heavy)
    if plan.lists or not hung or not any(_moves(plan, action) for action in plan.actions):
        return 0.0  # lifts side by side have paths of their own
    if not (path := follow(plan)).states:
        return 0.0
    return max((_error(plan, path, cargo) for machine in plan.machines for cargo in machine.cargo), default=0.0)


def _error(plan: Plan, path: Followed, cargo: Cargo) -> float:
    places = [state.poses[cargo.body][0] for state in (*(x.before for x in path.acted), path.states[-1])]
    way = max((dist(a, b) for a in places for b in places), default=0.0)
    hung = [dist(*hook.ends) for machine in plan.machines for hook in machine.hooks if hook.ends]
    ramps, landed = _ramps(plan, path, cargo.body), [state.t for state in path.states if state.grounded]
    swing, begun, found, amplitudes = LedPendulum(), 0.0, [0.0], list[tuple[float, float]]()
    for t, state in _ends(path):
        w, missed = _pendulum(plan, state, cargo)
        if stood := [x for x in landed if begun < x <= t]:  # what stands swings no more
            swing, begun = LedPendulum(), stood[-1]
        swing, begun = swing.led(ramps, w, begun, t), t
        amplitudes.append((swing.amplitude, missed))
        found.append(missed * abs(swing.y) / way if way else 0.0)
    swung = max([SMALL * min(hung, default=0.0), *(PART * a for a, _ in amplitudes)])
    return max(*found, *(missed * a / max(a, swung) for a, missed in amplitudes if a))


def _ends(path: Followed) -> Iterator[tuple[float, StaticState]]:
    """Yield the time [s] and the state at the end of each action."""
    yield from ((x.t, x.before) for x in path.acted[1:])
    yield path.states[-1].t, path.states[-1]


def _moves(plan: Plan, action: Action) -> list[Move]:
    """Return the moves of an action that may lead a load sideways, without those whose ramps leave no swing."""
    winches = {hook.rope for machine in plan.machines for hook in machine.hooks}
    moves = (order for order in action.orders if isinstance(order, Move))
    return [move for move in moves if move.actuator not in winches and not move.pulses]


def _ramps(plan: Plan, path: Followed, body: str) -> list[Ramp]:
    """Return the accelerations of what a body hangs from in all moves; a drive moves it level by as much as the body is
    moved at rest."""
    found = list[Ramp]()
    for action, begun, (end, after) in zip(plan.actions, path.acted, _ends(path), strict=False):
        (x, y, _), (u, v, _) = (state.poses[body][0] for state in (begun.before, after))
        moves = _moves(plan, action)
        for move in moves:
            by = after.references.get(move.actuator, 0.0) - begun.before.references.get(move.actuator, 0.0)
            if not by:
                continue
            level, t = hypot(u - x, v - y) / by / len(moves), begun.t
            if move.by is not None or move.to is not None:
                p = trapezoid(by, abs(move.speed), move.accel)
                stops = t + p.d1 + p.cruise
                pieces = [Ramp(t, t + p.d1, p.a1), Ramp(stops, stops + p.d2, p.a2)]
            else:
                lasts, a = abs(move.speed) / move.accel, copysign(move.accel, by)
                pieces = [Ramp(t, t + lasts, a), Ramp(end, end + lasts, -a)]
            found += [ramp._replace(acceleration=level * ramp.acceleration) for ramp in pieces]
    return found


def _pendulum(plan: Plan, state: StaticState, cargo: Cargo) -> tuple[float, float]:
    """Return the angular frequency [rad/s] of a load below its hook ropes, and by which part its swings are too small
    without lumps; (0, 0) if no hook carries it."""
    (_, _, z), R = state.poses[cargo.body]
    com = z + sum(r * p for r, p in zip(R[2], cargo.com, strict=True))
    top, mass, ropes = com, 0.0, 0.0
    for machine in plan.machines:
        # a rope that goes on to a drum has one lump in the middle of its falls, which drives the load as it should
        lines = {row.rope: row.line for row in machine.heavy if not row.why and not row.lead}
        for hook in machine.hooks:
            if (tension := state.tensions.get(hook.rope, 0.0)) > CARRIES and hook.ends:
                top = max(top, hook.ends[0][2])
                mass += tension / plan.gravity
                ropes += lines.get(hook.rope, 0.0) * state.references[hook.rope]
    if not mass or top <= com:
        return 0.0, 0.0
    return sqrt(plan.gravity / (top - com)), ropes / 6.0 / (mass + ropes / 2.0)
