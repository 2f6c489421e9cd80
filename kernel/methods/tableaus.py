"""Butcher tableaus as data: classical Runge-Kutta and Dormand-Prince 5(4); Dormand-Prince 8 stands in `dop853`."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Tableau:
    """Nodes c, stages A (lower triangular), weights b, and the weights of the error estimate (empty: none)."""

    order: int
    c: tuple[float, ...]
    A: list[list[float]]
    b: list[float]
    error: list[float] = field(default_factory=list)


# Kutta 1901; Hairer, Norsett, Wanner, Solving ODEs I, II.1, table 1.2
KUTTA_4 = Tableau(
    order=4,
    c=(0, 1 / 2, 1 / 2, 1),
    A=[[], [1 / 2], [0, 1 / 2], [0, 0, 1]],
    b=[1 / 6, 1 / 3, 1 / 3, 1 / 6],
)

# Dormand, Prince 1980; Hairer, Norsett, Wanner I, II.5, table 5.2; the last stage is the first of the next step
DORMAND_PRINCE_5 = Tableau(
    order=5,
    c=(0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1, 1),
    A=[
        [],
        [1 / 5],
        [3 / 40, 9 / 40],
        [44 / 45, -56 / 15, 32 / 9],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ],
    b=[35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84, 0],
    error=[71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40],
)
