"""Machine code and interpreted Python take the same steps through a run with every law.

A command at t ends a forced step there.  After an event some steps are chosen by an error estimate that is nearly all
round-off: they end some picoseconds apart, which shows in the peaks and in their times, and nowhere else.
"""

import numpy as np
import pytest
from every_law import yard
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.simulation.native import channels, published

SAME = 1e-12
PEAK = 1e-8  # of a peak, and [s] of its time
ROUNDED = 1e-15  # of EA: a length of 26 m is known to 4e-15 m
STORY = {  # after this many milliseconds
    1: lambda s: s.references.set_profile("travel", s.epoch, 0.2, 0.4, None),
    2: lambda s: s.references.set_profile("hoist", s.epoch, -0.5, 20.0, None),
    4: lambda s: s.hook("sling", (3.0, 0.1, 0.0), (2.0, 0.1, 2.0), 26.02),
    6: lambda s: s.set_brake("hinge-brake", False),
    7: lambda s: s.references.set_profile("theta", s.epoch, 0.1, 5.0, 0.5),
    8: lambda s: s.set_follow("traverse", "theta", (0.3, -1.0, 2.0)),
    10: lambda s: s.switches.watch("heavy", 3e3, True),
    14: lambda s: s.set_brake("hinge-brake", True),
    16: lambda s: s.switches.watch("high", -5.0, True),
    18: lambda s: s.unhook("sling"),
}
STEPS = 20


def far(got: np.ndarray, want: np.ndarray) -> float:
    """Largest difference, relative to 1 + |value|."""
    return float((np.abs(got - want) / (1.0 + np.abs(want))).max())


@pytest.fixture(scope="module")
def pair() -> tuple[Simulation, Simulation, list[float]]:
    """Both at the end of the story, and how far apart their states were after each millisecond."""
    native, oracle = (Simulation(yard(), 1e-9, 500_000, native=n) for n in (True, False))
    for s in (native, oracle):
        s.start()
    apart = []
    for i in range(STEPS + 1):
        for s in (native, oracle):
            s.interrupt(i * 1_000_000 + 1)
            STORY.get(i, lambda s: None)(s)
            s.settle()
        n = native.program.ny
        apart.append(far(native.state[:n], oracle.state[:n]))
    return native, oracle, apart


def test_machine_code_and_interpreted_python_agree_after_each_integration_step(pair):
    native, oracle, apart = pair
    assert native.epoch == oracle.epoch == STEPS * 1_000_000 + 1
    assert max(apart) < SAME, apart


def test_the_test_run_for_machine_code_and_interpreted_python_has_an_event_of_every_force_law(pair):
    native, _, _ = pair
    row, names = native.row(), [(e.name, e.what) for _, e in native.log]
    assert [name for name, what in names if what == "closed"] == ["pad-1-1", "pad-11", "pad1-1", "pad11"]
    assert names[4:] == [("sling", "taut"), ("heavy", "reached"), ("high", "reached")]
    assert row.normal.min() > 0.0
    assert np.abs(row.q).min() > 0.0


def test_machine_code_and_interpreted_python_find_events_at_the_same_nanoseconds(pair):
    native, oracle, _ = pair
    assert [(t, e.name, e.what) for t, e in native.log] == [(t, e.name, e.what) for t, e in oracle.log]
    values = [np.array([e.value for _, e in s.log]) for s in (native, oracle)]
    assert far(*values) < SAME


def test_machine_code_and_interpreted_python_give_equal_sample_rows(pair):
    native, oracle, _ = pair
    assert [t for t, _ in native.rows] == [t for t, _ in oracle.rows]
    got, want = (published(s.method, np.array([row for _, row in s.rows])) for s in (native, oracle))
    assert len(got) > 2 * STEPS
    stiff = np.array([rope.EA for rope in yard().ropes])
    for c in channels(native.method):
        columns = slice(c.start, c.stop)
        error = np.abs(got - want)[:, columns].max(axis=0)
        scale = np.maximum(np.abs(want[:, columns]).max(axis=0), 1.0)
        bound = (PEAK if c.topic.startswith("rope/peak") else SAME) * scale
        if c.topic == "rope/tension":
            bound += ROUNDED * stiff
        assert (error < bound).all(), c.topic
