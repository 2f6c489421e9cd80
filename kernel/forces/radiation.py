"""Radiation of waves by a floating body, with memory: Cummins' equation in passive states.

Cummins, The impulse response function and ship motions, Schiffstechnik 9 (1962) 101-109. Each term of the memory is a
mass-spring-damper of the water that the velocity u = d . v of the hull drives: x' = u - 2 z w x - w y, y' = w x, f = -d
x. Its transform x / u = s / (s^2 + 2 z w s + w^2) is positive real; x^2 / 2 + y^2 / 2 is energy of the water near by, 2
z w x^2 the power that waves carry away (port-Hamiltonian form; Perez, Fossen, Modeling, Identification and Control 30
(2009) 1-15, for the properties of K).
"""

from collections.abc import Hashable

import numpy as np
from heavylift.kernel.algebra.spatial import join
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars
from heavylift.kernel.description.forces import Radiation

from .force_law import ForceLaw, LawOutput, Poses, SampledQuantity, attachment, wrench
from .springs import UNIT


class RadiationLaw(ForceLaw[Radiation]):
    """Radiation force at a point of a body; its states are those of the water, two a term."""

    def check(self, f: Radiation) -> None:
        n = len(f.frequencies)
        fits = n == len(f.dampings) == len(f.directions)
        self.demand(f, "frequencies", fits, "need one damping ratio and one direction each")
        self.demand(f, "frequencies", min(f.frequencies, default=1.0) > 0.0, "must be positive")
        self.demand(f, "dampings", min(f.dampings, default=1.0) > 0.0, "must be positive: water takes energy away")
        R = np.array(f.R)
        self.demand(f, "R", bool(np.abs(R @ R.T - np.eye(3)).max() < UNIT), "is not a rotation")

    def shape(self, f: Radiation) -> Hashable:
        return tuple(tuple(i for i, x in enumerate(d) if x) for d in f.directions)

    def numbers(self, f: Radiation, poses: Poses) -> list[float]:
        directions = [[x for x in d if x] for d in f.directions]
        terms = zip(f.frequencies, f.dampings, directions, strict=True)
        return [*f.at.p, *(float(x) for x in np.ravel(f.R)), *(x for w, z, d in terms for x in (w, z, *d))]

    def angles(self, f: Radiation) -> int:
        return 2 * len(f.frequencies)

    def turns(self, f: Radiation, poses: Poses) -> None:
        return None

    def answer(
        self, f: Radiation, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar, counted: Scalars = ()
    ) -> LawOutput:
        x_P, _, v = attachment(ends[0], p[:3], "a")
        R, given = np.reshape(p[3:12], (3, 3)), iter(p[12:])
        twist = join(R.T @ v, R.T @ ends[0][15:18])
        force, heat, stored, rates = np.zeros(6, dtype=object), 0.0, 0.0, list[Scalar]()
        for d, (x, y) in zip(f.directions, zip(counted[::2], counted[1::2], strict=True), strict=True):
            w, z = next(given), next(given)
            u: Scalar = 0.0
            for i in (i for i, present in enumerate(d) if present):
                part = next(given)
                u = u + part * twist[i]
                force[i] = force[i] - part * x
            lost = 2.0 * z * w * x
            rates += u - lost - w * y, w * x
            heat, stored = heat + lost * x, stored + 0.5 * (x * x + y * y)
        push, moment = R @ force[:3], R @ force[3:]
        return LawOutput(
            [wrench(x_P, push, moment)],
            heat=heat, stored=stored, shown=list(force), turned=list(counted), turning=rates,
        )  # fmt: skip

    def shows(self, f: Radiation) -> list[SampledQuantity]:
        return [SampledQuantity("radiation/force", f"{f.name}.{c}", "N or N m") for c in "x y z rx ry rz".split()]
