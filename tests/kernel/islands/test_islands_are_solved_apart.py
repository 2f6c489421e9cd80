"""Islands that nothing ties together: each takes the steps that it would take alone, and one at rest takes none."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from random import Random

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
from heavylift.kernel.simulation.native.sample_row import labels
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


def assert_alike(s: Simulation | Islands, whole: Simulation | Islands, *groups: str) -> None:
    """The same columns of their rows, but for steps that are not the same."""
    (times, rows), (same, expected) = (zip(*grid(x), strict=True) for x in (s, whole))
    assert times == same
    for group in groups:
        x, y = (np.array(r)[:, whole.method.row_layout.at[group]] for r in (rows, expected))
        assert np.abs(x - y).max() < APART * np.abs(y).max(), group


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


def chain(name: str, links: int) -> System:
    """A chain of hinged links."""
    bodies = [Body(f"{name}{i}", 1.0, (0.0, 0.0, -1.0)) for i in range(links)]
    above = ["world", *(b.name for b in bodies)]
    joints = [
        Joint(f"pin-{b.name}", "revolute", parent, b.name, (0.0, 0.0, -2.0), axis=(0.0, 1.0, 0.0), q0=(0.1,), v0=(0.0,))
        for parent, b in zip(above, bodies, strict=False)
    ]
    return System(tuple(bodies), tuple(joints))


def test_islands_are_apart_however_many() -> None:
    many = [chain(name, links) for name, links in zip("abcdefghijklmn", [5] * 10 + [1] * 4, strict=True)]
    assert [len(names) for names in bodies(islands_of(merge(many, G)))] == [5] * 10 + [1] * 4


def test_equal_islands_are_compiled_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path))
    compiled, compile_ = [], Library._compile
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
        assert part.state.tobytes() == alone.state.tobytes()
        assert (part["accepted"], part["rejected"]) == (alone["accepted"], alone["rejected"])
        assert [e for e in both.log if e[1].name.split("-")[1].startswith(name)] == alone.log


def test_islands_show_what_one_simulation_shows() -> None:
    both, whole = played(islands(), UP), played(one(), UP)
    assert [(e.name, e.what) for _, e in both.log] == [(e.name, e.what) for _, e in whole.log]
    assert_alike(both, whole, "q", "tension", "elongation", "poses", "potential")


def test_an_island_at_rest_takes_no_steps_and_costs_nothing() -> None:
    s = played(islands(), UP[:1], end=60.0)
    assert isinstance(s, Islands)
    moving, idle = s.parts
    assert idle["accepted"] < 0.1 * moving["accepted"]
    times = [t for t, _ in grid(s)]
    assert times[-1] == 60 * SECOND
    assert sorted(set(times)) == list(range(0, 60 * SECOND + 1, SECOND // 10))  # it is shown all the same


def answered(commands: list[tuple[int, str, float]], cuts: Random | None, period: int = 0) -> list[object]:
    """Winches are led to a speed at a time, and to that of the other load as soon as one is at 2 m; runs are cut at
    random, and somebody listens every `period` [ns].  All that is seen of it, what was listened to last."""
    s, heard = islands(subscribed=frozenset({"height-a", "height-b"}), lifts={"a": ["load-a"], "b": ["load-b"]}), []
    s.start()
    for name in "ab":
        s.watch(f"height-{name}", 2.0, True)
    s.settle()
    due: dict[int, list[tuple[str, float]]] = {t: [] for t in range(0, 6 * SECOND + 1, period or 6 * SECOND)}
    for t, name, speed in commands:
        due.setdefault(t, []).append((name, speed))
    for t, orders in sorted(due.items()):
        while True:
            while cuts and cuts.random() < 0.6:
                s.run(cuts.randrange(t + 1))
            s.run(t)
            if not s.event or s.next_ns > t:
                break
            for e in s.fire():
                s.set_profile("rope-b" if e.name == "height-a" else "rope-a", s.epoch, -0.3, 0.5, None)
            s.settle()
        if period and t % period == 0:
            heard.append(s.shown(t).tobytes())
        if orders or t == 6 * SECOND:
            s.interrupt(t)
            for name, speed in orders:
                s.set_profile(f"rope-{name}", t, speed, 0.5, None)
            s.settle()
    rows = [[(t, row.tobytes()) for t, row in x.rows] for x in (s, *s.lifts)]
    return [rows, s.log, [p["accepted"] for p in s.parts], heard]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.large(beyond=2)
def test_nothing_depends_on_how_calls_are_cut_nor_on_who_listens(seed: int) -> None:
    random = Random(seed)
    commands = [
        (random.randrange(SECOND, 5 * SECOND), random.choice("ab"), random.uniform(-1.0, 0.5)) for _ in range(6)
    ]
    alone = answered(commands, None)
    assert [answered(commands, Random(seed + i))[:3] for i in (1, 2)] == [alone[:3]] * 2
    listening = answered(commands, None, SECOND // 8)
    assert [answered(commands, Random(seed + i), SECOND // 8) for i in (3, 4)] == [listening] * 2
    assert listening[:3] == alone[:3]


# ---- rows of one alone -----------------------------------------------------------------------------------------


def test_an_event_of_one_lift_leaves_a_row_of_it_alone() -> None:
    """The common samples and the rows of its own are, byte for byte, those of the lift by itself; peaks count on until
    the next sample of all, energies and steps are those of all there."""
    both = played(islands(lifts={"a": ["load-a"], "b": ["load-b"]}), UP)
    assert isinstance(both, Islands)
    *samples, _, (end, _) = both.rows  # the last sample is shown again where all stand
    assert [t for t, _ in samples] == [i * SECOND // 10 for i in range(200)]
    for lift_rows, place, own in zip(both.lifts, (0.0, 10.0), (UP[::2], UP[1:2]), strict=True):
        alone = played(one(lift(lift_rows.name, place)), own)
        counted = [
            x for x in labels(alone.program) if x[0] not in ("peak", "peak_time", "kinetic", "potential", "steps")
        ]
        here, there, whole = (
            [labels(p).index(x) for x in counted] for p in (alone.program, lift_rows.method.program, both.program)
        )
        found = [(t, row[there].tobytes()) for t, row in lift_rows.rows]
        found += [(t, row[whole].tobytes()) for t, row in samples]
        assert sorted(found) == sorted((t, row[here].tobytes()) for t, row in alone.rows if t < end)
        assert len(lift_rows.rows) >= len(own)


def test_lifts_that_something_may_tie_have_their_rows_in_common() -> None:
    assert islands(lifts={"a": ["load-a"], "b": ["load-b"]}).lifts[0].name == "a"
    assert not islands(TIED, lifts={"a": ["load-a"], "b": ["load-b"]}).lifts
    three = merge([TIED, lift("c", 20.0)], G)
    lifts = {name: [f"load-{name}"] for name in "abc"}
    assert [x.name for x in islands(three, lifts=lifts).lifts] == ["a+b", "c"]


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
    assert_alike(s, whole, "q", "elongation")


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
