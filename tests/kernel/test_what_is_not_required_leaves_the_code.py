"""Choices made again in mid-run: unhooked ropes, pads and contacts in the air leave the code, and no bit changes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from contact_scenes import ball, floating
from heavylift.kernel.description.contacts import Ball, Contact, Plane
from heavylift.kernel.description.mechanics import Body, Line, Point, RigidRope, Rope, Support, System
from heavylift.kernel.simulation.native.variant_policy import SPELL, Thrift
from heavylift.kernel.simulation.simulation import Simulation
from small_scenes import SECOND, G, cube, events, hand_over, started

ROUNDING = 1e-12  # relative: rows that others do not stand beside are regularised by other numbers of size 1e-18
HIGH = 30.0  # [m] of the winches
Command = Callable[[Simulation], object]


def lines() -> tuple[Line, Line]:
    """Of a hoist, and of a second rope that nobody has hooked."""
    return (
        Line(Point("world", (0.0, 0.0, HIGH)), Point("load")),
        Line(Point("world", (5.0, 0.0, HIGH)), Point("load")),
    )


def on_pads() -> System:
    """A load of 10 t on four pads below a winch."""
    hoist, other = lines()
    feet = [(x, y, -1.0) for x in (-1.0, 1.0) for y in (-1.0, 1.0)]
    pads = tuple(Support(f"pad-{i}", Point("load", p), 0.0, 1e8, 1e6, 0.3, 1e7, 1e5) for i, p in enumerate(feet))
    ropes = Rope("hoist", (hoist,), 1e8, 29.2, 1e4, winch=True), Rope("other", (other,), 1e8, 40.0, 1e4, hooked=False)
    body = Body("load", 1e4, inertia=cube(1e4))
    return System((body,), (floating("load", (0.0, 0.0, 1.0)),), ropes=ropes, supports=pads, gravity=G)


def on_the_ground(rigid: bool = False) -> System:
    """A ball of 10 t that touches the ground; its ropes are elastic or rigid."""
    body, joint = ball("load", 1.0, 1e4, (0.0, 0.0, 1.0))
    ground = Contact("ground", Ball("load", radius=1.0), Plane(), 0.4)
    hoist, other = lines()
    if rigid:
        ropes = {
            "rigid_ropes": (RigidRope("hoist", (hoist,), 29.01, True), RigidRope("other", (other,), 40.0, hooked=False))
        }
    else:
        ropes = {
            "ropes": (
                Rope("hoist", (hoist,), 1e8, 29.01, 1e4, winch=True),
                Rope("other", (other,), 1e8, 40.0, hooked=False),
            )
        }
    return System((body,), (joint,), contacts=(ground,), gravity=G, **ropes)  # type: ignore[arg-type]


def wind(metres: float) -> Command:
    return lambda s: s.references.set_profile("hoist", s.epoch, 1.0, 0.5, metres)


STORY: list[tuple[int, Command]] = [
    (1, wind(-5.0)),
    (10, lambda s: s.hook("other")),
    (12, lambda s: s.unhook("other")),
    (13, wind(6.0)),
]
END = 25 * SECOND


def play(s: Simulation, after: int = 0, before: int = END) -> list[set[str]]:
    """What is left out behind each command; to the end, if none remains."""
    seen = []
    for t, command in STORY:
        if after <= t < before:
            hand_over(s, t * SECOND)
            command(s)
            s.settle()
            seen.append(set(s.absent))
    if before == END:
        hand_over(s, END)
        s.settle()
    return seen


def rows(s: Simulation) -> np.ndarray:
    return np.array([row for _, row in s.rows])


PADS = {f"pad-{i}" for i in range(4)}


@pytest.mark.parametrize("method", ["dopri5", "radau5"])
@pytest.mark.parametrize(
    ("scene", "bears"), [(on_pads(), PADS), (on_the_ground(), {"ground"})], ids=["pads", "contact"]
)
def test_a_load_in_the_air_needs_no_ground_and_no_bit_changes(scene: System, bears: set[str], method: str) -> None:
    full, lean = (started(scene, lean=lean, method=method, sample_ns=SECOND // 4) for lean in (False, True))
    assert play(full) == [set()] * 4
    assert play(lean) == [{"other"}, bears, {"other", *bears}, {"other", *bears}]
    assert lean.absent == {"other"}  # it is back on the ground
    assert rows(lean).tobytes() == rows(full).tobytes()
    assert lean.log == full.log
    assert [e for e in events(full) if e[1] in ("open", "closed")][-1][1] == "closed"
    empty = lean.operations(frozenset({"other", *bears}))[0]
    assert empty < lean.operations(frozenset(bears))[0] < lean.operations(frozenset())[0]


def test_rigid_ropes_and_contacts_that_are_left_out_change_no_more_than_rounding() -> None:
    full, lean = (started(on_the_ground(rigid=True), lean=lean, sample_ns=SECOND // 4) for lean in (False, True))
    play(full)
    assert play(lean)[2] == {"other", "ground"}
    size = np.abs(rows(full)).max(axis=0) + 1.0
    moving = slice(0, full.method.row_layout.at["peak"].start)
    assert np.abs((rows(lean) - rows(full)) / size)[:, moving].max() < ROUNDING
    assert [(t, e.name, e.what) for t, e in lean.log] == [(t, e.name, e.what) for t, e in full.log]


def test_what_falls_fast_is_never_missed() -> None:
    """Thrown down at 60 m/s from 20 m: the ground is back in the code long before the touch."""
    body, joint = ball("stone", 0.5, 10.0, (0.0, 0.0, 20.0), (0.0, 0.0, -60.0, 0.0, 0.0, 0.0))
    floor = Contact("floor", Ball("stone", radius=0.5), Plane(), 0.0, 0.5)
    scene = System((body,), (joint,), contacts=(floor,), gravity=G)
    full, lean = (started(scene, lean=lean) for lean in (False, True))
    assert lean.absent == {"floor"}
    for s in (full, lean):
        s.run(4 * SECOND)
    assert events(lean)[0] == ("floor", "impact")
    assert lean.log == full.log
    assert rows(lean).tobytes() == rows(full).tobytes()


def test_a_snapshot_keeps_what_is_left_out() -> None:
    first, second = (started(on_pads(), lean=True) for _ in range(2))
    play(first, before=12)
    assert first.absent >= PADS
    second.restore(first.snapshot())
    assert second.absent == first.absent
    for s in (first, second):
        play(s, after=12)
    assert rows(first).tobytes() == rows(second).tobytes()


def test_new_code_is_bought_when_it_would_have_paid() -> None:
    """1000 operations of 10 000 could be spared in each evaluation; the code without them has 60 of its own."""
    laws, none = frozenset({"pads"}), frozenset[str]()
    thrift, rent = Thrift(), 60 * 4e5 / (6 * 1000)

    def count(without: frozenset[str]) -> tuple[int, int]:
        return (9000, 60) if without else (10000, 80)

    assert rent == SPELL
    assert thrift.choose(0.0, laws, count) == none
    assert thrift.choose(0.5 * SPELL, none, count) == none  # half a spell in the air, then on the ground
    assert thrift.choose(5.0 * SPELL, laws, count) == none
    assert thrift.choose(5.4 * SPELL, laws, count) == none
    assert thrift.choose(5.5 * SPELL, laws, count) == laws
    assert thrift.choose(5.6 * SPELL, none, count) == none
    assert thrift.choose(5.7 * SPELL, laws, count) == laws  # what has been bought costs nothing


def test_short_scenes_buy_nothing() -> None:
    s = started(on_pads())
    assert play(s) == [set()] * 4
