"""Tugger lines: massless lines that a winch keeps at a set tension, within its stroke.

A tension has the potential tension * length, into which an order that changes it brings work; the spread of the tension
between paying out and taking in only dissipates.
"""

from collections.abc import Hashable

import numpy as np
from heavylift.kernel.compiler.symbol import Array, Scalar, Scalars, minimum, select, sqrt
from heavylift.kernel.description.forces import InputSignal, TuggerLine

from .force_law import ForceLaw, LawBreakdown, LawOutput, Poses, SampledQuantity, attachment, wrench
from .mooring import LineAt

TINY = 1e-160  # keeps 0/0 away


class TuggerLaw(ForceLaw[TuggerLine]):
    """Force law of a tugger line with a winch of constant tension."""

    def check(self, f: TuggerLine) -> None:
        self.demand(f, "spread", f.spread < 1.0, f"is {f.spread:g}; it must be below 1, or the line would push")
        self.demand(f, "b", f.a.body != f.b.body, "is on the body of a; the line has no effect")

    works = True

    def signal(self, f: TuggerLine) -> InputSignal | None:
        return InputSignal(f.tension, driven=True) if f.rate else None

    def shape(self, f: TuggerLine) -> Hashable:
        return f.longest > 0.0, f.rate > 0.0

    def numbers(self, f: TuggerLine, poses: Poses) -> list[float]:
        a, b = (R @ np.array(end.p) + p for end in (f.a, f.b) for R, p in (poses(end.body),))
        x, y, z = (b - a).tolist()
        length = sqrt(x * x + y * y + z * z)
        good = f.shortest < length and (length < f.longest or not f.longest)
        self.demand(f, "length", good, f"is {length:.5g} m at the start; it must be within {_stroke(f)}")
        given = [f.tension, f.spread, f.speed, f.shortest, f.longest]
        return [*f.a.p, *f.b.p, float(f.hooked), *given]

    def answer(
        self, f: TuggerLine, p: Array, ends: list[Array], signal: Scalars, joint: Scalars, t: Scalar
    ) -> LawOutput:
        (x_a, p_a, v_a), (x_b, p_b, v_b) = attachment(ends[0], p[:3], "a"), attachment(ends[1], p[3:6], "b")
        on, tension, spread, speed, shortest, longest = p[LineAt.HOOKED :]
        tension, change = signal if f.rate else (tension, 0.0)
        on, s = on > 0.0, p_b - p_a
        length = sqrt(s @ s + TINY)
        u = s * (1.0 / length)
        rate = u @ (v_b - v_a)
        x = rate / speed
        more = select(on, tension * spread * x / sqrt(1.0 + x * x), 0.0)
        pull = select(on, tension, 0.0)
        left = length - shortest
        return LawOutput(
            [wrench(x_a, (pull + more) * u), -wrench(x_b, (pull + more) * u)],
            heat=more * rate,
            work=select(on, change * length, 0.0),
            stored=pull * length,
            guards=[select(on, minimum(left, longest - length) if f.longest > 0.0 else left, 1.0)],
            shown=[pull + more, length],
        )

    def guards(self, f: TuggerLine) -> tuple[str, ...]:
        return ("stroke",)

    def switch(self, f: TuggerLine, p: np.ndarray, guard: str, shown: np.ndarray) -> tuple[str, float]:
        why = (
            f"it is {shown[1]:.5g} m long, and its winch has a stroke within {_stroke(f)}: give it more, or release it"
        )
        raise LawBreakdown(f"tugger line '{f.name}'", why)

    def shows(self, f: TuggerLine) -> list[SampledQuantity]:
        # a line is a rope of one part
        return [
            SampledQuantity("reeving/tension", f"{f.name}.1", "N"),
            SampledQuantity("reeving/length", f"{f.name}.1", "m"),
        ]


def _stroke(f: TuggerLine) -> str:
    return f"{f.shortest:g} m to {f.longest:g} m" if f.longest else f"{f.shortest:g} m and more"
