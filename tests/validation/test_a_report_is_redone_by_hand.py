"""The sums of a report are recomputed from the report alone: utilisations, weights, reactions and factors, to 0.5 %."""

from __future__ import annotations

from math import cos, hypot, radians, sin
from typing import Any

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from heavylift.recordings.documents import report_sheet
from heavylift.recordings.sheets import data_of

G = 9.80665
HAND = 5e-3


@pytest.fixture(scope="module", params=["lift", "crawler", "turnover"])
def printed(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, list[dict[str, Any]]]:
    """Rows of each table by column, as they are printed."""
    path = tmp_path_factory.mktemp("report") / "run.mcap"
    run(load(request.param), path, in_process=True)
    found = data_of(report_sheet(Recording(path)))["tables"]
    heads = {table["title"]: [column["name"] for column in table["columns"]] for table in found}
    rows = {table["title"]: table["rows"] for table in found}
    return {title: [dict(zip(heads[title], row, strict=True)) for row in rows[title]] for title in rows}


def test_each_utilisation_in_a_report_is_its_value_over_its_limit(printed: dict[str, list[dict[str, Any]]]) -> None:
    seen = 0
    for title, rows in printed.items():
        for row in rows:
            value, limit, use = (row.get(x) for x in ("worst", "limit", "use"))
            value = row.get("with contingencies") or row.get("peak tension", value)
            if None not in (value, limit, use) and title not in ("Largest use of each quantity", "Stages"):
                least = title == "Rope factor" or title == "Clearance"
                assert use == pytest.approx(100.0 * (limit / value if least else value / limit), rel=HAND), (title, row)
                seen += 1
    assert seen >= 10


def test_weights_and_reactions_in_a_report_are_in_balance(printed: dict[str, list[dict[str, Any]]]) -> None:
    block = {row[""]: row for row in printed["Block"]}
    weight = block["mass"]["value, u or x"] * G
    assert block["weight"]["value, u or x"] == pytest.approx(weight, rel=HAND)
    on_supports = {row["support"]: row["largest load"] for row in printed["Reactions of supports"]}
    assert on_supports["all together"] == pytest.approx(weight, rel=HAND)
    for title in ("Reactions of supports", "Loads on lugs"):
        for row in printed[title]:
            assert row["as a mass"] == pytest.approx(row["largest load"] / G, rel=HAND)


def test_the_load_on_a_lug_in_a_report_is_the_sling_tension_resolved_along_the_axes_of_the_block(
    printed: dict[str, list[dict[str, Any]]],
) -> None:
    """One sling on each lug: the same force; its angle to the vertical gives the vertical part of an upright block."""
    ropes = {row["rope"]: row for row in printed["Ropes and slings"]}
    slings = {row["lug"]: row | ropes[row["sling"]] for row in printed["Slings"]}
    tilts = {row["stage"]: row["largest tilt"] for row in printed["Path of the block"]}
    for lug in printed["Loads on lugs"]:
        parts = [lug[f"along {axis}"] for axis in "uvw"]
        assert hypot(*parts) == pytest.approx(lug["largest load"], rel=HAND)
        sling = slings.get(lug["lug"])
        if sling is not None:
            assert lug["largest load"] == pytest.approx(sling["peak tension"], rel=HAND)
            if tilts[sling["stage"]] < 0.1:
                angle = radians(sling["angle to vertical at its peak"])
                assert parts[2] == pytest.approx(lug["largest load"] * cos(angle), rel=HAND)
                assert hypot(*parts[:2]) == pytest.approx(
                    lug["largest load"] * sin(angle), abs=HAND * lug["largest load"]
                )
