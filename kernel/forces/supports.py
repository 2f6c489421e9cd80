"""Points on pads that are horizontal or lie on a body: one-sided spring-dampers with friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from heavylift.kernel.algebra.dense import dot, norm
from heavylift.kernel.algebra.spatial import cross
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, named, select
from heavylift.kernel.description.mechanics import Support

from .force_law import ForceLaw, LawOutput, Poses, SampledQuantity, Setting, attachment, wrench
from .friction import FAINT, GIVEN_WAY, JUST_BELOW, SLIP_BLEND, SLOWEST, deflection, friction, pushes


class SupportAt:
    """Places of a support's numbers, behind its point (3)."""

    HEIGHT, K, D, MU, KT, DT, CLOSED, STICK = range(3, 11)
    ANCHOR, DIRECTION = slice(11, 13), slice(13, 15)


@dataclass(frozen=True)
class SupportLaw(ForceLaw[Support]):
    """Arguments as of `Setting`; guards: whether it is closed, and whether friction holds."""

    clamped: bool = True
    at_rest: bool = False

    kind = "support"

    def within(self, f: Support, setting: Setting) -> SupportLaw:
        return SupportLaw(setting.clamped, setting.at_rest)

    def numbers(self, f: Support, poses: Poses) -> list[float]:
        return [*f.point.p, f.height, f.k, f.d, f.mu, f.kt, f.dt, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]

    def answer(self, f: Support, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar) -> LawOutput:
        height, k, d, mu, kt, dt, closed, stick = p[3:11]
        x, p_X, v_X = attachment(ends[0], p[:3], "a")
        if f.on:
            R, at = np.reshape(ends[1][:9], (3, 3)), p_X - ends[1][9:12]
            p_X = named("pX", R.T @ (at - ends[1][12:15]))
            v_X = named("vX", R.T @ (v_X - ends[1][18:21] - cross(ends[1][15:18], at)))
        N, guard, heat, stored = pushes(height - p_X[2], -v_X[2], k, d, closed, self.clamped)
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
            p[at.STICK], p[at.ANCHOR], p[at.DIRECTION] = 1.0, place, 0.0
            return "closed" if p[at.CLOSED] else "open", normal
        if p[at.STICK] > 0.0:
            held = p[at.KT] * (place - p[at.ANCHOR]) + p[at.DT] * velocity
            size = max(norm(held.tolist()), 1e-300)
            if dot(held.tolist(), velocity.tolist()) > SLOWEST * size or p[at.KT] == 0.0:
                p[at.STICK], p[at.DIRECTION] = 0.0, held / size
            else:  # the limit has fallen faster than the spring relaxes: it gives way and holds on
                part = GIVEN_WAY if size > FAINT * p[at.KT] else 0.0
                p[at.ANCHOR] = place - deflection(part * held, velocity, p[at.KT], p[at.DT])
            return "slip", normal
        late = dot(velocity.tolist(), p[at.DIRECTION].tolist()) + 0.5 * SLIP_BLEND  # by what steps may miss
        direction = velocity + (SLIP_BLEND - 2.0 * min(0.0, late)) * p[at.DIRECTION]
        force = JUST_BELOW * p[at.MU] * normal * direction / max(norm(direction.tolist()), 1e-300)
        p[at.STICK], p[at.ANCHOR] = 1.0, place - deflection(force, velocity, p[at.KT], p[at.DT])
        return "stick", normal

    def shows(self, f: Support) -> list[SampledQuantity]:
        groups = (("place", "m"), ("velocity", "m/s"))
        beside = [SampledQuantity("", f.name, unit, column) for column, unit in groups for _ in "xy"]
        return [SampledQuantity("support/force", f.name, "N", "normal"), *beside]
