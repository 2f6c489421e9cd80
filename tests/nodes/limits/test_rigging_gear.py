"""Slings and shackles are rated by their standards; rigging gear is read from files and listed."""

from __future__ import annotations

from math import degrees, radians
from pathlib import Path

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.limits import (
    CABLE_LAID,
    KL,
    SOCKETS,
    TERMINATIONS,
    Terms,
    assembly,
    at_rest,
    bending,
    in_a_run,
    shackle,
)
from heavylift.nodes.plan import RatedLimit
from heavylift.nodes.scene import check, load, new_scene_with, parse
from heavylift.nodes.scene.text import library
from lifting import bare, unstated
from msgspec.structs import replace

G = 9.80665
UNSAID = "rigging.legs.sling={EA: 60 MN, breaking: 1600 kN}"  # without a termination
TABLE = {  # EN 13414-1, table 4, steel core, ferrule-secured: mm -> t of one leg, 2 to 45, 2 to 60, 4 to 45, 4 to 60
    8: (0.750, 1.05, 0.750, 1.55, 1.10), 16: (3.00, 4.20, 3.00, 6.30, 4.50), 24: (6.70, 9.40, 6.70, 14.0, 10.0),
    32: (11.8, 16.5, 11.8, 25.0, 17.5), 40: (18.5, 26.0, 18.5, 39.0, 27.5), 52: (31.5, 44.0, 31.5, 66.0, 47.0),
    60: (42.0, 58.0, 42.0, 88.0, 63.0),
}  # fmt: skip
ROUNDED = 0.04  # of its figures
SLINGS = "id,kind,breaking [kN],EA [MN],diameter [mm],WLL [t],mass [kg],termination,standard,certificate\n"
ROW = "WR-48-8,sling,1600,60,48,,95,ferrule,EN 13414-1,2026-02-01\n"
SHACKLES = "SH-35: {kind: shackle, WLL: 35 t, mass: 18 kg, standard: EN 13889}\nSH-25: {kind: shackle, WLL: 25 t}\n"


@pytest.mark.parametrize("d", TABLE)
def test_the_formula_for_sling_assemblies_reproduces_the_table_of_the_standard(d: int) -> None:
    """Fmin = 0.356 d2 1770 N/mm2."""
    known = Terms(0.356 * d * d * 1770.0, termination="ferrule")
    one, *legs = TABLE[d]
    assert known.breaking / at_rest(known, G).factor / G == pytest.approx(1e3 * one, rel=ROUNDED)
    for many, (to_45, to_60) in ((2, legs[:2]), (4, legs[2:])):
        found = assembly(known, many, G)
        assert found is not None
        assert [degrees(angle) for angle, _ in found[0]] == pytest.approx([45.0, 60.0])
        assert [mass for _, mass in found[0]] == pytest.approx([1e3 * to_45, 1e3 * to_60], rel=ROUNDED)
    assert assembly(known, 1, G) is None


def test_a_sling_assembly_is_rated_by_the_cosine_of_its_loaded_legs() -> None:
    for legs, carry in ((2, 2), (3, 3), (4, 3)):
        for angle, factor in KL[legs]:
            assert factor == pytest.approx(carry * {45.0: 0.7071, 60.0: 0.5}[angle], rel=0.015)


def test_sling_ratings_beyond_the_table_of_the_standard_are_marked_as_assumed() -> None:
    heavy = at_rest(Terms(6.43e6), G)
    assert heavy.factor == 5.0
    assert heavy.source == "assumed: the table of EN 13414-1 ends at 60 mm and 42 t a leg"
    assert "assumed" in at_rest(Terms(6.43e6, termination="spliced"), G).source
    assert "assumed" in at_rest(Terms(1e6, termination="ferrule", diameter=0.07), G).source
    assert "assumed" in at_rest(Terms(1e6), G).source
    assert "assumed" not in at_rest(Terms(1e6, termination="ferrule"), G).source
    eyes = (at_rest(Terms(1e6, termination="ferrule", diameter=0.05, pin=pin), G).source for pin in (0.09, 0.11))
    assert ["bend over less than 2 d" in source for source in eyes] == [True, False]
    assert at_rest(Terms(6.43e6, 100e3, "WR-1"), G) == (6.43e6 / (100e3 * G), "WR-1", "")


def test_safety_factors_of_heavy_slings_are_the_products_of_dnv_guideline_0027() -> None:
    """7.7.1 (termination), 7.8.1 (bending), 7.9.4 (wear): the product of 7.3.1."""
    assert [round(bending(ratio), 2) for ratio in (1, 2, 3, 4, 6)] == [2.00, 1.55, 1.41, 1.33, 1.26]
    product = 1.3 * 1.3 * 1.5
    for name, (_, factor) in TERMINATIONS.items():
        whole = 2.0 if name == "grommet" else 1.0  # 7.2.3
        assert in_a_run(Terms(1e6, termination=name, wear=1.0)).factor == pytest.approx(product * factor * whole)
        tight = in_a_run(Terms(1e6, termination=name, diameter=0.1, pin=0.2))
        bent = 1.0 if name in SOCKETS else bending(2.0)  # a pin holds the socket
        assert tight.factor == pytest.approx(product * 1.2 * max(factor, bent) * whole)
        assert ("pins" in in_a_run(Terms(1e6, termination=name)).source) == (name not in SOCKETS)
        assert "assumed" not in tight.source
    assert in_a_run(Terms(1e6)).factor == pytest.approx(3.8025)
    assert in_a_run(Terms(1e6, diameter=0.1, pin=0.2)).factor == pytest.approx(4.72, abs=0.02)


def test_shackle_ratings_beyond_the_range_of_their_standard_are_marked_as_assumed() -> None:
    assert not shackle(25e3, "EN 13889")
    assert not shackle(85e3, "RR-C-271")
    assert "ends at 25 t, assumed" in shackle(35e3, "EN 13889")
    assert "hooks, links" in shackle(10e3, "EN 1677-1")


def test_a_bridle_can_be_rated_as_an_assembly_or_leg_by_leg() -> None:
    """60 t on four legs of 1600 kN at 27 degrees: 60 t of 61.7 t; or 165 kN x 1.25 of 288 kN; with contingencies of the
    weight by 1.03 and of the centre of mass by 1.05."""
    more = 1.03 * 1.05
    rows = {c.quantity: c for c in load("crawler", [UNSAID]).checks if c.quantity in ("assembly load", "sling tension")}
    most = 1600e3 * 0.9 * 2.1 / 5 / G
    assert rows["assembly load"].limit == pytest.approx(most)
    assert rows["assembly load"].use == pytest.approx(more * 60e3 / most, rel=1e-4)
    assert "KL = 2.1 up to 45 degrees" in rows["assembly load"].basis
    assert "three carry" in rows["assembly load"].basis
    assert rows["assembly load"].state == "red"
    sling = "{EA: 60 MN, breaking: 1600 kN, termination: ferrule, legs: single}"
    single = {c.quantity: c for c in load("crawler", [f"rigging.legs.sling={sling}"]).checks}
    assert "assembly load" not in single
    row = single["sling tension"]
    assert row.use == pytest.approx(more * 164.7 * 1.25 / (1600 * 0.9 / 5), rel=1e-3)
    assert "legs chosen singly: skew load factor 1.25" in row.basis
    assert row.state == "green"


def test_beyond_45_degrees_a_sling_assembly_carries_less() -> None:
    limit = RatedLimit(
        subject="a", quantity="assembly load", unit="kg", over="angle", chart=assembly(Terms(1e6), 4, G)[0]
    )  # type: ignore[index]
    assert limit.at(radians(44)) / limit.at(radians(46)) == pytest.approx(2.1 / 1.5)
    assert limit.at(radians(61)) == 0.0


def scene(folder: Path, named: str) -> str:
    (folder / "slings.csv").write_text(SLINGS + ROW, encoding="utf-8")
    (folder / "shackles.yaml").write_text(SHACKLES, encoding="utf-8")
    text = (
        f"heavylift: 1\nextends: crawler\nname: geared\n{named}"
        "rigging:\n  legs: {sling: {gear: WR-48-8}, shackle: {gear: SH-35}}\n"
    )
    (folder / "geared.yaml").write_text(text, encoding="utf-8")
    return str(folder / "geared.yaml")


def test_rigging_gear_is_read_from_its_files_and_listed(tmp_path: Path) -> None:
    found = load(scene(tmp_path, "gear: [slings.csv, shackles.yaml]\n"))
    sling = found.scene.rigging["legs"].sling  # type: ignore[union-attr]
    assert (sling.breaking, sling.EA, sling.termination) == (1600e3, 60e6, "ferrule")
    checks = {c.quantity: c for c in found.checks}
    assert checks["shackle load"].limit == 35e3
    assert "SH-35, EN 13889; EN 13889 ends at 25 t, assumed" in checks["shackle load"].basis
    assert checks["sling tension"].basis.startswith("EN 13414-1, Fmin = 1600 kN, Zp = 5, KT = 0.9 of ferrule")
    report = check(found)
    (gear,) = (x for x in report.tables if x.title == "Rigger's list")
    second, first = (dict(zip((x.heading for x in gear.columns), row, strict=True)) for row in gear.rows)
    assert (first["item"], first["number"], first["kind"]) == ("WR-48-8", 4, "sling")
    assert (first["WLL [t]"], first["mass each [kg]"], first["standard"]) == (None, 95.0, "EN 13414-1")
    assert (first["certificate"], first["where"]) == ("2026-02-01", "rigging.legs.sling")
    assert (second["item"], second["number"], second["WLL [t]"]) == ("SH-35", 8, 35.0)
    assert "Rigger's list:" in str(report)
    again = parse(found.merged or found.text, "again.yaml")
    assert again.plan.gear == found.plan.gear
    assert [replace(x, where="") for x in again.plan.limits] == [replace(x, where="") for x in found.plan.limits]


def test_the_mass_of_rigging_gear_is_part_of_the_design_load_of_its_hook(tmp_path: Path) -> None:
    sheet = "factors={weight: 1.03, cog factor: 1.05, dynamics: included, wind: 0 m/s}"
    found = load(scene(tmp_path, "gear: [slings.csv, shackles.yaml]\npractice: 0027/ND\n"), [sheet])
    hook = next(x for x in found.plan.limits if x.quantity == "hook design load")
    assert hook.rest is not None
    values = {use.limit.quantity: use.value for use in found.uses}
    assert hook.rest.value == values["hook load"] == pytest.approx(60e3 + 3e3 + 4 * 95 + 8 * 18, rel=1e-4)


def test_rigging_gear_may_be_given_in_a_workbook_or_in_the_scene(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for line in (SLINGS + ROW).splitlines():
        book.active.append(line.split(","))
    book.save(tmp_path / "slings.xlsx")
    path = scene(tmp_path, "gear: [slings.xlsx, shackles.yaml]\n")
    one = load(path)
    inline = "gear: {WR-48-8: {kind: sling, breaking: 1600 kN, EA: 60 MN, termination: ferrule, diameter: 48 mm, mass: 95 kg, standard: EN 13414-1, certificate: '2026-02-01'}, SH-35: {kind: shackle, WLL: 35 t, mass: 18 kg, standard: EN 13889}}\n"  # noqa: E501
    Path(path).write_text(Path(path).read_text().replace("gear: [slings.xlsx, shackles.yaml]\n", inline))
    two = load(path)
    assert one.plan.gear == two.plan.gear
    assert [x.value for x in one.plan.limits] == [x.value for x in two.plan.limits]


@pytest.mark.parametrize(
    ("named", "old", "new", "told"),
    [
        ("gear: [slings.csv, shackles.yaml]\n", "gear: SH-35", "gear: SH-53", "there is no gear 'SH-53'"),
        ("gear: [slings.csv]\n", "", "", "there is no gear 'SH-35'"),
        ("gear: [none.csv]\n", "", "", "there is no table 'none.csv' beside the scene"),
        ("", "", "", "name the files that hold it"),
        ("gear: [slings.csv, slings.csv]\n", "", "", "which another file has, too"),
        ("gear: [slings.csv, shackles.yaml]\n", "shackle: {gear: SH-35}", "shackle: {gear: WR-48-8}", "has no 'WLL'"),
        ("gear: [slings.csv, shackles.yaml]\n", "sling: {gear: WR-48-8}", "sling: {gear: SH-35}", "has no 'breaking'"),
    ],
)
def test_missing_rigging_gear_is_reported_with_file_and_line(
    named: str, old: str, new: str, told: str, tmp_path: Path
) -> None:
    path = Path(scene(tmp_path, named))
    path.write_text(path.read_text().replace(old, new) if old else path.read_text())
    with pytest.raises(SceneError, match=r"geared.yaml:\d+:\d+: error") as error:
        load(str(path))
    assert told in str(error.value)


def test_a_four_leg_bridle_without_a_stated_load_sharing_gives_an_amber_check() -> None:
    """Where no assembly is rated, a row asks how."""
    heavy = "rigging.legs.sling={EA: 60 MN, breaking: 4000 kN}"
    (asked,) = (c for c in bare("crawler", [heavy]).checks if c.quantity == "sharing")
    assert (asked.state, asked.why) == ("amber", "not checked")
    for answer in ("factors={skew: 1.25}", heavy.replace("}", ", legs: single}")):
        assert not [c for c in bare("crawler", [heavy, answer]).checks if c.quantity == "sharing"]


@pytest.mark.parametrize("crane", sorted(library()))
def test_bridles_of_every_crane_type_are_rated_as_an_assembly_or_a_check_asks_for_their_load_sharing(
    crane: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    long, wide = (30, 24) if crane.startswith(("goliath", "twin", "mobile")) else (6, 5)
    (tmp_path / "blocks.csv").write_text(f"name,mass [t],size x [m],size y [m],size z [m]\nB,10,{long},{wide},4\n")
    (text,) = map(unstated, new_scene_with("made", crane, "blocks.csv#B").values())
    for breaking, rated in (("900 kN", "assembly load"), ("6 MN", "sharing")):
        plain = parse(text, str(tmp_path / "made.yaml"))
        names = [name for name, x in plain.scene.rigging.items() if len(getattr(x, "to", ())) > 3]
        settings = [f"rigging.{name}.sling={{breaking: {breaking}}}" for name in names]
        found = parse(text, str(tmp_path / "made.yaml"), settings).plan.limits
        message = {(x.subject, x.quantity) for x in found if x.quantity in ("assembly load", "sharing")}
        assert message == {(name, rated) for name in names}
        assert any(x.quantity == "lug load" for x in found)


@pytest.mark.parametrize("termination", TERMINATIONS)
@pytest.mark.parametrize("rated", [False, True])
def test_a_cable_laid_sling_without_a_rated_load_is_reported_as_to_be_confirmed(termination: str, rated: bool) -> None:
    """Cable-laid slings and grommets are rated by EN 13414-3 and IMCA M 179, or by what their certificate says."""
    sling = f"{{EA: 60 MN, breaking: 1600 kN, termination: {termination}{', WLL: 30 t' if rated else ''}}}"
    found = [c for c in load("jib", [f"rigging.legs.sling={sling}"]).checks if c.quantity == "heavy sling"]
    assert len(found) == (4 if termination in CABLE_LAID and not rated else 0)
    for row in found:
        assert (row.state, row.why, row.limit, row.value) == ("amber", "not checked", None, None)
        assert "to be confirmed (EN 13414-3, IMCA M 179: no clause was read)" in row.sentence
