"""A period of rest needs memory for one sample row; its other rows are written later.

Two or three loads lie on their pads, until one or another is hoisted a little, or a rope ties two of them.
"""

from __future__ import annotations

import random
from collections.abc import Callable

import numpy as np
import pytest
from heavylift.kernel.islands import Islands
from heavylift.kernel.simulation import Simulation, recorder
from heavylift.kernel.simulation.native import ROWS
from heavylift.nodes.devs.execution.canonical import frozen, thawed
from two_loads import SECOND, TIED, TOLERANCE, TWO, wind

PERIOD = SECOND // 20
LONG = 10 * ROWS * PERIOD  # [ns] ten times what is made at once
Run = Simulation | Islands
Rows = list[tuple[int, np.ndarray]]
BUILDS: list[Callable[[], Run]] = [
    lambda: Islands(TWO, TOLERANCE, PERIOD),
    lambda: Islands(TIED, TOLERANCE, PERIOD),
    lambda: Simulation(TWO, TOLERANCE, PERIOD),
]


def rested(s: Run, t_ns: int, command: Callable[[Run], object] = lambda s: None) -> tuple[Rows, int]:
    """Go to a time and command there; all rows so far, and how many were there at once."""
    taken: Rows = []
    most = 0

    def take() -> None:
        nonlocal most
        most = max(most, len(s.rows))
        taken.extend(s.rows)
        s.rows.clear()

    s.run(t_ns, take)
    s.interrupt(t_ns, take)
    command(s)
    s.settle()
    take()
    return taken, most


@pytest.mark.parametrize("build", BUILDS)
def test_sample_rows_of_a_rest_are_the_same_whether_the_rest_is_simulated_in_steps_or_at_once(
    build: Callable[[], Run],
) -> None:
    s = build()
    s.start()
    rested(s, SECOND)
    rows, most = rested(s, SECOND + LONG)
    assert [t for t, _ in rows] == [*range(SECOND + PERIOD, SECOND + LONG + 1, PERIOD), SECOND + LONG]
    assert most <= ROWS + 2
    assert len({id(row) for _, row in rows}) <= 2 + LONG // PERIOD // ROWS


@pytest.mark.parametrize("build", BUILDS)
def test_sample_rows_of_several_rests_are_the_same_whether_each_is_simulated_in_steps_or_at_once(
    build: Callable[[], Run], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With one load or both hoisted after it, at once or one while the other rests on, and with a rope between them."""

    def played(seed: int) -> Rows:
        draw, s, t = random.Random(seed), build(), 0
        s.start()
        out, s.rows[:] = [*s.rows], []
        for _ in range(3):
            t += draw.choice((SECOND // 3, 3 * SECOND, 40 * ROWS * PERIOD // 16))
            moves = [wind(name, draw.uniform(-1.0, 1.0)) for name in draw.sample("ab", draw.randint(0, 2))]
            if build is BUILDS[1]:
                moves.append(draw.choice((lambda s: s.hook("tug"), lambda s: s.unhook("tug"))))
            rows, _ = rested(s, t, lambda s, moves=moves: [move(s) for move in moves])  # type: ignore[misc]
            out += rows
        return out

    by_and_by = [played(seed) for seed in range(2)]
    monkeypatch.setattr(recorder, "ROWS", 10**9)
    for seed, found in enumerate(by_and_by):
        expected = played(seed)
        assert [t for t, _ in found] == [t for t, _ in expected]
        assert all(np.array_equal(a, b) for (_, a), (_, b) in zip(found, expected, strict=True))


@pytest.mark.parametrize("build", BUILDS)
def test_a_snapshot_taken_while_the_system_is_at_rest_keeps_sample_rows_that_are_not_yet_written(
    build: Callable[[], Run],
) -> None:
    first, second = build(), build()
    for s in (first, second):
        s.start()
    rested(first, SECOND)
    first.interrupt(SECOND + LONG)
    wind("a", -1.0)(first)
    second.restore(thawed(frozen(first.snapshot())))
    for s in (first, second):
        s.settle()
    assert len(first.rows) > LONG // PERIOD
    assert [(t, row.tobytes()) for t, row in first.rows] == [(t, row.tobytes()) for t, row in second.rows]
