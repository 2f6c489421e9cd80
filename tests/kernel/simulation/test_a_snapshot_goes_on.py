"""A simulation continued from the bytes of a snapshot takes the same steps to the last bit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from contact_scenes import on_slope, rocker
from every_law import yard
from heavylift.kernel.description import Body, Joint, Lock, System
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.devs.execution.canonical import frozen, thawed
from small_scenes import SECOND, G, Y, cube, hand_over, hung, started

OWN_CALLS = ("run", "status", "budget", "until")  # of the last native call; everything else must be equal
END = 2 * SECOND
Command = Callable[[Simulation], object]


def led(s: Simulation) -> None:
    s.references.set_profile("rope", s.epoch, 0.5, 0.25, 3.0)


def double_pendulum() -> System:
    """Two links; a bolt can lock the second to the first."""
    joints = (
        Joint("shoulder", "revolute", "world", "upper", axis=Y, q0=(1.3,)),
        Joint("elbow", "revolute", "upper", "lower", (0.0, 0.0, -1.0), axis=Y, q0=(0.4,)),
    )
    bodies = tuple(Body(name, 40.0, (0.0, 0.0, -1.0), cube(40.0)) for name in ("upper", "lower"))
    return System(bodies, joints, locks=(Lock("bolt", "elbow"),), gravity=G)


STORIES: dict[str, tuple[System, dict[str, object], list[tuple[int, Command]]]] = {
    "every law": (yard(), {}, [(SECOND, lambda s: s.set_brake("hinge-brake", False))]),
    "winch": (hung(62.0, winch=True), {}, [(SECOND, led)]),
    "locks": (double_pendulum(), {}, [(SECOND, lambda s: s.set_lock("bolt", True))]),
    "sliding": (on_slope(0.6, 0.2), {}, []),
    "rocking": (rocker(0.3, 1.0, 0.2), {}, []),
    "radau5": (yard(), {"method": "radau5", "tolerance": 1e-4}, []),
    "fixed steps": (double_pendulum(), {"method": "rk4", "step": 1e-2}, []),
}


def begun(name: str) -> Simulation:
    system, options, _ = STORIES[name]
    return started(system, sample_ns=SECOND // 10, **options)  # type: ignore[arg-type]


def play(s: Simulation, name: str, begin: int, end: int) -> None:
    """The story's commands between two times, and what moves until the end."""
    for t, command in STORIES[name][2]:
        if begin <= t < end:
            hand_over(s, t)
            command(s)
            s.settle()
    s.run(end)


def bits(s: Simulation) -> tuple[bytes, bytes, list[tuple[int, bytes]]]:
    X = s.X.copy()
    for name in OWN_CALLS:
        X[s.method.layout.at[name]] = 0.0
    return X.tobytes(), s.P.tobytes(), [(t, row.tobytes()) for t, row in s.rows]


@pytest.mark.parametrize("name", STORIES)
@pytest.mark.large(beyond=3)
def test_a_run_continued_from_a_snapshot_at_any_moment_equals_the_uninterrupted_run(name: str) -> None:
    whole = begun(name)
    play(whole, name, 0, END)
    moments = np.random.default_rng(3).integers(0, END, 4)
    first = begun(name)
    done = 0
    for moment in sorted(map(int, moments)):
        play(first, name, done, moment)
        done = moment
        twin = begun(name)
        twin.restore(thawed(frozen(first.snapshot())))
        play(twin, name, moment, END)
        assert bits(twin) == bits(whole)


def test_a_snapshot_shares_no_data_with_its_simulation() -> None:
    s = begun("every law")
    s.run(SECOND)
    kept = s.snapshot()
    before = frozen(kept)
    s.run(2 * SECOND)
    twin = begun("every law")
    twin.restore(kept)
    twin.run(2 * SECOND)
    assert frozen(kept) == before
    assert bits(twin) == bits(s)
