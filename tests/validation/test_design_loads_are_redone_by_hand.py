"""Design loads and working load limits of a report are recomputed from the report alone, to 0.5 %."""

from __future__ import annotations

import re
from math import cos, prod, radians, sin, sqrt, tan
from pathlib import Path
from typing import Any

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import report

openpyxl = pytest.importorskip("openpyxl")
HAND, TONNE = 5e-3, 9.80665  # [kN]
NOT_FACTORS = {"part", None, "load at rest", "design load", "limit", "used", "simulated", "most loaded in"}
TERMS = re.compile(r"Fmin = ([\d.]+) kN, Zp = ([\d.]+), KT = ([\d.]+)")
ASSEMBLY = re.compile(r"KL = ([\d.]+) up to 45 degrees")
PEAK = re.compile(r"([\d.]+) kN(?: assumed)? over ((?:[\d.]+ x )+[\d.]+) \(.*?\) x ([\d.]+) \(wear\)")
WIND = re.compile(r"wind .*: 0.5 x ([\d.]+) kg/m3 x ([\d.]+) x ([\d.]+) m2 x \(([\d.]+) m/s\)2")
QUANTITY = re.compile(r"(-?[\d.]+)(?: (t|kg|kN|kPa|deg|%))?")
WLL = re.compile(r"WLL x ([\d.]+)")
PAIR = """heavylift: 1
name: pair
gear: gear.csv
practice: 0027/ND
factors: {weight: 1.03, cog: [0.4 m, 0 m, 0 m], tilt: 3 deg, wind: 9 m/s, area: 60 m2, dynamics: included}
block:
  mass: 20 t
  size: [20 m, 6 m, 2 m]
  at: [20 m, 0 m, 2 m]
  lug capacity: 15 t
  lugs: {A1: [-10 m, -2 m, 1.1 m], A2: [-10 m, 2 m, 1.1 m], B1: [10 m, -2 m, 1.1 m], B2: [10 m, 2 m, 1.1 m]}
  supports: {height: 1 m, at: [[-8 m, 0 m], [8 m, 1 m], [8 m, -1 m]]}
cranes:
  one: {type: jib-60, at: [-10 m, 0 m, 0 m]}
  two: {type: jib-60, at: [10 m, 0 m, 0 m]}
rigging:
  a: {on: one main, to: [A1, A2], length: 6 m, sling: {gear: WR-28-6}, shackle: {gear: SH-17}}
  b: {on: two main, to: [B1, B2], length: 6 m, sling: {gear: WR-28-6}, shackle: {gear: SH-17}}
actions:
  - {stage: up, "all hooks": hoist 0.5 m/min until lifted}
end: 100 s
"""
GEAR = """id,kind,breaking [kN],EA [MN],WLL [t],mass [kg],termination,standard,certificate
WR-28-6,sling,494,33,,24,ferrule,EN 13414-1,2026-02-01
SH-17,shackle,,,17,7.4,,EN 13889,2026-01-15
"""


def number(cell: object) -> object:
    found = QUANTITY.fullmatch(cell) if isinstance(cell, str) else None
    return cell if found is None else float(found[1]) / (100.0 if found[2] == "%" else 1.0)


class Report:
    """The tables of a workbook, and nothing else."""

    def __init__(self, scene: str, settings: list[str], folder: Path) -> None:
        recording = folder / "lift.mcap"
        run(load(scene, settings), recording, in_process=True)
        book = openpyxl.load_workbook(report(recording, folder / "lift.xlsx"))
        self.tables = {sheet.title: [[*row] for row in sheet.iter_rows(values_only=True)] for sheet in book}
        titles = {name: next(i for i, row in enumerate(rows) if len({*row} - {None}) > 1 or row[0] == "what")
                  for name, rows in self.tables.items()}  # fmt: skip
        self.tables = {name: rows[titles[name] :] for name, rows in self.tables.items()}

    def rows(self, table: str) -> list[dict[Any, Any]]:
        """Cells by heads without their units, texts of a number and its unit as numbers; of several columns with one
        head, the filled one."""
        head, *rows = self.tables[table]
        heads = [x and x.partition(" [")[0] for x in head]
        found = []
        for row in (row for row in rows if sum(x is not None for x in row) > 1):
            pairs = sorted(zip(heads, row, strict=True), key=lambda pair: pair[1] is not None)  # empty ones first
            found.append({x: number(cell) for x, cell in pairs})
        return found

    def message(self, pattern: re.Pattern[str]) -> list[re.Match[str]]:
        lines = (str(row[0]) for rows in self.tables.values() for row in rows)
        return [found for line in lines if (found := pattern.search(line))]

    def block(self, what: str) -> float:
        return next(float(row[1]) for row in self.tables["Block"] if row[0] == what)

    def lugs(self) -> dict[str, tuple[float, ...]]:
        return {row["lug"]: (row["u"], row["v"], row["w"]) for row in self.rows("Loads on lugs")}

    def angles(self) -> list[float]:
        """Of the slings to the vertical, at their peaks."""
        return sorted(row["angle to vertical at its peak"] for row in self.rows("Slings"))

    def designs(self) -> list[dict[Any, Any]]:
        """Lines of both factor sheets, in t and in kN."""
        return [row for name in self.tables if name.startswith("Design loads") for row in self.rows(name)]

    def design(self, part: str) -> dict[str, dict[Any, Any]]:
        return {row[None]: row for row in self.designs() if row["part"] == part}

    def limits(self) -> None:
        """Each product of the sheet, and each limit whose terms are reported."""
        for row in self.designs():
            factors = {x: row[x] for x in row if x not in NOT_FACTORS and isinstance(row[x], int | float)}
            required = row["load at rest"] * prod(factors.values())
            met = (row["simulated"] or 0.0) * prod(factors[x] for x in factors if x != "dynamic")
            design = max(required, met)
            assert row["design load"] == pytest.approx(design, rel=HAND), row
            if row["limit"]:
                assert row["used"] == pytest.approx(100.0 * design / row["limit"], abs=1.0), row
        known = 0
        for row in self.rows("Checks"):
            basis, limit = str(row["basis"]), row["limit"]
            if (terms := TERMS.search(basis)) and isinstance(limit, int | float):
                breaking, zp, kt = map(float, terms.groups())
                legs = ASSEMBLY.search(basis)
                most = breaking * kt * float(legs[1]) / zp / TONNE if legs else breaking * kt / zp
                assert limit == pytest.approx(most, rel=HAND), row
                known += 1
            elif (peak := PEAK.search(basis)) and isinstance(limit, int | float):
                factors = [float(x) for x in peak[2].split(" x ")]
                assert limit == pytest.approx(float(peak[1]) / prod(factors) / float(peak[3]), rel=HAND), row
                known += 1
        assert known
        for found in self.message(WIND):
            air, drag, area, speed = map(float, found.groups())
            push = 0.5 * air * drag * area * speed**2 / 1e3
            factor = sqrt(1.0 + (push / (self.block("mass") * TONNE)) ** 2)
            assert all(row["wind"] == pytest.approx(factor, rel=HAND) for row in self.designs())


def test_design_loads_of_a_crawler_with_a_bridle_agree_with_a_calculation_by_hand(tmp_path: Path) -> None:
    sets = ["practice=0027/ND", "factors={weight: 1.05, cog: [0 m, 0 m, 0 m], wind: 8 m/s, area: 24 m2}"]
    found = Report("crawler", [*sets, "block.lug capacity=30 t", "rigging.legs.shackle=35 t"], tmp_path)
    found.limits()
    weight = found.block("mass") * TONNE
    angles = found.angles()
    leg = weight / 4.0 / cos(radians((angles[1] + angles[2]) / 2.0))
    assert len(found.design("sling")) == 4
    for part, unit in (("sling", 1.0), ("shackle", TONNE), ("lug", TONNE)):
        for row in found.design(part).values():
            assert row["load at rest"] == pytest.approx(leg / unit, rel=HAND)
            more = 1.3 if part == "lug" else 1.0
            assert row["design load"] == pytest.approx(leg / unit * 1.05 * 1.1 * 1.25 * more, rel=HAND)
    shackles = next(row for row in found.rows("Checks") if row["check"] == "shackle design load")
    assert shackles["limit"] == pytest.approx(35.0 * float(WLL.search(shackles["basis"])[1]))  # type: ignore[index]


def test_design_loads_of_a_turn_over_agree_with_a_calculation_by_hand(tmp_path: Path) -> None:
    """Lying, B carries W (14.6 + dv) / 26.6 on two hooks; standing on edge, A carries all on four."""
    sets = ["practice=0027/ND", "factors={weight: 1.03, cog: [0 m, 1 m, 0 m], wind: 0 m/s, heights: 1.02}"]
    found = Report("turnover", [*sets, "block.lug capacity=160 t"], tmp_path)
    found.limits()
    lugs, mass = found.lugs(), found.block("mass")
    a, b = lugs["A1"][1], lugs["B1"][1]
    hooks = found.design("hook")
    hung = {row["item"]: row["mass each"] for row in found.rows("Rigger's list")}
    own = 20.0 + (2 * hung["WR-96"] + 4 * hung["SH-200"]) / 1e3  # [t] of loader, slings and shackles on each hook
    for crane in ("west", "east"):
        lying = mass * -a / (b - a) / 2.0
        low = hooks[f"{crane}.H3"]
        assert low["load at rest"] - own == pytest.approx(lying, rel=HAND)
        lateral = ((mass * (1.0 - a) / (b - a) / 2.0) + own) / (lying + own)
        assert low["cog"] == pytest.approx(lateral, rel=HAND)
        assert low["design load"] == pytest.approx((lying + own) * lateral * 1.03 * 1.02, rel=HAND)
        for hook in ("H1", "H2"):
            standing = hooks[f"{crane}.{hook}"]
            assert standing["load at rest"] - own == pytest.approx(mass / 4.0, rel=HAND)
            assert standing["design load"] == pytest.approx((mass / 4.0 + own) * 1.03 * 1.02, rel=HAND)
    sling = found.design("sling")["loader-3.sling-1"]
    leg = mass * -a / (b - a) / 4.0 * TONNE
    assert sling["load at rest"] == pytest.approx(leg, rel=HAND)
    assert sling["dynamic"] == 1.05
    assert sling["design load"] == pytest.approx(leg * (1.0 - a) / -a * 1.03 * 1.05 * 1.02, rel=HAND)
    lug = found.design("lug")["B1"]
    assert lug["design load"] == pytest.approx(sling["design load"] / TONNE * 1.3, rel=HAND)


def test_design_loads_of_two_jibs_with_gear_from_a_table_agree_with_a_calculation_by_hand(tmp_path: Path) -> None:
    (tmp_path / "gear.csv").write_text(GEAR, encoding="utf-8")
    (tmp_path / "pair.yaml").write_text(PAIR, encoding="utf-8")
    found = Report(str(tmp_path / "pair.yaml"), [], tmp_path)
    found.limits()
    mass, lugs = found.block("mass"), found.lugs()
    half, across, high = lugs["B1"][0], lugs["B2"][1], lugs["B1"][2]
    angle = radians(found.angles()[-1])
    eye = high + across / tan(angle)  # above the centre of mass
    tilt = (half * cos(radians(3.0)) + eye * sin(radians(3.0))) / (half * cos(radians(3.0)))
    lateral = (half + 0.4) / half
    listed = {row["item"]: row for row in found.rows("Rigger's list")}
    assert (listed["WR-28-6"]["number"], listed["SH-17"]["number"]) == (4, 8)
    hung = 2 * 24.0 + 4 * 7.4  # [kg] on each hook
    for row in found.design("sling").values():
        leg = mass / 4.0 * TONNE / cos(angle)
        assert row["load at rest"] == pytest.approx(leg, rel=HAND)
        assert (row["dynamic"], row["yaw"]) == (1.1, 1.05)
        assert row["tilt"] == pytest.approx(tilt, rel=HAND)
        assert row["cog"] == pytest.approx(lateral, rel=HAND)
        assert row["design load"] == pytest.approx(leg * 1.03 * lateral * 1.1 * tilt * 1.05, rel=2 * HAND)
    for row in found.design("hook").values():
        assert row["load at rest"] == pytest.approx(mass / 2.0 + (2000.0 + hung) / 1e3, rel=HAND)
    limits = {row["check"]: row["limit"] for row in found.rows("Checks")}
    assert limits["assembly load"] == pytest.approx(494.0 * 0.9 * 1.4 / 5.0 / TONNE, rel=HAND)
    assert limits["shackle load"] == 17.0
