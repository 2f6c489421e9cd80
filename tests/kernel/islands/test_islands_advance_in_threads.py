"""Islands in threads give the bits of islands in sequence; errors and interruptions are raised in order."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from heavylift.kernel.description import merge
from heavylift.kernel.islands import WORTH, Island, Islands, SideBySide
from two_loads import SECOND, TOLERANCE, G, lift, played, wind

LIFTS = "abcde"
THREADS = (2, 3, 8)
SURE = 3.0  # times: events end what was foreseen


def rows(threads: int, seed: int) -> list[tuple[int, bytes]]:
    """All sample rows of five loads that are hoisted at random."""
    draw = np.random.default_rng(seed)
    stages = [
        (float(t), wind(str(name), float(draw.uniform(-6.0, -1.0))))
        for t, name in zip(np.sort(draw.uniform(0.1, 15.0, 8)).round(3), draw.choice(list(LIFTS), 8), strict=True)
    ]
    system = merge([lift(name, 10.0 * i) for i, name in enumerate(LIFTS)], G)
    islands = Islands(system, TOLERANCE, SECOND // 10)
    islands._side_by_side = SideBySide(threads, worth=0.0)
    played(islands, stages)
    return [(t, row.tobytes()) for t, row in islands.rows]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("threads", THREADS)
def test_the_number_of_threads_does_not_change_any_bit_of_the_results(threads: int, seed: int) -> None:
    assert rows(threads, seed) == rows(1, seed)


def failing(message: str, after_s: float, pause: Callable[[], None]) -> None:
    time.sleep(after_s)
    raise ValueError(message)


@pytest.mark.parametrize("threads", [1, *THREADS])
def test_if_several_islands_fail_the_error_of_the_first_island_in_order_is_raised(threads: int) -> None:
    tasks = [partial(failing, name, 0.05 - 0.01 * i) for i, name in enumerate(LIFTS)]
    with pytest.raises(ValueError, match=r"^a$"):
        SideBySide(threads).carry_out(tasks, lambda: None)


@pytest.mark.parametrize("threads", [1, *THREADS])
def test_an_interruption_stops_all_islands_before_its_error_is_raised(threads: int) -> None:
    going = []

    def endless(pause: Callable[[], None]) -> None:
        going.append(1)
        try:
            while True:
                time.sleep(0.001)
                pause()
        finally:
            going.pop()

    def interrupt() -> None:
        assert threading.current_thread() is threading.main_thread()
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        SideBySide(threads).carry_out([endless] * 5, interrupt)
    assert not going


@pytest.mark.parametrize(("work", "alone"), [(0.0, True), (WORTH, False)])
def test_tasks_with_little_work_run_in_the_calling_thread_alone(work: float, alone: bool) -> None:
    ran = set[threading.Thread]()
    together = threading.Barrier(1 if alone else 2)

    def task(pause: Callable[[], None]) -> None:
        together.wait(10.0)
        ran.add(threading.current_thread())

    SideBySide(2).carry_out([task, task], lambda: None, work)
    assert (ran == {threading.main_thread()}) == alone
    assert len(ran) == (1 if alone else 2)


def test_the_work_that_islands_foresee_is_that_of_the_steps_they_take(monkeypatch: pytest.MonkeyPatch) -> None:
    foreseen, done = list[float](), list[float]()
    extend = Island.extend

    def noted(self: Island, until_ns: int, most_ns: int, pause: Callable[[], None]) -> None:
        foreseen.append(self.work(until_ns, most_ns))
        before = self.native.attempts
        extend(self, until_ns, most_ns, pause)
        done.append((self.native.attempts - before) * self.program.nv)

    monkeypatch.setattr(Island, "extend", noted)
    rows(1, 0)
    assert max(done) > WORTH / 10.0
    assert 1.0 / SURE < sum(foreseen) / sum(done) < SURE
