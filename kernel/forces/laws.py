"""Force laws: what ropes, supports, stops, brakes and drives do between events.

Discrete states (hooked, taut, closed, stick) are numbers that stay frozen during a step; every law returns *guards*,
scalars that are positive while the discrete states hold and whose fall below zero is a located event.
So no clamp ever acts inside a step, and the integrators keep their order.  (`clamped`: the part of a step that lies
behind an event, and is thrown away, sees the one-sided law; the dense output before the event suffers from the kink.)
Each law also returns the power that it turns into heat or takes from a motor: the energy balance integrates those.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from heavylift.kernel.algebra.spatial import cross, join
from heavylift.kernel.compiler.symbol import maximum, minimum, named, select, sqrt

from .rope_mass import at_the_hook, not_weighed, pulls_down

__all__ = ["BODY", "attachment", "brake", "drive", "profile", "rope", "stop", "support"]

BODY = 21  # numbers that describe a body to a law: R, o, r, V, see `attachment`
ROUND_OFF = 1e-12  # [m] deflection of a friction spring that round-off in places far from the origin can feign
RELAXED = 1.0 - 1e-5  # of its limit, below which friction at rest holds: more than rounding of poses changes it
SLIP_BLEND = 1e-6  # [m/s] below this speed the direction of sliding friction is that of the slip's start


def attachment(body: Any, p_BX: Any, label: str = "X") -> tuple[Any, Any, Any]:
    """Place from the tree's point, place in the world, velocity of a body-fixed point X.

    body: (21,) R_WB row-major, the tree's point o, r from o to the body's origin, twist V; label: its name in print.
    """
    R, o, r, V = np.reshape(body[:9], (3, 3)), body[9:12], body[12:15], body[15:21]
    x = named(f"r{label}", r + R @ p_BX)
    return x, named(f"p{label}", x + o), named(f"v{label}", V[3:] + cross(V[:3], x))


def profile(t: Any, inside: Any, p: Any) -> tuple[Any, Any, Any]:
    """Reference, its rate and acceleration; p = (start, x0, v0, a1, d1, cruise, a2, d2), see `kernel.profile`.

    The acceleration jumps where two pieces meet; `inside`, a time within the present step, says which piece is meant.
    """
    start, x0, v0, a1, d1, cruise, a2, d2 = p

    def ramp(s: Any, among: Any, d: Any) -> tuple[Any, Any, Any]:
        c = minimum(maximum(s, 0.0), d)
        on = select(among > 0.0, select(d > among, 1.0, 0.0), 0.0)
        return c * (maximum(s, 0.0) - 0.5 * c), c, on

    s, among = t - start, inside - start
    x1, c1, b1 = ramp(s, among, d1)
    x2, c2, b2 = ramp(s - d1 - cruise, among - d1 - cruise, d2)
    return x0 + v0 * maximum(s, 0.0) + a1 * x1 + a2 * x2, v0 + a1 * c1 + a2 * c2, a1 * b1 + a2 * b2


def rope(
    p: Any,
    L0: Any,
    dL0: Any,
    bodies: list[tuple[Any, Any]],
    clamped: bool = True,
    calm: bool = False,
    heavy: bool = False,
) -> SimpleNamespace:
    """Tension-only elastic rope over straight lines, with winch.

    p = (EA, damping, hooked, taut, then per line a(3), b(3), share); bodies: per line the two end bodies (21,).
    Taut: T = max(0, EA e/L0 + c (l' - L0')).  Guards: slack -> taut when e rises through 0; taut -> slack when the
    tension falls through 0.  Winch power -T L0' - (EA strain^2/2) L0': the second term is strain energy wound
    onto the drum.  wrenches: per line the (6,) on its end bodies about their trees' points.
    `heavy`: p ends with the rope's own weight, see `rope_mass`; the tension that is told is that at the ends b.
    `calm`: no events; damping, at most as large as the elastic part, acts while e > 0, so that nothing jumps at e = 0.
    """
    EA, c, hooked, taut = p[:4]
    length, rate, high, ends = 0.0, 0.0, 0.0, []
    for n, (A, B) in enumerate(bodies):
        q = p[4 + 7 * n : 11 + 7 * n]
        (x_a, p_a, v_a), (x_b, p_b, v_b) = (
            attachment(A, q[:3], f"a{n + 1}"),
            attachment(B, q[3:6], f"b{n + 1}"),
        )
        d = named(f"d{n + 1}", p_b - p_a)
        l = named(f"l{n + 1}", sqrt(d @ d))
        u = named(f"u{n + 1}", d * (1.0 / l))
        length, rate = length + q[6] * l, rate + q[6] * (u @ (v_b - v_a))
        ends.append((x_a, x_b, q[6] * u))
        if heavy:
            high = high + q[6] * (p_a[2] + p_b[2])
    length, rate = named("l", length), named("dl", rate)
    e, de = length - L0, rate - dL0
    strain = e * (1.0 / L0)
    if calm:
        strain = maximum(strain, 0.0)
        held = EA * strain
        damped = minimum(maximum(c * de, -held), held)
    else:
        held, damped = EA * strain, c * de
    trial = held + damped
    on = select(taut > 0.0, hooked, 0.0)
    tension = named("T", select(on > 0.0, one_sided(trial, clamped), 0.0))
    wrenches = []
    for n, (x_a, x_b, u) in enumerate(ends):
        f = named(f"f{n + 1}", tension * u)
        wrenches.append((join(cross(x_a, f), f), -join(cross(x_b, f), f)))
    wound = select(on > 0.0, 0.5 * EA * strain * strain, 0.0)
    stored, told = wound * L0, tension
    if heavy:
        weight = p[-1]
        shares = [p[10 + 7 * n] * weight for n in range(len(bodies))]
        wrenches = [
            (wa + pulls_down(w, x_a), wb + pulls_down(w, x_b))
            for (wa, wb), (x_a, x_b, _), w in zip(wrenches, ends, shares, strict=True)
        ]
        stored, told = stored + not_weighed(weight) * high, at_the_hook(tension, weight)
    return SimpleNamespace(
        tension=told,
        elongation=e,
        length=length,
        wrenches=wrenches,
        guard=1.0 if calm else select(hooked > 0.0, select(taut > 0.0, trial, -minimum(e, trial)), 1.0),
        heat=select(on > 0.0, damped * de, 0.0),
        work=-(tension + wound) * dL0,
        stored=stored,
    )


def one_sided(force: Any, clamped: bool) -> Any:
    """max(0, force), or the force as it is: a step that ends behind an event sees a smooth law and is then cut."""
    return maximum(force, 0.0) if clamped else force


def _unilateral(depth: Any, rate: Any, k: Any, d: Any, closed: Any, clamped: bool) -> tuple[Any, Any, Any, Any]:
    """Force, guard, heat and stored energy of a one-sided spring-damper."""
    trial = k * depth + d * rate
    on = closed > 0.0
    return (
        select(on, one_sided(trial, clamped), 0.0),
        select(on, trial, -minimum(depth, trial)),
        select(on, d * rate * rate, 0.0),
        select(on, 0.5 * k * depth * depth, 0.0),
    )


def _friction(
    s: Any, v: Any, limit: Any, k: Any, d: Any, stick: Any, direction: Any, at_rest: bool
) -> tuple[Any, Any, Any, Any]:
    """(n,) dry friction: a spring-damper from its anchor (s from it) that slips at `limit`.

    Slipping, the force has the size of the limit and opposes the velocity; `direction` (n,) is that of the start of
    the slip, and the slip ends when the velocity along it falls through zero.  Where only rests are looked for, the
    direction is that of the spring, whose anchor gives way (radial return; Simo, Hughes 1998, 1.4), and the slip ends
    when the spring relaxes.
    """
    held = k * s + d * v
    size = sqrt(held @ held + 1e-300)
    u = held if at_rest else v + SLIP_BLEND * direction
    u = u * (1.0 / sqrt(u @ u + 1e-300))
    on = stick > 0.0
    force = np.array([-select(on, h, limit * w) for h, w in zip(held, u, strict=True)])
    return (
        force,
        select(on, limit + k * ROUND_OFF - size, size - RELAXED * limit if at_rest else direction @ v),
        select(on, d * (v @ v), limit * (u @ v)),
        select(on, 0.5 * k * (s @ s), 0.0),
    )


def support(p: Any, body: Any, clamped: bool = True, at_rest: bool = False) -> SimpleNamespace:
    """Point on a horizontal pad; p = (point(3), height, k, d, mu, kt, dt, closed, stick, anchor(2), direction(2))."""
    height, k, d, mu, kt, dt, closed, stick = p[3:11]
    x, p_X, v_X = attachment(body, p[:3], "a")
    N, guard, heat, stored = _unilateral(height - p_X[2], -v_X[2], k, d, closed, clamped)
    N = named("N", N)
    rub, slips, rubbed, held = _friction(p_X[:2] - p[11:13], v_X[:2], mu * N, kt, dt, stick, p[13:15], at_rest)
    on = select(mu > 0.0, closed, 0.0) > 0.0  # a pad without friction never sticks
    f = named("f", np.array([select(on, rub[0], 0.0), select(on, rub[1], 0.0), N]))
    return SimpleNamespace(
        normal=N,
        tangential=f[:2],
        wrench=join(cross(x, f), f),
        guards=[guard, select(on, slips, 1.0)],
        heat=heat + select(on, rubbed, 0.0),
        stored=stored + select(on, held, 0.0),
        place=p_X[:2],
        velocity=v_X[:2],
    )


def stop(p: Any, q: Any, v: Any, clamped: bool = True) -> SimpleNamespace:
    """End stops of a joint; p = (lower, upper, k, d, closed at lower, closed at upper)."""
    lower, upper, k, d, at_lower, at_upper = p
    low, guard_low, heat_low, stored_low = _unilateral(lower - q, -v, k, d, at_lower, clamped)
    up, guard_up, heat_up, stored_up = _unilateral(q - upper, v, k, d, at_upper, clamped)
    return SimpleNamespace(
        force=low - up, guards=[guard_low, guard_up], heat=heat_low + heat_up, stored=stored_low + stored_up
    )


def brake(p: Any, q: Any, v: Any, at_rest: bool = False) -> SimpleNamespace:
    """Dry brake of a joint; p = (moment, k, d, engaged, stick, anchor, direction)."""
    moment, k, d, engaged, stick, anchor, direction = p
    force, guard, heat, stored = _friction(
        np.array([q - anchor]), np.array([v]), moment, k, d, stick, np.array([direction]), at_rest
    )
    on = engaged > 0.0
    return SimpleNamespace(
        force=select(on, force[0], 0.0),
        guards=[select(on, guard, 1.0)],
        heat=select(on, heat, 0.0),
        stored=select(on, stored, 0.0),
    )


def drive(kind: str, p: Any, reference: tuple[Any, Any, Any], q: Any, v: Any) -> Any:
    """Force of a servo or speed drive towards its reference (a prescribed joint needs none); p = (kp, kv)."""
    ref, dref, _ = reference
    if kind == "servo":
        return p[0] * (ref - q) + p[1] * (dref - v)
    return p[1] * (dref - v)
