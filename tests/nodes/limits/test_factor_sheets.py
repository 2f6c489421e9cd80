"""Design loads are loads at rest times the factors of the sheet, of any crane and rigging, at rest and in a run."""

from __future__ import annotations

from itertools import product
from math import prod, radians, sin, sqrt
from pathlib import Path
from random import Random

import pytest
from heavylift.coordinator.record import play
from heavylift.kernel import SceneError
from heavylift.kernel.description import Point, System
from heavylift.nodes.limits import BASES, PRACTICES, daf, tilted
from heavylift.nodes.plan import Cargo, Hoist, Mechanism, Plan, RatedLimit, Tie, Use
from heavylift.nodes.scene import LoadedScene, load, new_scene_with, parse
from heavylift.nodes.scene.text import library
from heavylift.nodes.statics import StaticState
from lifting import bare, unstated

HEAD = "name,mass [t],size x [m],size y [m],size z [m]\n"
NUMBERS = ("weight", "dynamic", "tilt factor", "heights", "yaw", "skew", "consequence")


def begun(crane: str, folder: Path) -> str:
    long, wide = (30, 24) if crane.startswith(("goliath", "twin", "mobile")) else (6, 5)
    (folder / "blocks.csv").write_text(f"{HEAD}B,10,{long},{wide},4\n", encoding="utf-8")
    (text,) = new_scene_with("made", crane, "blocks.csv#B").values()
    return unstated(text)


def values(scene: LoadedScene) -> dict[tuple[str, str], float]:
    return {(x.limit.subject, x.limit.quantity): x.value for x in scene.uses if x.value is not None}


def used(scene: LoadedScene) -> dict[tuple[str, str], float]:
    """By a chart the radius counts, too."""
    return values(scene) | {(x.limit.subject, x.limit.quantity): x.use for x in scene.uses if x.use is not None}


def designs(uses: list[Use]) -> list[Use]:
    return [x for x in uses if x.limit.quantity in BASES]


@pytest.mark.parametrize("crane", sorted(library()))
def test_a_design_load_is_the_load_at_rest_times_its_factors(
    crane: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    random = Random(crane)
    text, name = begun(crane, tmp_path), str(tmp_path / "made.yaml")
    given = {key: random.uniform(1.0, 1.4) for key in NUMBERS}
    half = [random.uniform(0.05, 0.3), random.uniform(0.05, 0.3), 0.0]
    keys = ", ".join(f"{key}: {x!r}" for key, x in given.items())
    box = ", ".join(f"{x!r} m" for x in half)
    sets = [f"factors={{{keys}, rigging: 0 t, cog: [{box}], wind: 10 m/s, area: 20 m2, dynamics: not included}}"]
    scene = parse(text, name, [*sets, "block.lug capacity=20 t"])
    corners = [
        used(parse(text, name, [f"block.com=[{x * half[0]!r} m, {y * half[1]!r} m, 0 m]", "block.lug capacity=20 t"]))
        for x, y in product((-1, 1), (-1, 1))
    ]
    rest, level, kinds = values(scene), used(scene), set[str]()
    wind = sqrt(1.0 + (0.5 * 1.25 * 1.2 * 20.0 * 100.0 / (10e3 * scene.plan.gravity)) ** 2)
    for use in designs(scene.uses):
        key = (use.limit.subject, BASES[use.limit.quantity])
        factors = {x.name: x.value for x in use.limit.factors}
        kinds.add(use.limit.quantity)
        assert use.limit.rest is not None
        assert use.limit.rest.value == rest[key]
        most = max(1.0, *(found.get(key, 0.0) / level[key] for found in corners))
        assert factors["cog"] == pytest.approx(most, rel=1e-5)
        assert factors["wind"] == pytest.approx(wind)
        assert ("consequence" in factors) == (use.limit.quantity == "lug design load")
        assert not {"yaw", "skew"} & factors.keys() or use.limit.quantity != "hook design load"
        named = {x: given[f"{x} factor" if x == "tilt" else x] for x in factors.keys() - {"cog", "wind"}}
        assert {x: factors[x] for x in named} == named
        assert use.value == pytest.approx(rest[key] * prod(factors.values()))
        if use.limit.known:
            assert use.use == pytest.approx((use.value or 0.0) / (use.bound or use.limit.value or 0.0))
    assert kinds >= {"hook design load", "sling design load", "lug design load"}
    assert not [x for x in scene.plan.limits if x.quantity == "factor"]


@pytest.mark.parametrize("crane", sorted(library()))
def test_a_factor_that_is_missing_in_a_factor_sheet_gives_an_amber_check_without_a_value(
    crane: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text, name = begun(crane, tmp_path), str(tmp_path / "made.yaml")
    (bare,) = (c for c in parse(text, name).checks if c.quantity == "factor sheet")
    assert (bare.state, bare.why) == ("amber", "not checked")
    scene = parse(text, name, ["practice=0027/ND"])
    missing = {c.subject: c for c in scene.checks if c.quantity == "factor"}
    assert {"weight", "cog", "wind", "dynamics"} <= missing.keys()
    assert all((c.state, c.value) == ("amber", None) for c in missing.values())
    used = {x.name: x.source for limit in scene.plan.limits for x in limit.factors}
    assert not used.keys() & missing.keys()
    assert all("0027/ND rev 11.2" in source for source in used.values())
    assert not [c for c in scene.checks if c.quantity == "factor sheet"]


def test_dynamic_factors_depend_on_the_place_and_mass_of_a_lift() -> None:
    """0027/ND, table 5-1."""
    assert daf("onshore", 50e3) == (1.10, "0027/ND rev 11.2, table 5-1, onshore")
    found = [
        (daf(place, mass) or (0.0, ""))[0] for place in ("inshore", "offshore") for mass in (25e3, 1e3, 300e3, 9e6)
    ]
    expected = [1.07 + 0.05 * 2, 1.07 + 0.05 * sqrt(100 / 3), 1.12, 1.05, 1.5, 1 + 0.25 * sqrt(100 / 3), 1.25, 1.10]
    assert found == pytest.approx(expected)
    assert daf(None, 50e3) is None
    assert bare("floating").plan.place is None
    message = [c for c in bare("floating", ["practice=0027/ND"]).checks if c.quantity == "factor"]
    assert "dynamic" in [c.subject for c in message]


def test_load_shares_of_two_tilted_hooks_are_those_of_the_standard() -> None:
    """0027/ND, B.1.2, with the centre of mass where its envelope is worst for each hook."""
    length, c, d, a, b, x, z, tilt = 25.0, 12.0, 13.0, 10.0, 14.0, 0.9, 0.8, radians(3.0)
    for mine, com, level, expected in ((0, -x, (d + x) / length, 0.58214), (1, x, (c + x) / length, 0.54320)):
        lugs = {"P1": (-c, 0.0, a), "P2": (d, 0.0, b)}
        ends = {name: (p[0], 0.0, 60.0) for name, p in lugs.items()}
        hooks = tuple(Hoist(rope=f"h{i}", eye=Point(f"e{i}"), block_mass=0.0) for i in (1, 2))
        ties = tuple(Tie(rope=f"s{i}", upper=Point(f"e{i}"), lug=f"P{i}") for i in (1, 2))
        load_ = Cargo(body="B", mass=1e3, com=(com, 0.0, -z), lugs=lugs)
        plan = Plan(name="x", machines=(Mechanism(name="m", system=System(), hooks=hooks, ties=ties, cargo=(load_,)),))
        R = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        poses = {"B": ((0.0, 0.0, 0.0), R), **{f"e{i}": (ends[f"P{i}"], R) for i in (1, 2)}}
        state = StaticState(
            1.0, 1, "up", "", {"s1": 1.0, "s2": 1.0, "h1": 1.0, "h2": 1.0}, {}, poses, {}, {}, {},
            {"s1": "P1", "s2": "P2"}, False, None,
        )  # fmt: skip
        limit = RatedLimit(subject="s", quantity="hook load", unit="kg", elements=(f"h{mine + 1}",))
        found = tilted(plan, ("h1", "h2"), limit, [state], sin(tilt), 0.0)
        assert found is not None
        assert found * level == pytest.approx(expected, abs=5e-5)


def test_a_run_checks_the_larger_of_predicted_and_simulated_design_load() -> None:
    for dynamic, required in ((1.0, False), (1.5, True)):
        sets = [f"factors={{weight: 1.1, cog: [0 m, 0 m, 0 m], dynamic: {dynamic}, wind: 0 m/s}}", "end=60 s"]
        run = play(bare("lift", sets).plan)
        met = {(x.limit.subject, x.limit.quantity): x.value for x in run.uses}
        slings = [x for x in run.uses if x.limit.quantity == "sling design load"]
        assert len(slings) == 6
        for use in slings:
            assert use.limit.rest is not None
            assert met[use.limit.subject, "sling tension"]
            simulated = 1.1 * (met[use.limit.subject, "sling tension"] or 0.0)
            expected = 1.1 * dynamic * use.limit.rest.value
            assert use.value == pytest.approx(max(simulated, expected))
            assert (expected > simulated) == required
        printed = [row[1] for x in run.verdict.tables if x.title.startswith("Design loads") for row in x.rows]
        assert sorted(map(str, printed)) == sorted(x.limit.subject for x in designs([*run.uses]))


def test_a_design_load_above_its_limit_gives_a_red_check_that_states_the_product_of_its_factors() -> None:
    scene = load("crawler", ["practice=0027/ND", "block.lug capacity=25 t", "factors={weight: 1.1}"])
    message = [f.sentence for f in scene.findings if f.quantity == "lug design load"]
    assert len(message) == 4
    assert "16.8 t x weight 1.1 x dynamic 1.1 x skew 1.25 x consequence 1.3" in message[0]


def test_each_factor_of_a_bundled_standard_is_listed_with_its_clause() -> None:
    for clauses in PRACTICES.values():
        for clause in clauses.values():
            assert any(c.isdigit() for c in clause.source)


FACTORS = ["weight", "cog factor", "dynamic", "tilt factor", "heights", "yaw", "skew", "consequence", "tandem"]


@pytest.mark.parametrize("key", [*(f"factors.{name}" for name in FACTORS), "limits.impact", "rig.sling.factor"])
def test_a_factor_of_safety_below_one_in_a_scene_is_refused(key: str) -> None:
    with pytest.raises(SceneError, match=r"must be 1 or more here, not 0\.9"):
        load("lift", [f"{key}=0.9"])
