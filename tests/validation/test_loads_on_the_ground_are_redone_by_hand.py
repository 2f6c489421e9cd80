"""Who has the report alone can redo pressure below tracks and outriggers, wheel loads and the way to tipping."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import new_scene_with, parse
from heavylift.nodes.scene.text import library
from heavylift.recordings import Recording
from heavylift.recordings.documents import report_sheet
from heavylift.recordings.sheets import data_of

G = 9.80665
HAND = 5e-3
SMALLEST = 1.0  # [kPa, t] a printed value with so few digits is not redone
SIDES = {"front": (1, 0), "rear": (-1, 0), "left": (0, 1), "right": (0, -1)}


def printed(crane: str, folder: Path) -> dict[str, list[dict[str, Any]]]:
    """Rows of each table of the report of a lift by a crane of the type, by column."""
    mass, long, wide = (200, 30, 24) if crane.startswith(("goliath", "twin")) else (10, 6, 5)
    mass, long, wide = (100, 20, 10) if crane.startswith("mobile") else (mass, long, wide)
    head = "name,mass [t],size x [m],size y [m],size z [m]\n"
    (folder / "blocks.csv").write_text(f"{head}B,{mass},{long},{wide},4\n", encoding="utf-8")
    (text,) = new_scene_with("made", crane, "blocks.csv#B").values()
    plain = "factors={rigging: 0 t, weight: 1, cog factor: 1, dynamics: included, wind: 0 m/s}"  # resultants have none
    run(parse(text, str(folder / "made.yaml"), [plain]), folder / "run.mcap", in_process=True)
    found = data_of(report_sheet(Recording(folder / "run.mcap")))["tables"]
    return {
        x["title"]: [dict(zip([c["name"] for c in x["columns"]], row, strict=True)) for row in x["rows"]] for x in found
    }


def by_hand(row: dict[str, Any], item: str) -> float:
    """kPa below a track or outrigger, t on one wheel, or the way to tipping [%], from what the row says."""
    V, x, y, length, width = (row[k] for k in ("resultant", "along", "across", "base length", "base width"))
    if row["check"] == "uplift":
        u, v = abs(2.0 * x / length), abs(2.0 * y / width)
        return 100.0 * (u + v if row.get("wheels at a corner") else max(u, v))
    ahead, left = (sum(SIDES[word][i] for word in item.split() if word in SIDES) for i in (0, 1))
    area, mats = row.get("mat area"), (row.get("mat mass") or 0.0) * G
    if breadth := row.get("track breadth"):
        own, e = V / 2.0 * (1.0 + 2.0 * left * y / width), abs(x)
        if e <= length / 6.0:
            p = own / (breadth * length) * (1.0 + 6.0 * e / length)
        else:
            p = 2.0 * own / (3.0 * breadth * (length / 2.0 - e))
        return p * breadth * length / area + mats / area if area else p
    corner = V / 4.0 * (1.0 + 2.0 * ahead * x / length + 2.0 * left * y / width)
    if wheels := row.get("wheels at a corner"):
        return corner / G / wheels
    return (corner + mats) / (area or row["pad area"])


@pytest.mark.parametrize("crane", sorted(library()))
def test_reported_loads_on_the_ground_are_those_of_the_reported_resultant(
    crane: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    report = printed(crane, tmp_path)
    checked = [(title, row) for title, rows in report.items() for row in rows if {"item", "worst"} <= row.keys()]
    values = {(title.lower(), row["item"]): row["worst"] or 0.0 for title, row in checked}
    rows = report.get("Loads on bases", [])
    stands = {key for key in values if key[0] in ("ground pressure", "wheel load", "uplift")}
    assert {(row["check"], row["item"]) for row in rows} == {key for key in stands if values[key]}
    for row in rows:
        value = values[row["check"], row["item"]]
        if row["check"] == "uplift" or value > SMALLEST:
            assert by_hand(row, row["item"]) == pytest.approx(value, rel=HAND, abs=HAND), row
