"""Signals read from a sample row: what a model that listens gets, by IEEE arithmetic alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from heavylift.kernel.algebra.elementary import atan2
from heavylift.kernel.description.mechanics import Point, RigidRope, Rope
from heavylift.kernel.description.signals import Signal
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.program import Program

from .sample_row import row_layout

__all__ = ["Reader", "reader"]

Reader: TypeAlias = Callable[[Sequence[float]], float]  # of a raw row (columns,)


def reader(program: Program, signal: Signal) -> Reader:
    """The function that reads a signal; raises KernelError if the scene has no such signal."""
    at, kind = row_layout(program).at, signal.quantity
    if kind in ("joint", "speed"):
        i, k = program.graph.coordinate(f"signal '{kind}'", signal.of, signal.coordinate)
        place = at["q"].start + i if kind == "joint" else at["v"].start + k
        return lambda row: row[place]
    if kind == "angle":
        label = ("body", signal.of, signal.axis)
        if label not in program.angles:
            raise KernelError(f"signal 'angle': that of '{signal.of}' is not measured in this scene")
        place = at["turned"].start + program.angles.index(label)
        return lambda row: row[place]
    if kind == "height":
        assert signal.point is not None, "of a height"
        point = _placed(program, signal.point)
        return lambda row: point(row)[2]
    if kind in ("tension", "length"):
        places = [_column(program, kind, name) for name in signal.ropes]
        return lambda row: sum(row[place] for place in places)
    rope = _rope(program, signal.ropes[0])
    lines = [(line.share, _placed(program, line.a), _placed(program, line.b)) for line in rope.lines]
    aside = 0 if kind == "swing along" else 1

    def swing(row: Sequence[float]) -> float:
        out = drop = 0.0
        for share, a, b in lines:
            above, below = a(row), b(row)
            out += share * (below[aside] - above[aside])
            drop += share * (above[2] - below[2])
        return float(atan2(out, drop))

    return swing


def _rope(program: Program, name: str) -> Rope | RigidRope:
    found = next((rope for rope in program.system.straight_ropes if rope.name == name), None)
    if found is None:
        raise KernelError(f"signal 'swing': there is no straight rope '{name}'")
    return found


def _column(program: Program, kind: str, name: str) -> int:
    """Column of the tension or the length of a rope."""
    at, s = row_layout(program).at, program.system
    elastic, rigid = [r.name for r in s.ropes], [r.name for r in s.rigid_ropes]
    if name in elastic:
        if kind == "length":
            return int(at["length"].start) + elastic.index(name)
        return int(at["tension"].start) + [x for (_, x), _, _ in program.columns["tension"]].index(name)
    if name in rigid:
        return int(at["span" if kind == "length" else "pull"].start) + rigid.index(name)
    shown = [x for (_, x), _, _ in program.columns["shown"]]
    if kind == "tension" and name in shown:
        return int(at["shown"].start) + shown.index(name)
    raise KernelError(f"signal '{kind}': there is no rope '{name}'")


def _placed(program: Program, point: Point) -> Callable[[Sequence[float]], tuple[float, float, float]]:
    """Place of a point of a body in the world [m]."""
    number, (x, y, z) = program.graph.number(point.body), point.p
    if number < 0:
        return lambda row: (x, y, z)
    o = row_layout(program).at["poses"].start + 12 * number

    def place(row: Sequence[float]) -> tuple[float, float, float]:
        r = row[o : o + 12]
        return (
            r[0] + (r[3] * x + r[4] * y + r[5] * z),
            r[1] + (r[6] * x + r[7] * y + r[8] * z),
            r[2] + (r[9] * x + r[10] * y + r[11] * z),
        )

    return place
