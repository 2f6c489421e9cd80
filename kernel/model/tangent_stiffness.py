"""The tangent stiffness of a scene in one native call: derivatives of the accelerations along every degree of freedom.

Central differences of the traced rate at rest, and LU factors of what they make; loops of native code, so
that the bits depend on no linear algebra of the machine.  Discrete states are frozen; a column in which a guard falls
is marked, since a clamp of a law may have entered it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from heavylift.kernel.compiler.function import OPAQUE, Outputs, Primitive
from heavylift.kernel.compiler.native_linear_algebra import Factors, solver
from heavylift.kernel.compiler.native_loops import Code
from heavylift.kernel.compiler.symbol import Array, Scalar

__all__ = ["FOURTH", "SECOND", "Tangent"]

FOURTH, SECOND = (2.0 / 3.0, -1.0 / 12.0), (0.5, 0.0)  # order of central differences: weights of h f'(0)

Rate = Callable[..., Any]  # (t (2,), y (ny,), P) -> dy, T, G, ... by name


@dataclass(frozen=True)
class Tangent:
    """Native functions of a scene: `sizes` of what `rate` writes, its first the derivative (ny,), G its guards.

    Block J: per velocity the derivative of all accelerations (nv,), then whether a guard fell.
    """

    nq: int
    nv: int
    n: int
    sizes: dict[str, int]

    @cached_property
    def factors(self) -> Factors:
        """Of an (n, n) matrix over the free degrees of freedom, from the start of a block M."""
        return Factors(self.n, 1, 0)

    @property
    def work(self) -> int:
        """Numbers of the block that `rate` works on: a state, a displacement, and what it writes."""
        return self.sizes["dy"] + self.nq + sum(self.sizes.values())

    def functions(self, rate: Rate) -> list[Primitive]:
        """`tangent`(t, y, P, G, step, work, J) with step = (h, two weights), `factorise_tangent`(M), and
        `solve_tangent`(M, b, tail, x)."""
        c = Code("factorise_tangent", ["M"])
        self.factors.factorise(c)

        def factorise(M: np.ndarray) -> Outputs:
            self.factors.factorise_floats(M)
            return {}

        factorised = Primitive(c.name, factorise, {"M": OPAQUE}, {}, c.text())
        return [self._differences(rate), factorised, solver("solve_tangent", self.factors, self.n)]

    def _differences(self, rate: Rate) -> Primitive:
        inputs = dict.fromkeys(("t", "y", "P", "G", "step", "work", "J"), OPAQUE)
        c = Code("tangent", list(inputs))
        ny, nq, nv, width = self.sizes["dy"], self.nq, self.nv, self.nv + 1
        moved, along = "%work", c.at("%work", ny)
        out, place = {}, ny + nq
        for name, n in self.sizes.items():
            out[name], place = c.at("%work", place), place + n

        def evaluate() -> None:
            c.call("rate", ["%t", moved, "%P", *out.values()])

        def copied(n: int, source: str, target: str) -> None:
            with c.loop(0, n) as i:
                c.store(c.load(c.at(source, i)), c.at(target, i))

        h, near, far = (c.load(c.at("%step", i)) for i in range(3))
        with c.loop(0, nv) as k:
            row = c.at("%J", c.integer("mul", k, width))
            copied(ny, "%y", moved)
            c.store("1.0", c.at(moved, nq, k))
            evaluate()
            copied(nq, out["dy"], along)
            with c.loop(0, width) as i:
                c.store("0.0", c.at(row, i))

            def differ(reach: float, weight: str) -> None:
                for side, part in ((reach, weight), (-reach, c.let(f"fneg double {weight}"))):
                    copied(ny, "%y", moved)
                    scaled = c.let(f"fmul double {h}, {side}")
                    with c.loop(0, nq) as i:
                        way = c.let(f"fmul double {scaled}, {c.load(c.at(along, i))}")
                        c.store(c.let(f"fadd double {c.load(c.at(moved, i))}, {way}"), c.at(moved, i))
                    evaluate()
                    with c.loop(0, nv) as i:
                        change = c.let(f"fmul double {c.load(c.at(out['dy'], nq, i))}, {part}")
                        c.store(c.let(f"fadd double {c.load(c.at(row, i))}, {change}"), c.at(row, i))
                    with c.loop(0, self.sizes["G"]) as i:
                        held = c.let(f"fcmp oge double {c.load(c.at('%G', i))}, 0.0")
                        below = c.let(f"fcmp olt double {c.load(c.at(out['G'], i))}, 0.0")
                        with c.when(c.let(f"and i1 {held}, {below}")):
                            c.store("1.0", c.at(row, nv))

            differ(1.0, near)
            with c.when(c.let(f"fcmp one double {far}, 0.0")):
                differ(2.0, far)
            with c.loop(0, nv) as i:
                c.store(c.let(f"fdiv double {c.load(c.at(row, i))}, {h}"), c.at(row, i))

        def floats(t: Scalar, y: Array, P: Array, G: Array, step: Array, work: Array, J: Array) -> Outputs:
            for row, e in zip(J.reshape(nv, width), np.eye(nv), strict=True):
                at_rest = np.concatenate([y[:nq], e, y[nq + nv :]])
                way = np.array(rate(t=t, y=at_rest, P=P).dy)[:nq]
                row[:] = 0.0
                h, near, far = step
                for x, weight in ((1.0, near), (-1.0, -near), (2.0, far), (-2.0, -far)):
                    if not weight:
                        continue
                    r = rate(t=t, y=np.concatenate([y[:nq] + (h * x) * way, y[nq:]]), P=P)
                    row[:nv] += np.array(r.dy)[nq : nq + nv] * weight
                    row[nv] = max(row[nv], float(((np.array(r.G) < 0.0) & (G >= 0.0)).any()))
                row[:nv] /= h
            return {}

        return Primitive("tangent", floats, inputs, {}, c.text())
