"""Signals read from a sample row: what a model that listens gets, by IEEE arithmetic alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from heavylift.kernel.description.mechanics import Point
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.kernel.errors import KernelError
from heavylift.kernel.model.program import Program
from heavylift.kernel.model.quantities import check_signal, lines, names, numbers, points, scalar

from .sample_row import row_layout

Reader: TypeAlias = Callable[[Sequence[float]], float]  # of a raw row (columns,)


def reader(program: Program, signal: ScalarSignal) -> Reader:
    """The function that reads a signal; raises KernelError if the scene has no such signal."""
    system = program.system
    check_signal(signal, system, f"signal '{signal.quantity}'")
    places = [_placed(program, point) for point in points(signal, system)]
    columns = [_column(program, signal, name) for name in names(signal)]
    given, each = numbers(signal, system), lines(signal, system)
    return lambda row: float(scalar(signal, [place(row) for place in places], given, [row[i] for i in columns], each))


def _column(program: Program, signal: ScalarSignal, name: str) -> int:
    """Where a row has what a signal is of."""
    at, s, kind = row_layout(program).at, program.system, signal.quantity
    if kind in ("joint", "speed"):
        i, k = program.graph.coordinate(f"signal '{kind}'", name, signal.coordinate)
        return int(at["q"].start + i if kind == "joint" else at["v"].start + k)
    if kind == "angle":
        label = ("body", name, signal.axis)
        if label not in program.angles:
            raise KernelError(f"signal 'angle': that of '{name}' is not measured in this scene")
        return int(at["turned"].start) + program.angles.index(label)
    elastic, rigid = [r.name for r in s.ropes], [r.name for r in s.rigid_ropes]
    shown = [x for (_, x), _, _ in program.columns["shown"]]
    if kind == "length" and name in elastic:
        return int(at["length"].start) + elastic.index(name)
    if kind != "length" and name in elastic:
        return int(at["tension"].start) + [x for (_, x), _, _ in program.columns["tension"]].index(name)
    if name in rigid:
        return int(at["span" if kind == "length" else "pull"].start) + rigid.index(name)
    if kind != "length" and name in shown:
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
