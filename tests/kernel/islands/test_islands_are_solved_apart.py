"""Uncoupled islands take the steps that each takes alone; an island at rest takes none."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from random import Random

import pytest
from heavylift.kernel.compiler import Library
from heavylift.kernel.description import Body, Joint, Measured, System, merge
from heavylift.kernel.islands import Islands, islands_of, simulate
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.simulation.native import labels
from two_loads import SECOND, TIED, TOLERANCE, TWO, UP, G, assert_alike, bodies, grid, islands, lift, one, played, wind

# ---- what ties ----------------------------------------------------------------------------------------------


def test_bodies_joined_by_ropes_form_one_island_and_bodies_joined_only_to_the_ground_do_not() -> None:
    assert bodies(islands_of(TWO)) == [["load-a"], ["load-b"]]
    assert bodies(islands_of(TIED)) == [["load-a", "load-b"]]
    assert bodies(islands_of(TIED, {"tug"})) == [["load-a"], ["load-b"]]


def test_a_rope_that_is_not_hooked_belongs_to_the_island_of_its_first_end() -> None:
    a, b = islands_of(TIED, {"tug"})
    assert [r.name for r in a.ropes] == ["rope-a", "tug"]
    assert a.ropes[1].lines[0].b.body == "world"
    assert [r.name for r in b.ropes] == ["rope-b"]
    assert [h.name for h in a.thresholds] == ["height-a"]


def test_actuators_that_may_follow_a_measured_angle_join_the_island_of_the_measured_body() -> None:
    still = System((Body("swing", 1.0),), (Joint("pin", "revolute", "world", "swing", axis=(0.0, 1.0, 0.0)),))
    lean = (Measured("lean", "angle", "load-a"),)
    assert bodies(islands_of(replace(merge([TWO, still], G), measured=lean))) == [["load-a", "load-b"], ["swing"]]
    for follower, found in (("rope-a", [["load-a"], ["load-b"]]), ("rope-b", [["load-a", "load-b"]])):
        own = tuple(replace(x, followers=(follower,)) for x in lean)
        assert bodies(islands_of(replace(merge([TWO, still], G), measured=own))) == [*found, ["swing"]]


def test_a_body_that_cannot_move_forms_no_island() -> None:
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


def test_islands_do_not_influence_each_other() -> None:
    many = [chain(name, links) for name, links in zip("abcdefghijklmn", [5] * 10 + [1] * 4, strict=True)]
    assert [len(names) for names in bodies(islands_of(merge(many, G)))] == [5] * 10 + [1] * 4


def test_islands_of_equal_bodies_are_compiled_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path))
    compiled, compile_ = [], Library._compile
    monkeypatch.setattr(Library, "_compile", lambda *args: compiled.append(1) or compile_(*args))
    assert len(islands(merge([chain(name, 5) for name in "abcdefghij"], G)).parts) == 10
    assert len(compiled) == 1


def test_islands_of_equal_bodies_share_machine_code() -> None:
    a, b = islands(native=False).parts
    assert a.native.structure == b.native.structure


def test_bodies_that_an_unhooked_rope_may_couple_later_share_an_island_from_the_start() -> None:
    for ties, kind in (([], Islands), (["tug"], Simulation)):
        s = simulate(TIED, TOLERANCE, SECOND, frozenset(), "dopri5", None, ties)
        assert type(s) is kind


# ---- steps of their own -------------------------------------------------------------------------------------


def test_an_island_takes_the_same_steps_with_and_without_other_islands() -> None:
    both = played(islands(), UP)
    assert isinstance(both, Islands)
    for name, part in zip("ab", both.parts, strict=True):
        own = [(t, c) for t, c in UP if c.__closure__ and c.__closure__[1].cell_contents == name]
        alone = played(one(lift(name, 0.0 if name == "a" else 10.0)), own)
        assert part.state.tobytes() == alone.state.tobytes()
        assert (part["accepted"], part["rejected"]) == (alone["accepted"], alone["rejected"])
        assert [e for e in both.log if e[1].name.split("-")[1].startswith(name)] == alone.log


def test_a_simulation_divided_into_islands_gives_the_samples_of_an_undivided_one() -> None:
    both, whole = played(islands(), UP), played(one(), UP)
    assert [(e.name, e.what) for _, e in both.log] == [(e.name, e.what) for _, e in whole.log]
    assert_alike(both, whole, "q", "tension", "elongation", "poses", "potential")


def test_an_island_at_rest_takes_no_integration_steps() -> None:
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
            promised = s.next_ns, s.event
            heard.append(s.shown(t).tobytes())
            assert (s.next_ns, s.event) == promised
        if orders or t == 6 * SECOND:
            s.interrupt(t)
            for name, speed in orders:
                s.set_profile(f"rope-{name}", t, speed, 0.5, None)
            s.settle()
    rows = [[(t, row.tobytes()) for t, row in x.rows] for x in (s, *s.lifts)]
    return [rows, s.log, [p["accepted"] for p in s.parts], heard]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.large(beyond=2)
def test_the_division_of_calls_to_islands_and_additional_observers_change_no_result(seed: int) -> None:
    random = Random(seed)
    commands = [
        (random.randrange(SECOND, 5 * SECOND), random.choice("ab"), random.uniform(-1.0, 0.5)) for _ in range(6)
    ]
    alone = answered(commands, None)
    assert [answered(commands, Random(seed + i))[:3] for i in (1, 2)] == [alone[:3]] * 2
    listening = answered(commands, None, SECOND // 8)
    assert [answered(commands, Random(seed + i), SECOND // 8) for i in (3, 4)] == [listening] * 2
    assert listening[:3] == alone[:3]


def test_commands_to_one_lift_do_not_undo_the_steps_that_others_ran_ahead(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of many lifts, each is started by a command of its own; the rows of all at each command cost few steps more."""
    many, taken = range(8), list[float]()
    advance = Simulation._advance

    def counted(self: Simulation, horizon: float) -> None:
        before = self.native.attempts
        advance(self, horizon)
        taken.append(self.native.attempts - before)

    monkeypatch.setattr(Simulation, "_advance", counted)
    system = merge([lift(f"{i}", 10.0 * i) for i in many], G)
    s = played(islands(system), [(1.0 + 0.1 * i, wind(f"{i}", -3.0)) for i in many])
    assert isinstance(s, Islands)
    assert sum(taken) < 2.0 * sum(p.native.attempts for p in s.parts)


# ---- rows of one alone -----------------------------------------------------------------------------------------


def test_an_event_in_one_lift_adds_a_sample_row_only_to_the_island_of_that_lift() -> None:
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


def test_lifts_that_interlocks_may_couple_share_their_sample_rows() -> None:
    assert islands(lifts={"a": ["load-a"], "b": ["load-b"]}).lifts[0].name == "a"
    assert not islands(TIED, lifts={"a": ["load-a"], "b": ["load-b"]}).lifts
    three = merge([TIED, lift("c", 20.0)], G)
    lifts = {name: [f"load-{name}"] for name in "abc"}
    assert [x.name for x in islands(three, lifts=lifts).lifts] == ["a+b", "c"]
