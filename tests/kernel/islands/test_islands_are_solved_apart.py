"""Islands that nothing ties together: each takes the steps that it would take alone, and one at rest takes none."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel.compiler.machine_code import Library
from heavylift.kernel.description.mechanics import (
    Body,
    Joint,
    Line,
    Matrix,
    Measured,
    Point,
    Rope,
    Support,
    System,
    Threshold,
    merge,
)
from heavylift.kernel.errors import KernelError
from heavylift.kernel.islands.choice import simulate
from heavylift.kernel.islands.components import islands_of
from heavylift.kernel.islands.islands import Islands
from heavylift.kernel.simulation.simulation import Simulation
from heavylift.nodes.devs.execution.canonical import frozen, thawed

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


# ---- what ties ----------------------------------------------------------------------------------------------


def test_ropes_tie_and_the_ground_does_not() -> None:
    assert bodies(islands_of(TWO)) == [["load-a"], ["load-b"]]
    assert bodies(islands_of(TIED)) == [["load-a", "load-b"]]
    assert bodies(islands_of(TIED, {"tug"})) == [["load-a"], ["load-b"]]


def test_a_loose_rope_belongs_to_its_first_end() -> None:
    a, b = islands_of(TIED, {"tug"})
    assert [r.name for r in a.ropes] == ["rope-a", "tug"]
    assert a.ropes[1].lines[0].b.body == "world"
    assert [r.name for r in b.ropes] == ["rope-b"]
    assert [h.name for h in a.thresholds] == ["height-a"]


def test_a_measured_master_ties_what_may_follow_it_and_nothing_else() -> None:
    still = System((Body("swing", 1.0),), (Joint("pin", "revolute", "world", "swing", axis=(0.0, 1.0, 0.0)),))
    lean = (Measured("lean", "angle", "load-a"),)
    assert bodies(islands_of(replace(merge([TWO, still], G), measured=lean))) == [["load-a", "load-b"], ["swing"]]
    for follower, found in (("rope-a", [["load-a"], ["load-b"]]), ("rope-b", [["load-a", "load-b"]])):
        own = tuple(replace(x, followers=(follower,)) for x in lean)
        assert bodies(islands_of(replace(merge([TWO, still], G), measured=own))) == [*found, ["swing"]]


def test_what_cannot_move_is_no_island() -> None:
    post = System((Body("post", 1.0),), (Joint("foot", "fixed", "world", "post"),))
    assert bodies(islands_of(merge([post, TWO], G))) == [["post", "load-a"], ["load-b"]]


def test_many_small_islands_are_solved_together() -> None:
    many = merge([lift(name, 10.0 * i) for i, name in enumerate("abcdefghijk")], G)
    assert [len(names) for names in bodies(islands_of(many))] == [1, 1, 1, 1, 1, 1, 1, 4]


def chain(name: str, links: int) -> System:
    """A chain of hinged links."""
    bodies = [Body(f"{name}{i}", 1.0, (0.0, 0.0, -1.0)) for i in range(links)]
    above = ["world", *(b.name for b in bodies)]
    joints = [
        Joint(f"pin-{b.name}", "revolute", parent, b.name, (0.0, 0.0, -2.0), axis=(0.0, 1.0, 0.0), q0=(0.1,), v0=(0.0,))
        for parent, b in zip(above, bodies, strict=False)
    ]
    return System(tuple(bodies), tuple(joints))


def test_large_islands_are_apart_however_many() -> None:
    large = [chain(name, 5) for name in "abcdefghij"]
    small = [chain(name, 1) for name in "stuv"]
    assert [len(names) for names in bodies(islands_of(merge([*large, *small], G)))] == [5] * 10 + [4]


def test_equal_islands_are_compiled_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path))
    compiled = []
    compile_ = Library._compile
    monkeypatch.setattr(Library, "_compile", lambda *args: compiled.append(1) or compile_(*args))
    assert len(islands(merge([chain(name, 5) for name in "abcdefghij"], G)).parts) == 10
    assert len(compiled) == 1


def test_equal_islands_share_their_code() -> None:
    a, b = islands(native=False).parts
    assert a.native.structure == b.native.structure


def test_ropes_that_will_be_hooked_tie_from_the_start() -> None:
    for ties, kind in (([], Islands), (["tug"], Simulation)):
        s = simulate(TIED, TOLERANCE, SECOND, frozenset(), "dopri5", None, ties)
        assert type(s) is kind


# ---- steps of their own -------------------------------------------------------------------------------------


def test_each_island_takes_the_steps_that_it_would_take_alone() -> None:
    both = played(islands(), UP)
    assert isinstance(both, Islands)
    for name, part in zip("ab", both.parts, strict=True):
        own = [(t, c) for t, c in UP if c.__closure__ and c.__closure__[1].cell_contents == name]
        alone = played(one(lift(name, 0.0 if name == "a" else 10.0)), own)
        assert isinstance(alone, Simulation)
        assert part.state.tobytes() == alone.state.tobytes()
        assert (part["accepted"], part["rejected"]) == (alone["accepted"], alone["rejected"])
        assert [e for e in both.log if e[1].name.split("-")[1].startswith(name)] == alone.log


def test_islands_show_what_one_simulation_shows() -> None:
    both, whole = played(islands(), UP), played(one(), UP)
    assert [(e.name, e.what) for _, e in both.log] == [(e.name, e.what) for _, e in whole.log]
    (times, rows), (same, expected) = (zip(*grid(s), strict=True) for s in (both, whole))
    assert times == same
    at = whole.method.row_layout.at
    for group in ("q", "tension", "elongation", "poses", "potential"):
        x, y = (np.array(r)[:, at[group]] for r in (rows, expected))
        assert np.abs(x - y).max() < APART * np.abs(y).max(), group


def test_an_island_at_rest_takes_no_steps_and_costs_nothing() -> None:
    s = played(islands(), UP[:1], end=60.0)
    assert isinstance(s, Islands)
    moving, idle = s.parts
    assert idle["accepted"] < 0.1 * moving["accepted"]
    times = [t for t, _ in grid(s)]
    assert times[-1] == 60 * SECOND
    assert sorted(set(times)) == list(range(0, 60 * SECOND + 1, SECOND // 10))  # it is shown all the same


def test_nothing_depends_on_how_far_it_is_allowed_to_go() -> None:
    at_once, in_pieces = played(islands(), UP), played(islands(), UP, pieces=37)
    assert [(t, row.tobytes()) for t, row in in_pieces.rows] == [(t, row.tobytes()) for t, row in at_once.rows]
    assert in_pieces.log == at_once.log


# ---- cut again ----------------------------------------------------------------------------------------------

HOOKED: list[Stage] = [
    (2.0, lambda s: s.hook("tug", L0=10.0)),
    (6.0, lambda s: s.unhook("tug")),
    (16.0, wind("a", -1.0)),
]


def test_a_rope_between_two_makes_them_one_and_what_rests_is_cut_off_again() -> None:
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


def test_a_loose_rope_keeps_its_far_end_for_when_it_is_hooked() -> None:
    """Off the origin of a body of another island: its span is shown, and from there it pulls later."""
    line = Line(Point("load-a", (0.0, 0.1, 0.3)), Point("load-b", (0.2, 0.0, -0.4)))
    scene = replace(TWO, ropes=(*TWO.ropes, Rope("tug", (line,), 1e6, 10.2, 1e4, hooked=False)))
    hooked: list[Stage] = [(2.0, lambda s: s.hook("tug", L0=10.3)), (2.5, wind("a", -1.0))]
    s, whole = played(islands(scene), hooked, end=5.0), played(one(scene), hooked, end=5.0)
    assert ("tug", "taut") in [(e.name, e.what) for _, e in s.log]
    at = whole.method.row_layout.at
    (times, rows), (same, expected) = (zip(*grid(x), strict=True) for x in (s, whole))
    assert times == same
    for group in ("q", "elongation"):
        x, y = (np.array(r)[:, at[group]] for r in (rows, expected))
        assert np.abs(x - y).max() < APART * np.abs(y).max(), group


@pytest.mark.parametrize("t", [1.0, 4.0, 18.0])
def test_a_snapshot_keeps_the_cut(t: float) -> None:
    first, second = (islands(TIED, cut_at_once=True) for _ in range(2))
    before, after = ([x for x in HOOKED if (x[0] <= t) is early] for early in (True, False))
    played(first, before, end=t)
    second.start()
    second.restore(thawed(frozen(first.snapshot())))
    for s in (first, second):
        played(s, after, start=False)
    assert [(at, row.tobytes()) for at, row in second.rows] == [(at, row.tobytes()) for at, row in first.rows]


def test_what_fails_after_an_event_elsewhere_fails_after_it() -> None:
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


def test_a_name_that_nobody_bears_is_told() -> None:
    s = islands()
    s.start()
    with pytest.raises(KernelError, match="'rope-c': no drive, winch or master of this name"):
        s.set_profile("rope-c", 0, 1.0, 1.0, 1.0)
    with pytest.raises(KernelError, match="'rope-c': no rope of this name"):
        s.unhook("rope-c")
