"""Mooring lines: an elastic catenary between an anchor and a fairlead, with a level seabed; a line can break.

Whether a part of the line lies is a discrete state, so no formula changes inside a step; the events are located in
time, as is the breaking of a line. A slack line keeps a horizontal force of 2e-7 of its vertical one. The energy
consists of strain energy and potential energy in water.
"""

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, maximum, minimum, named, select, sqrt
from heavylift.kernel.description.forces import MooringLine
from heavylift.kernel.description.mechanics import WORLD

from .catenary import hanging, line_shape, lying
from .force_law import ForceLaw, LawBreakdown, LawOutput, Poses, SampledQuantity, Setting, attachment, wrench

CLOSED = 1e-7  # of its length, by which the ends of a line may be missed before the last step of the iteration
TINY = 1e-160  # keeps 0/0 away


class LineAt:
    """Indices into the parameters of a mooring or tugger line.

    `HOOKED`: 0 if it has broken or is released, `HANGS`: 1 if no part of a mooring line lies on the seabed.
    """

    HOOKED, HANGS = range(6, 8)


@dataclass(frozen=True)
class MooringLaw(ForceLaw[MooringLine]):
    """Force law of a mooring line, an elastic catenary that is in equilibrium at each instant."""

    gravity: float = 0.0

    def within(self, f: MooringLine, setting: Setting) -> "MooringLaw":
        self.demand(f, "mass", setting.gravity > 0.0, "needs gravity; a line without weight is a spring")
        return MooringLaw(setting.gravity)

    def check(self, f: MooringLine) -> None:
        grounded = f.a.body == WORLD or not f.seabed
        self.demand(f, "a", grounded, f"is on '{f.a.body}'; an anchor on the seabed is fixed in the world")

    def shape(self, f: MooringLine) -> Hashable:
        return f.seabed, f.breaking > 0.0

    def numbers(self, f: MooringLine, poses: Poses) -> list[float]:
        w, a, b = f.mass * self.gravity, *(R @ np.array(end.p) + p for end in (f.a, f.b) for R, p in (poses(end.body),))
        x, y, z = ((b - a) / f.length).tolist()
        weight, apart = w * f.length, "fits no catenary: its ends are above each other, or too far apart"
        self.demand(f, "length", bool(x or y), apart)
        start = line_shape(sqrt(x * x + y * y), z, 0.5 * weight / f.EA, f.seabed, 1)[0]
        most = weight * sqrt(start.H * start.H + start.V * start.V)
        begins = f"is {f.breaking / 1e3:.5g} kN, and the line begins with {most / 1e3:.5g} kN"
        self.demand(f, "breaking", not 0.0 < f.breaking <= most, begins)
        self.demand(f, "length", bool(start.missed < CLOSED), apart)
        given = [f.length, f.EA, w, f.friction, f.breaking]
        return [*f.a.p, *f.b.p, float(f.hooked), float(not f.seabed), *given]

    def answer(
        self, f: MooringLine, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar
    ) -> LawOutput:
        (x_a, p_a, _), (x_b, p_b, _) = attachment(ends[0], p[:3], "a"), attachment(ends[1], p[3:6], "b")
        on, hangs, L, EA, w, friction, breaking = p[LineAt.HOOKED :]
        s, on, hangs = p_b - p_a, on > 0.0, hangs > 0.0
        weight, far = w * L, sqrt(s[0] * s[0] + s[1] * s[1] + TINY)
        x, z, k = far / L, s[2] / L, 0.5 * weight / EA
        found = hanging(x, z, k)
        if f.seabed:
            other = lying(x, z, k)
            found = type(found)(*(select(hangs, a, b) for a, b in zip(found, other, strict=True)))
        H, V = named("H", weight * found.H), named("V", weight * found.V)
        V_a = select(hangs, V - weight, 0.0) if f.seabed else V - weight
        H_a = maximum(H - friction * (weight - V), 0.0) if f.seabed else H
        if f.seabed:
            H_a = select(hangs, H, H_a)
        T, T_a = sqrt(H * H + V * V), sqrt(H * H + V_a * V_a)
        # strain, then height over the anchor, of the part that hangs: integrals over V from V_a to V
        cubes, part = (V * V * V - V_a * V_a * V_a) * (1.0 / 3.0), V - V_a
        strain = (H * H * L + cubes / w) / (2.0 * EA)
        bent = 0.5 * (V * T - V_a * T_a + H * H * found.turn) - T_a * part
        height = (bent + (cubes - V_a * V_a * part) / (2.0 * EA)) / w + weight * p_a[2]
        u = np.array([s[0] / far, s[1] / far, 0.0])
        up = np.array([0.0, 0.0, 1.0])
        pull_a, pull_b = H_a * u + V_a * up, -(H * u + V * up)
        solved = CLOSED - found.missed
        guards = [select(hangs, V - weight, weight - V)] if f.seabed else []
        guards += [select(on, breaking - T, 1.0)] if f.breaking > 0.0 else []
        guards += [select(on, minimum(solved, s[2]) if f.seabed else solved, 1.0)]
        return LawOutput(
            [wrench(x_a, _only(on, pull_a)), wrench(x_b, _only(on, pull_b))],
            stored=select(on, strain + height, 0.0),
            guards=guards,
            shown=[select(on, y, 0.0) for y in (T, sqrt(H_a * H_a + V_a * V_a), H, V)],
        )

    def guards(self, f: MooringLine) -> tuple[str, ...]:
        return (*(("seabed",) if f.seabed else ()), *(("breaking",) if f.breaking > 0.0 else ()), "solved")

    def switch(self, f: MooringLine, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        if guard == "solved":
            why = "its fairlead is at or below the seabed, or its ends are too far apart: the catenary is not solved"
            raise LawBreakdown(f"mooring line '{f.name}'", why)
        if guard == "breaking":
            p[LineAt.HOOKED] = 0.0
            return "parted", float(shown[0])
        p[LineAt.HANGS] = 1.0 - p[LineAt.HANGS]
        return ("uplift" if p[LineAt.HANGS] else "grounded"), float(shown[0])

    def shows(self, f: MooringLine) -> list[SampledQuantity]:
        # a line is a rope whose parts are at the fairlead and at the anchor
        tensions = [SampledQuantity("reeving/tension", f"{f.name}.{i}", "N") for i in (1, 2)]
        return tensions + [SampledQuantity("mooring/force", f"{f.name}.{part}", "N") for part in ("H", "V")]


def _only(on: Scalar, x: Array) -> Array:
    return np.array([select(on, y, 0.0) for y in x] + [None], dtype=object)[:-1]
