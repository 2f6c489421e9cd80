"""Contingencies, uncertain inputs, rigging and stated wind count in each row of what bears the load, of any crane."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest
from heavylift.nodes.limits import BASES
from heavylift.nodes.scene import LoadedScene, load, new_scene_with, parse
from heavylift.nodes.scene.text import library

HEAD = "name,mass [t],size x [m],size y [m],size z [m]\n"
MASS = 10.0  # [t]
CLOSE = 2e-3  # of a utilisation: stretch, which is not in proportion to the load
STANDING = ("ground pressure", "wheel load")
WHOLE = ("crane load", "trolley load", "tandem load", "loader load", "sling tension", "assembly load", "support load")


def begun(crane: str, folder: Path, rows: str = f"B,{MASS:g},") -> str:
    long, wide = (30, 24) if crane.startswith(("goliath", "twin", "mobile")) else (6, 5)
    (folder / "blocks.csv").write_text(f"{HEAD}{rows}{long},{wide},4\n", encoding="utf-8")
    (text,) = new_scene_with("made", crane, "blocks.csv#B").values()
    return text


def worst(scene: LoadedScene) -> dict[tuple[str, str], float]:
    uses = (use.at_worst for use in scene.uses)
    return {(use.limit.quantity, use.limit.subject): use.use for use in uses if use.use}


@pytest.fixture(params=sorted(library()))
def crane(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    return str(request.param)


def test_a_contingency_on_the_weight_acts_on_all_checks_like_a_heavier_block(crane: str, tmp_path: Path) -> None:
    """At least as a block so much heavier, as the mass of frames and hook blocks grows with it; a footing does not."""
    more = Random(crane).uniform(1.05, 1.3)
    text = begun(crane, tmp_path)
    sheet = "factors={{rigging: 0 t, weight: {}, cog factor: 1, dynamics: included, wind: 0 m/s}}"
    plain, one = (worst(parse(text, "made.yaml", [sheet.format(x)])) for x in (1, more))
    other = worst(parse(text, "made.yaml", [sheet.format(1), f"block.mass={MASS * more!r} t"]))
    shared = [key for key in one if key[0] in (*WHOLE, *STANDING)]
    assert {quantity for quantity, _ in shared} >= {"sling tension", "support load"}
    for key in shared:
        assert other[key] * (1 - CLOSE) <= one[key] <= more * plain[key] * (1 + CLOSE), key


def test_the_uncertainty_of_a_mass_is_included_in_design_loads(crane: str, tmp_path: Path) -> None:
    text, half = begun(crane, tmp_path), Random(crane).uniform(0.05, 0.2)
    sheet = "factors={rigging: 0 t, weight: 1.03, cog factor: 1.1, dynamics: included, wind: 0 m/s}"
    one = worst(parse(text, "made.yaml", [sheet, f"block.mass={MASS:g} t +- {100 * half!r} %"]))
    other = worst(parse(text, "made.yaml", [sheet, f"block.mass={MASS * (1 + half)!r} t"]))
    designs = [key for key in one if key[0] in BASES]
    assert {quantity for quantity, _ in designs} >= {"hook design load", "sling design load", "lug design load"}
    for key in designs:
        assert one[key] == pytest.approx(other[key], rel=CLOSE), key


def test_weight_contingencies_and_uncertain_inputs_are_combined_in_design_loads(crane: str, tmp_path: Path) -> None:
    """At least as the heaviest block does that both allow, also where the unloaded crane is what presses hardest."""
    text, random = begun(crane, tmp_path), Random(crane)
    half, more = random.uniform(0.05, 0.2), random.uniform(1.1, 1.4)
    sheet = "factors={{rigging: 0 t, weight: {}, cog factor: 1, dynamics: included, wind: 0 m/s}}"
    one = worst(parse(text, "made.yaml", [sheet.format(more), f"block.mass={MASS:g} t +- {100 * half!r} %"]))
    other = worst(parse(text, "made.yaml", [sheet.format(1), f"block.mass={MASS * (1 + half) * more!r} t"]))
    for key in (key for key in other if key[0] in (*WHOLE, *STANDING, "uplift", "interlock")):
        assert one[key] >= other[key] * (1 - CLOSE), key


def test_a_stated_wind_is_checked_against_the_limit_of_the_crane(crane: str, tmp_path: Path) -> None:
    text = begun(crane, tmp_path)
    for wind, state in ((1.0, "green"), (60.0, "red")):
        scene = parse(text, "made.yaml", [f"factors.wind={wind:g} m/s"])
        (row,) = (check for check in scene.checks if check.quantity == "wind")
        assert (row.value, row.state) == (wind, state if "known" not in row.allowed else "amber")


def test_the_stronger_of_the_stated_and_the_modelled_wind_counts() -> None:
    for stated, modelled in ((25.0, 3.0), (3.0, 25.0)):
        sets = [f"factors.wind={stated} m/s", f"wind={{speed: {modelled} m/s, direction: [1, 0, 0]}}"]
        (row,) = (check for check in load("jib", sets).checks if (check.quantity, check.subject) == ("wind", "jib"))
        assert (row.value, row.state) == (25.0, "red")


GEAR = "gear={G: {kind: sling, EA: 60 MN, breaking: 9 MN, diameter: 100 mm, termination: resin, mass: %g kg}}"


def test_a_sling_that_is_hooked_to_other_lugs_later_counts_once() -> None:
    text, again = load("jib").text, "    legs: unhook\n  - stage: again\n    legs: hook [M1, M2, M3, M4]\n"
    assert "  lugs: {" in text
    places = zip(range(1, 5), ("-2 m, 1.5 m", "2 m, 1.5 m", "-2 m, -1.5 m", "2 m, -1.5 m"), strict=True)
    lugs = "  lugs: {" + "".join(f"M{i}: [{place}, 1.6 m], " for i, place in places)
    for scene in (text, text.replace("  lugs: {", lugs).replace("    legs: unhook\n", again)):
        plan = parse(scene, "made.yaml", [GEAR % 100, "rigging.legs.sling={gear: G}", "factors={wind: 0 m/s}"]).plan
        (limit,) = (x for x in plan.limits if x.quantity == "hook load")
        assert limit.rigging == 4 * 100.0


def test_the_mass_of_slings_below_a_frame_is_shared_by_its_hooks() -> None:
    sets = [GEAR % 1000, "rigging.front.sling={gear: G}", "factors={weight: 1, cog factor: 1, wind: 0 m/s}"]
    rows = {(x.quantity, x.subject): x.rigging for x in load("spreader", sets).plan.limits if x.rigging}
    assert (
        rows["crane load", "crane"] == sum(x for (quantity, _), x in rows.items() if quantity == "hook load") == 2000.0
    )


def test_the_mass_of_slings_and_shackles_counts_in_hook_loads_and_ground_pressure() -> None:
    """0.55 t on a hook with a block of 60 t and 3 t of its own; without them their mass is not checked."""
    sheet = "factors={{{}weight: 1, cog factor: 1, dynamics: included, wind: 0 m/s}}"
    with_, without, unknown = (load("crawler", [sheet.format(x)]) for x in ("rigging: 0.55 t, ", "rigging: 0 t, ", ""))
    values = {use.limit.quantity: use.value for use in with_.uses}
    assert values["hook load"] == pytest.approx(60e3 + 3e3 + 550.0, rel=1e-6)
    heavy, light = worst(with_), worst(without)
    for quantity in ("ground pressure", "uplift"):
        assert all(heavy[key] > light[key] for key in heavy if key[0] == quantity)
    (row,) = (check for check in unknown.checks if check.quantity == "factor")
    assert (row.state, row.subject) == ("amber", "rigging")
    assert not [check for check in without.checks if check.quantity == "factor"]


PAIR = """\
heavylift: 1
name: pair
block: {mass: 20 t, size: [20 m, 4 m, 2 m], at: [20 m, 0 m, 2 m], lugs: {A: [-10 m, 0, 1.1 m], B: [10 m, 0, 1.1 m]},
        supports: {height: 1 m, at: [[-8 m, 0], [8 m, 1 m], [8 m, -1 m]]}}
cranes: {one: {type: jib-60, at: [-10 m, 0 m, 0 m]}, two: {type: jib-60, at: [10 m, 0 m, 0 m]}}
rigging: {a: {on: one main, to: [A], length: 20 m}, b: {on: two main, to: [B], length: 20 m}}
actions: [{all hooks: hoist 1 m/min until lifted}]
"""


def test_design_loads_of_hooks_that_share_a_load_are_checked_against_their_reduced_capacity() -> None:
    """The capacity of each crane is divided by the tandem factor before the design load is compared with it."""
    sheet = "factors={{rigging: 0 t, weight: 1.1, cog factor: 1.1, dynamics: included, wind: 0 m/s, tandem: {}}}"
    plain, derated = (worst(parse(PAIR, "pair.yaml", [sheet.format(x)])) for x in (1.0, 1.25))
    designs = [key for key in plain if key[0] == "hook design load"]
    assert len(designs) == 2
    for key in designs:
        assert derated[key] == pytest.approx(1.25 * plain[key], rel=1e-9)


def test_a_newly_created_scene_rates_a_bridle_of_four_legs_as_an_assembly(crane: str, tmp_path: Path) -> None:
    random = Random(crane)
    for mass in (random.uniform(2.0, 12.0) for _ in range(3)):
        scene = parse(begun(crane, tmp_path, f"B,{mass:.3f},"), "made.yaml")
        rated = (check for check in scene.checks if check.quantity in ("assembly load", "sling tension"))
        assert {check.state for check in rated} == {"green"}
