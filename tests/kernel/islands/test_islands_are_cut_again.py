"""A rope hooked between two islands merges them; unhooking it separates the resting part again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Line, Point, Rope
from heavylift.kernel.islands import Islands
from heavylift.nodes.devs.execution.canonical import frozen, thawed
from two_loads import APART, SECOND, TIED, TOLERANCE, TWO, Stage, assert_alike, islands, one, played, wind

HOOKED: list[Stage] = [
    (2.0, lambda s: s.hook("tug", L0=10.0)),
    (6.0, lambda s: s.unhook("tug")),
    (16.0, wind("a", -1.0)),
]


def test_hooking_a_rope_joins_two_islands_and_unhooking_it_separates_a_resting_part() -> None:
    s, whole = islands(TIED, cut_at_once=True), played(one(TIED), HOOKED)
    s.start()
    assert len(s.parts) == 2
    played(s, HOOKED[:1], end=5.0, start=False)
    assert [len(p.given.bodies) for p in s.parts] == [2]
    played(s, HOOKED[1:], start=False)
    assert s.loose == {"tug"}
    assert [len(p.given.bodies) for p in s.parts] == [1, 1]
    assert [(e.name, e.what) for _, e in s.log] == [(e.name, e.what) for _, e in whole.log]
    at, (last, expected) = whole.method.row_layout.at, (x.rows[-1][1] for x in (s, whole))
    for group in ("q", "elongation", "length", "accounts"):
        assert np.abs(last[at[group]] - expected[at[group]]).max() < APART * np.abs(expected[at[group]]).max(), group


def test_a_rope_that_starts_unhooked_pulls_between_its_two_stated_points_once_it_is_hooked() -> None:
    """Off the origin of a body of another island: its span is shown, and from there it pulls later."""
    line = Line(Point("load-a", (0.0, 0.1, 0.3)), Point("load-b", (0.2, 0.0, -0.4)))
    scene = replace(TWO, ropes=(*TWO.ropes, Rope("tug", (line,), 1e6, 10.2, 1e4, hooked=False)))
    hooked: list[Stage] = [(2.0, lambda s: s.hook("tug", L0=10.3)), (2.5, wind("a", -1.0))]
    s, whole = played(islands(scene), hooked, end=5.0), played(one(scene), hooked, end=5.0)
    assert ("tug", "taut") in [(e.name, e.what) for _, e in s.log]
    assert_alike(s, whole, "q", "elongation")


@pytest.mark.parametrize("t", [1.0, 4.0, 18.0])
def test_a_snapshot_keeps_the_present_division_into_islands(t: float) -> None:
    first, second = (islands(TIED, cut_at_once=True) for _ in range(2))
    before, after = ([x for x in HOOKED if (x[0] <= t) is early] for early in (True, False))
    played(first, before, end=t)
    second.start()
    second.restore(thawed(frozen(first.snapshot())))
    for s in (first, second):
        played(s, after, start=False)
    assert [(at, row.tobytes()) for at, row in second.rows] == [(at, row.tobytes()) for at, row in first.rows]


def test_the_failure_of_one_island_is_raised_after_earlier_events_of_another_island() -> None:
    """The rope of one is used up at 2.6 s; at 2.0 s the other is 1 m higher, and who hears that may stop the winch."""
    s = Islands(TWO, TOLERANCE, 2 * SECOND, frozenset({"height-a"}))
    s.start()
    s.interrupt(0)
    s.watch("height-a", 2.0, True)
    wind("a", -5.0)(s)
    s.set_profile("rope-b", 0, 12.0, 20.0, -28.3)
    s.settle()
    s.run(4 * SECOND)
    assert s.preview()[0].name == "height-a"
    s.fire()
    s.settle()
    with pytest.raises(KernelError, match="rope 'rope-b' at 2"):
        s.run(4 * SECOND)


def test_an_unknown_name_in_a_command_to_islands_is_refused() -> None:
    s = islands()
    s.start()
    with pytest.raises(KernelError, match="'rope-c': there is no drive, winch or master with this name"):
        s.set_profile("rope-c", 0, 1.0, 1.0, 1.0)
    with pytest.raises(KernelError, match="'rope-c': there is no rope with this name"):
        s.unhook("rope-c")
