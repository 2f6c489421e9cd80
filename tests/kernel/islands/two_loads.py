"""Two loads of 10 t, each below its winch: what tests of islands play."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from heavylift.kernel.description import Body, Joint, Line, Matrix, Point, Rope, Support, System, Threshold, merge
from heavylift.kernel.islands import Islands
from heavylift.kernel.simulation import Simulation

SECOND = 1_000_000_000
TOLERANCE = 1e-7
G = 9.80665
STIFF = 1e8  # [N/m] of a pad
SETTLED = 1e4 * G / (4.0 * STIFF)  # [m]
APART = 1e-5  # relative: two runs of tolerance 1e-7 that do not step alike, over 20 s
Stage = tuple[float, Callable[[Simulation | Islands], object]]


def cube(mass: float) -> Matrix:
    i = mass * 4.0 / 6.0
    return ((i, 0.0, 0.0), (0.0, i, 0.0), (0.0, 0.0, i))


def lift(name: str, x: float) -> System:
    """A load of 10 t at rest on four pads below a winch."""
    load, pads = Body(f"load-{name}", 1e4, inertia=cube(1e4)), [(a, b, -1.0) for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
    joint = Joint(
        f"free-{name}", "free", "world", load.name, q0=(x, 0.0, 1.0 - SETTLED, 0.0, 0.0, 0.0, 1.0), v0=(0.0,) * 6
    )
    line = Line(Point("world", (x, 0.0, 30.0)), Point(load.name, (0.0, 0.0, 1.0)))
    return System(
        (load,),
        (joint,),
        ropes=(Rope(f"rope-{name}", (line,), 1e8, 28.2, 1e4, winch=True),),
        supports=tuple(Support(f"pad-{name}{i}", Point(load.name, p), 0.0, STIFF, 1e6) for i, p in enumerate(pads)),
        thresholds=(Threshold(f"height-{name}", "height", point=Point(load.name)),),
        gravity=G,
    )


def tug() -> Rope:
    """From one load to the other, not hooked."""
    return Rope("tug", (Line(Point("load-a"), Point("load-b")),), 1e6, 10.2, 1e4, hooked=False)


TWO = merge([lift("a", 0.0), lift("b", 10.0)], G)
TIED = replace(TWO, ropes=(*TWO.ropes, tug()))


def wind(name: str, metres: float) -> Callable[[Simulation | Islands], object]:
    return lambda s: s.set_profile(f"rope-{name}", s.epoch, 1.0, 0.5, metres)


UP: list[Stage] = [(1.0, wind("a", -5.0)), (3.000000123, wind("b", -3.0)), (12.0, wind("a", 6.0))]
END = 20.0


def played(
    s: Simulation | Islands, stages: list[Stage], end: float = END, start: bool = True, pieces: int = 0
) -> Simulation | Islands:
    if start:
        s.start()
    for t, command in (*stages, (end, lambda s: None)):
        t_ns = round(t * SECOND)
        for i in range(pieces):
            s.run(s.epoch + (t_ns - s.epoch) * i // pieces)
        while True:
            s.run(t_ns)
            if s.next_ns >= t_ns or not s.event:
                break
            s.fire()
            s.settle()
        s.interrupt(t_ns)
        command(s)
        s.settle()
    return s


def islands(system: System = TWO, **options: object) -> Islands:
    return Islands(system, TOLERANCE, SECOND // 10, **options)  # type: ignore[arg-type]


def one(system: System = TWO) -> Simulation:
    return Simulation(system, TOLERANCE, SECOND // 10)


def bodies(systems: list[System]) -> list[list[str]]:
    return [[b.name for b in s.bodies] for s in systems]


def grid(s: Simulation | Islands) -> Iterator[tuple[int, np.ndarray]]:
    return ((t, row) for t, row in s.rows if t % (SECOND // 10) == 0)


def assert_alike(s: Simulation | Islands, whole: Simulation | Islands, *groups: str) -> None:
    """The same columns of their rows, but for steps that are not the same."""
    (times, rows), (same, expected) = (zip(*grid(x), strict=True) for x in (s, whole))
    assert times == same
    for group in groups:
        x, y = (np.array(r)[:, whole.method.row_layout.at[group]] for r in (rows, expected))
        assert np.abs(x - y).max() < APART * np.abs(y).max(), group
