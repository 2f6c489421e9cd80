"""Force laws along one coordinate of a joint (springs, end stops, dry brakes), and of points on pads, horizontal or on
a body.

Joint laws and pads share one-sided springs, which only push, and friction that sticks and slips.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from heavylift.kernel.algebra.dense import dot, norm
from heavylift.kernel.algebra.spatial import cross
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, maximum, minimum, named, select, sqrt
from heavylift.kernel.description.mechanics import Brake, JointSpring, Stop, Support

from .force_law import ForceLaw, LawOutput, Poses, SampledQuantity, Setting, attachment, wrench

ROUND_OFF = 1e-12  # [m] deflection of a friction spring that round-off in places far from the origin can feign
RELAXED = 1.0 - 1e-5  # of its limit, below which friction at rest holds: more than rounding of poses changes it
SLIP_BLEND = 1e-6  # [m/s] below this speed the direction of sliding friction is that of the slip's start
JUST_BELOW = 1.0 - 1e-9  # part of the limit that a spring holds which begins to stick, so that it does not slip at once
SLOWEST = 1e-3 * SLIP_BLEND  # of a slip: below, the blend makes its direction, by turns of slip and stick
GIVEN_WAY = 0.5  # part that it holds after the limit has fallen below it
FAINT = 1e-6  # [m] deflection from which it then gives way wholly: halves of halves have no end as a pad is left


class FrictionForce(NamedTuple):
    """Result of a friction law: force, guard, heat [W] and stored energy [J]."""

    force: Any
    guard: Scalar
    heat: Scalar
    stored: Scalar


def one_sided(force: Scalar, clamped: bool) -> Scalar:
    """Return the force of a one-sided law: max(0, force) if `clamped`, otherwise the force itself.

    Unclamped, a step beyond an event sees a smooth law and is cut at the event. With clamping, the kink disturbs the
    dense output before the event.
    """
    return maximum(force, 0.0) if clamped else force


def pushes(depth: Scalar, rate: Scalar, k: Scalar, d: Scalar, closed: Scalar, clamped: bool) -> FrictionForce:
    """Return force, guard, heat and stored energy of a spring-damper that pushes only."""
    trial = k * depth + d * rate
    on = closed > 0.0
    return FrictionForce(
        select(on, one_sided(trial, clamped), 0.0),
        # closed: the force itself is the guard; open: both depth and force must be positive before it closes
        select(on, trial, -minimum(depth, trial)),
        select(on, d * rate * rate, 0.0),
        select(on, 0.5 * k * depth * depth, 0.0),
    )


def friction(
    s: Array, v: Array, limit: Scalar, k: Scalar, d: Scalar, stick: Scalar, direction: Array, at_rest: bool
) -> FrictionForce:
    """Return the dry friction force (n,) of a spring-damper at distance s from its anchor, which slips at `limit`.

    While slipping, the force has the size of the limit and opposes the velocity; `direction` (n,) is the direction in
    which the slip began, and the slip ends when the velocity along it becomes negative. If `at_rest`, the direction is
    that of the spring, whose anchor follows (radial return; Simo, Hughes 1998, 1.4), and the slip ends when the spring
    relaxes.
    """
    held = k * s + d * v
    # 1e-300 keeps the root differentiable at rest; it vanishes beside any real force
    size = sqrt(held @ held + 1e-300)
    # at small speeds the direction of slip is that in which it began, so that friction does not flip by round-off
    u = held if at_rest else v + SLIP_BLEND * direction
    u = u * (1.0 / sqrt(u @ u + 1e-300))
    on = stick > 0.0
    return FrictionForce(
        np.array([-select(on, h, limit * w) for h, w in zip(held, u, strict=True)]),
        # ROUND_OFF: places far from the origin are rounded, which a stiff spring would read as a force
        select(on, limit + k * ROUND_OFF - size, size - RELAXED * limit if at_rest else direction @ v),
        select(on, d * (v @ v), limit * (u @ v)),
        select(on, 0.5 * k * (s @ s), 0.0),
    )


def deflection(force: Any, velocity: Any, k: float, d: float) -> Any:
    """Return the deflection at which a friction spring holds a given force; zero for a spring without stiffness."""
    return (force - d * velocity) / k if k > 0.0 else 0.0 * force


class SupportAt:
    """Indices into the parameters of a support, after the coordinates (3) of its point."""

    HEIGHT, K, D, MU, KT, DT, CLOSED, STICK = range(3, 11)
    ANCHOR, DIRECTION = slice(11, 13), slice(13, 15)
    EDGES = slice(15, 17)  # halves of the size of a pad that has ends; else empty


@dataclass(frozen=True)
class SupportLaw(ForceLaw[Support]):
    """Force law of a support; guards: normal force of a closed contact, reserve of friction.

    Arguments as in `Setting`.
    """

    clamped: bool = True
    at_rest: bool = False

    kind = "support"

    def within(self, f: Support, setting: Setting) -> "SupportLaw":
        return SupportLaw(setting.clamped, setting.at_rest)

    def numbers(self, f: Support, poses: Poses) -> list[float]:
        return [
            *f.point.p,
            f.height,
            f.k,
            f.d,
            f.mu,
            f.kt,
            f.dt,
            0.0,
            1.0,
            0.0,
            0.0,
            0.0,
            0.0,
            *(x / 2 for x in f.size or ()),
        ]

    def answer(self, f: Support, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        height, k, d, mu, kt, dt, closed, stick = p[3:11]
        x, p_X, v_X = attachment(ends[0], p[:3], "a")
        if f.on:
            # pad on a body: position and velocity in the axes of that body
            R, at = np.reshape(ends[1][:9], (3, 3)), p_X - ends[1][9:12]
            p_X = named("pX", R.T @ (at - ends[1][12:15]))
            v_X = named("vX", R.T @ (v_X - ends[1][18:21] - cross(ends[1][15:18], at)))
        N, guard, heat, stored = pushes(height - p_X[2], -v_X[2], k, d, closed, self.clamped)
        for half, w in zip(p[SupportAt.EDGES], p_X[:2], strict=False):
            left = k * (half - abs(w))  # to the edge, beyond which the pad is open
            guard = select(closed > 0.0, minimum(guard, left), maximum(guard, -left))
        N = named("N", N)
        anchor, direction = p[SupportAt.ANCHOR], p[SupportAt.DIRECTION]
        rub, slips, rubbed, held = friction(p_X[:2] - anchor, v_X[:2], mu * N, kt, dt, stick, direction, self.at_rest)
        on = select(mu > 0.0, closed, 0.0) > 0.0  # a pad without friction never sticks
        f_X = named("f", np.array([select(on, rub[0], 0.0), select(on, rub[1], 0.0), N]))
        f_X = R @ f_X if f.on else f_X
        return LawOutput(
            [wrench(x, f_X), *([-wrench(at, f_X)] if f.on else [])],
            heat=heat + select(on, rubbed, 0.0),
            stored=stored + select(on, held, 0.0),
            guards=[guard, select(on, slips, 1.0)],
            shown=[N, *p_X[:2], *v_X[:2]],
        )

    def guards(self, f: Support) -> tuple[str, ...]:
        return "support", "rub"

    def switch(self, f: Support, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        at, normal, place, velocity = SupportAt, float(shown[0]), shown[1:3], shown[3:5]
        if guard == "support":
            p[at.CLOSED] = 1.0 - p[at.CLOSED]
            # a pad that closes or opens begins to stick where it is
            p[at.STICK], p[at.ANCHOR], p[at.DIRECTION] = 1.0, place, 0.0
            return "closed" if p[at.CLOSED] else "open", normal
        if p[at.STICK] > 0.0:
            # the force at the limit, including the damper: its direction is that of the slip
            held = p[at.KT] * (place - p[at.ANCHOR]) + p[at.DT] * velocity
            size = max(norm(held.tolist()), 1e-300)
            # slipping against the spring would be no slip: only a falling limit has been reached
            if dot(held.tolist(), velocity.tolist()) > SLOWEST * size or p[at.KT] == 0.0:
                p[at.STICK], p[at.DIRECTION] = 0.0, held / size
            else:  # the limit has fallen faster than the spring relaxes: it gives way and holds on
                part = GIVEN_WAY if size > FAINT * p[at.KT] else 0.0
                p[at.ANCHOR] = place - deflection(part * held, velocity, p[at.KT], p[at.DT])
            return "slip", normal
        # the step to the event may pass the reversal by a little: correct the direction by that
        late = dot(velocity.tolist(), p[at.DIRECTION].tolist()) + 0.5 * SLIP_BLEND  # by what steps may miss
        direction = velocity + (SLIP_BLEND - 2.0 * min(0.0, late)) * p[at.DIRECTION]
        # just below the limit, or the next evaluation would slip again
        force = JUST_BELOW * p[at.MU] * normal * direction / max(norm(direction.tolist()), 1e-300)
        p[at.STICK], p[at.ANCHOR] = 1.0, place - deflection(force, velocity, p[at.KT], p[at.DT])
        return "stick", normal

    def shows(self, f: Support) -> list[SampledQuantity]:
        groups = (("place", "m"), ("velocity", "m/s"))
        other = [SampledQuantity("", f.name, unit, column) for column, unit in groups for _ in "xy"]
        return [SampledQuantity("support/force", f.name, "N", "normal"), *other]


class JointSpringLaw(ForceLaw[JointSpring]):
    """Force law of a linear spring and damper on a joint coordinate."""

    kind = "spring"

    def numbers(self, f: JointSpring, poses: Poses) -> list[float]:
        return [f.k, f.d, f.q_rest]

    def answer(
        self, f: JointSpring, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar
    ) -> LawOutput:
        k, d, rest = p
        q, v = joint
        return LawOutput(effort=k * (rest - q) - d * v, heat=d * v * v, stored=0.5 * k * (rest - q) * (rest - q))


class StopAt:
    """Indices into the parameters of an end stop."""

    LOWER, UPPER, K, D, AT_LOWER, AT_UPPER = range(6)


@dataclass(frozen=True)
class StopLaw(ForceLaw[Stop]):
    """Force law of end stops: one-sided spring-dampers beyond both limits of a joint coordinate."""

    clamped: bool = True

    kind = "stop"

    def within(self, f: Stop, setting: Setting) -> "StopLaw":
        return StopLaw(setting.clamped)

    def numbers(self, f: Stop, poses: Poses) -> list[float]:
        return [f.lower, f.upper, f.k, f.d, 0.0, 0.0]

    def answer(self, f: Stop, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        lower, upper, k, d, at_lower, at_upper = p
        q, v = joint
        low = pushes(lower - q, -v, k, d, at_lower, self.clamped)
        up = pushes(q - upper, v, k, d, at_upper, self.clamped)
        return LawOutput(
            effort=low.force - up.force,
            heat=low.heat + up.heat,
            stored=low.stored + up.stored,
            guards=[low.guard, up.guard],
        )

    def guards(self, f: Stop) -> tuple[str, ...]:
        return "lower", "upper"

    def switch(self, f: Stop, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        at = StopAt
        side, limit = (at.AT_LOWER, at.LOWER) if guard == "lower" else (at.AT_UPPER, at.UPPER)
        p[side] = 1.0 - p[side]
        return "closed" if p[side] else "open", float(p[limit])


class BrakeAt:
    """Indices into the parameters of a brake."""

    MOMENT, K, D, ENGAGED, STICK, ANCHOR, DIRECTION = range(7)


@dataclass(frozen=True)
class BrakeLaw(ForceLaw[Brake]):
    """Force law of a brake with dry friction on a joint coordinate; `start`: initial value of the coordinate."""

    start: float = 0.0
    at_rest: bool = False

    kind = "brake"
    initial = False

    def within(self, f: Brake, setting: Setting) -> "BrakeLaw":
        place, _ = setting.graph.coordinate(f.name, *f.along)
        return BrakeLaw(setting.graph.q0[place], setting.at_rest)

    def numbers(self, f: Brake, poses: Poses) -> list[float]:
        return [f.moment, f.k, f.d, float(f.engaged), 1.0, self.start, 0.0]

    def answer(self, f: Brake, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        moment, k, d, engaged, stick, anchor, direction = p
        q, v = joint
        x = friction(np.array([q - anchor]), np.array([v]), moment, k, d, stick, np.array([direction]), self.at_rest)
        on = engaged > 0.0
        return LawOutput(
            effort=select(on, x.force[0], 0.0),
            heat=select(on, x.heat, 0.0),
            stored=select(on, x.stored, 0.0),
            guards=[select(on, x.guard, 1.0)],
            shown=[q, v],
        )

    def guards(self, f: Brake) -> tuple[str, ...]:
        return ("brake",)

    def switch(self, f: Brake, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        at, (q, v) = BrakeAt, map(float, shown)
        if p[at.STICK] > 0.0:
            held = p[at.K] * (q - p[at.ANCHOR]) + p[at.D] * v
            # a joint has two directions only
            p[at.STICK], p[at.DIRECTION] = 0.0, np.sign(held)
            return "slip", v
        force = JUST_BELOW * p[at.MOMENT] * p[at.DIRECTION]
        p[at.STICK], p[at.ANCHOR] = 1.0, q - deflection(force, v, p[at.K], p[at.D])
        return "stick", q

    def shows(self, f: Brake) -> list[SampledQuantity]:
        return [
            SampledQuantity("", f.name, "m or rad", "place"),
            SampledQuantity("", f.name, "m/s or rad/s", "velocity"),
        ]
