"""Rigid ropes: a length that cannot be exceeded, as a row that pulls while the rope is taut and is absent while slack.

Residual: slack = L0 - sum(share |a - b|), never negative; multiplier: the tension, never negative.  Which ropes are
taut is a discrete state; what becomes of it at an event stands in `rope_impacts`.
"""

from heavylift.kernel.algebra.spatial import cross, join
from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, sqrt
from heavylift.kernel.description.mechanics import RigidRope
from heavylift.kernel.forces.force_law import BODY, attachment

SLACK = 1e-9  # [m] used up by less, a rope still counts as slack, so that round-off does not pull it taut
TOUCHING = 2e-9  # [m] slack below which a rope may become taut
LINE = 7  # numbers of a line: a(3), b(3), share


class RigidAt:
    """Places of a rigid rope's numbers, before those of its lines: a(3), b(3), share."""

    HOOKED, TAUT, LINES = range(3)
    A, B = slice(2, 5), slice(5, 8)


def rigid_numbers(rope: RigidRope) -> list[float]:
    """hooked, taut and the lines of a rope."""
    return [float(rope.hooked), 0.0, *(x for line in rope.lines for x in (*line.a.p, *line.b.p, line.share))]


def rigid_rope(n: int) -> Function:
    """The row of a rope of n lines: L (L0, L0', L0'') -> gap, rate, bias, and per line the wrenches wa, wb (6,)."""

    def body(L: Array, p: Array, **ends: Array) -> Outputs:
        gap, rate, bias = L[0], L[1], L[2]
        out: dict[str, Array] = {}
        for i in range(n):
            q = p[RigidAt.LINES + LINE * i : RigidAt.LINES + LINE * (i + 1)]
            A, B = ends[f"a{i}"], ends[f"b{i}"]
            (x_a, p_a, v_a), (x_b, p_b, v_b) = attachment(A, q[:3]), attachment(B, q[3:6])
            d, dv = p_b - p_a, v_b - v_a
            l = sqrt(d @ d)
            u = d * (1.0 / l)
            dl = u @ dv
            du = (dv - dl * u) * (1.0 / l)
            gap, rate = gap - q[6] * l, rate - q[6] * dl
            for e, x, v, V, sign in (("a", x_a, v_a, A[15:], 1.0), ("b", x_b, v_b, B[15:], -1.0)):
                s = sign * q[6]
                out[f"w{e}{i}"] = s * join(cross(x, u), u)
                bias = bias + s * (join(cross(v, u) + cross(x, du), du) @ V)
        return {"gap": [gap], "rate": [rate], "bias": [bias], **out}

    blocks = {f"{e}{i}": BODY for i in range(n) for e in "ab"}
    return Function(f"rigid{n}", body, {"L": 3, "p": RigidAt.LINES + LINE * n, **blocks})
