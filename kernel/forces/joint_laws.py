"""Laws along one coordinate of a joint: springs, end stops, dry brakes."""

from dataclasses import dataclass

import numpy as np
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, select
from heavylift.kernel.description.mechanics import Brake, JointSpring, Stop

from .force_law import ForceLaw, LawOutput, Poses, SampledQuantity, Setting
from .friction import JUST_BELOW, deflection, friction, pushes


class JointSpringLaw(ForceLaw[JointSpring]):
    """Linear spring and damper."""

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
    """Places of an end stop's numbers."""

    LOWER, UPPER, K, D, AT_LOWER, AT_UPPER = range(6)


@dataclass(frozen=True)
class StopLaw(ForceLaw[Stop]):
    """One-sided spring-dampers beyond both limits; `clamped` as of `Setting`."""

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
    """Places of a brake's numbers."""

    MOMENT, K, D, ENGAGED, STICK, ANCHOR, DIRECTION = range(7)


@dataclass(frozen=True)
class BrakeLaw(ForceLaw[Brake]):
    """Dry friction; `start`: its initial coordinate; `at_rest` as of `Setting`."""

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
