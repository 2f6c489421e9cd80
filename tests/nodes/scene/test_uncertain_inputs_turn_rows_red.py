"""Uncertain inputs change every limit check: the worst corner is used at rest and in a run."""

from __future__ import annotations

from itertools import product
from math import isfinite
from pathlib import Path
from random import Random

import pytest
from heavylift.coordinator.record import play
from heavylift.nodes.plan import RatedLimit, Use
from heavylift.nodes.scene import LoadedScene, load, new_scene_with, parse
from heavylift.nodes.scene.text import library
from lifting import bare, unstated

HEAD = "name,mass [t],size x [m],size y [m],size z [m]\n"


def begun(crane: str, folder: Path) -> str:
    """A lift by a crane of a type."""
    long, wide = (30, 24) if crane.startswith(("goliath", "twin", "mobile")) else (6, 5)
    (folder / "blocks.csv").write_text(f"{HEAD}B,10,{long},{wide},4\n", encoding="utf-8")
    (text,) = new_scene_with("made", crane, "blocks.csv#B").values()
    return unstated(text)


def uses(scene: LoadedScene) -> dict[tuple[str, str], float]:
    found = {(x.limit.subject, x.limit.quantity): x.use for x in scene.uses}
    return {key: use for key, use in found.items() if use is not None and isfinite(use)}


@pytest.mark.parametrize("crane", sorted(library()))
def test_each_limit_of_each_type_is_checked_at_the_worst_corner_of_uncertain_inputs(
    crane: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Mass and centre of mass, each alone and all corners written out."""
    monkeypatch.chdir(tmp_path)
    random = Random(crane)
    text, name = begun(crane, tmp_path), str(tmp_path / "made.yaml")
    mass, lateral = random.uniform(1.0, 9.0), random.uniform(0.05, 0.5)
    half = mass * random.uniform(0.01, 0.2)
    com = "block.com=[{} m, 0 m, 0 m]"
    stated = [f"block.mass=10 t +- {half!r} t", com.format(f"0 m +- {lateral!r}").replace("m m", "m")]
    scene = parse(text, name, stated)
    corners = [
        uses(parse(text, name, [f"block.mass={10.0 + m!r} t", com.format(repr(x))]))
        for m, x in product((-half, half, 0.0), (-lateral, lateral, 0.0))
    ]
    seen = 0
    for use in scene.uses:
        key = (use.limit.subject, use.limit.quantity)
        if use.use is not None and isfinite(use.use) and use.limit.known:
            most = max(found.get(key, 0.0) for found in corners)  # of a slack sling nothing
            assert use.at_worst.use == pytest.approx(max(most, use.use), rel=1e-5, abs=1e-5), key
            seen += most > use.use * 1.001
            message = "block.mass 10 t" in use.limit.inputs or "block.com" in use.limit.inputs
            assert message == (use.limit.spread > 0.0)
    assert seen > 2


def test_a_value_beyond_its_limit_only_in_the_worst_combination_of_inputs_gives_a_red_check_with_that_combination() -> (
    None
):
    """510 t use 97.0 % of a sling, 536 t 101.8 %; that a wider spread changes no value is seen beside."""
    narrow, wide = (bare("lift", [f"block.mass=510 t +- {part} %", "end=90 s"]) for part in (2, 5))
    assert [x.value for x in narrow.uses] == [x.value for x in wide.uses]
    red = {c.subject: c for c in wide.checks if c.state == "red"}
    assert [*red] == ["loader-3.sling-1", "loader-3.sling-2"]
    assert not [c for c in narrow.checks if c.state == "red"]
    row = red["loader-3.sling-1"]
    assert "block.mass 510 t +- 5 %" in row.basis
    assert "at worst" in row.shown
    assert "at the worst of block.mass 510 t +- 5 %" in row.sentence
    nominal = next(x for x in wide.uses if x.limit.subject == row.subject and x.limit.quantity == row.quantity)
    assert row.use == pytest.approx(1.05 * (nominal.use or 0.0), rel=2e-3)


def test_run_and_static_check_use_the_same_extreme_combinations_of_uncertain_inputs() -> None:
    scene = bare("lift", ["block.mass=510 t +- 5 %", "end=90 s"])
    run = play(scene.plan)
    red = [f.sentence for f in run.verdict.findings if f.state == "red"]
    assert len(red) == 2
    assert all("at the worst of block.mass 510 t +- 5 %" in x for x in red)
    peaks = [x.limit for x in run.uses if x.limit.quantity == "sling peak"]
    tensions = {x.subject: x for x in scene.plan.limits if x.quantity == "sling tension"}
    assert [x.spread for x in peaks] == [tensions[x.subject].spread for x in peaks]


def test_an_uncertain_input_without_equilibrium_at_its_bounds_is_listed() -> None:
    """Slings of 3.1 m do not reach their lugs."""
    scene = load("hall", ["rigging.legs.length=6.5 m +- 3.4 m"])
    lost = next(c for c in scene.checks if c.quantity == "inputs")
    assert (lost.subject, lost.state) == ("rigging.legs.length 3.1 m", "amber")
    assert "limits are not known there: " in lost.sentence


@pytest.mark.parametrize("least", [False, True])
def test_the_worst_combination_of_uncertain_inputs_is_that_of_the_highest_utilisation(least: bool) -> None:
    for seed in range(50):
        random = Random(seed)
        bound, value, spread = (random.uniform(1.0, 9.0) for _ in range(3))
        unit = random.choice(("N", "m"))
        given = {"value": bound, "least": least, "spread": spread, "adds": unit == "m"}
        limit = RatedLimit(subject="a", quantity="signal", unit=unit, inputs="b", **given)
        worst = Use(limit, value, use=limit.use(value)).at_worst
        assert worst.value is not None
        assert limit.use(worst.value) == pytest.approx(worst.use)
        assert worst.use == pytest.approx(limit.use(value) * (1 + spread) if unit == "N" else limit.use(value) + spread)
