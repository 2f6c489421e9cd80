"""The planner's document: the same numbers for every kind of crane, in every form, and what went wrong in red."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
from browser import CHROMIUM
from heavylift.coordinator.cli import main
from heavylift.coordinator.run import run
from heavylift.kernel import RecordingError
from heavylift.nodes.scene import load
from heavylift.recordings import Recorder, Recording, RopeLine, SampleChannel, SampleLayout, report
from heavylift.recordings.documents import Facts, alternatives, facts, report_sheet, tables_of
from heavylift.recordings.read import RecordedVerdict
from heavylift.recordings.sheets import Table, plain
from small_run import POSE, SECOND, Stage

G = 9.80665
PLAN = {
    "gravity": G,
    "machines": [
        {
            "name": "west",
            "hooks": [{"rope": "west.H1", "block_mass": 2e3}],
            "cells": [{"capacity": 40e3}],
            "system": {"bodies": []},
        }
    ],
}
TENSION = np.array([1e5, 3e5, 4.4e5, 4e5, 4e5, 4e5, 4.2e5, 4e5])  # [N] each second; rated 4.3e5
CRANES = ("lift", "crawler", "hall", "jib", "floating", "spreader", "tandem")  # of every kind
UNITS = {"N": 1e-3, "N m": 1e-3, "kg": 1e-3, "Pa": 1e-3, "rad": 180.0 / np.pi}
OF_QUANTITY = {"lift-off speed": 60.0, "landing speed": 60.0, "uplift": 100.0, "interlock": 100.0}


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    """A load on one rope: taken up for 3 s, held for 5 s."""
    layout = SampleLayout(
        [
            SampleChannel("rope/tension", ["west.H1"], "N", 0, 1),
            SampleChannel("rope/peak", ["west.H1"], "N", 1, 2),
            SampleChannel("pose/load", POSE, "m", 2, 9),
        ]
    )
    n = len(TENSION)
    poses = np.zeros((n, 7))
    poses[:, 2], poses[:, 6] = 4.0, 1.0
    rows = np.ascontiguousarray(np.column_stack([TENSION, TENSION, poses]))
    message = {"scene": "<b>lift</b>", "rated": {"west.H1": 4.3e5}, "project": {"number": "<i>7", "revision": "C"}}
    attachments = {"resolved.json": msgspec.json.encode(PLAN)}
    with Recorder(tmp_path / "run.mcap", message, attachments) as rec:
        rec.add_port("commander", "stage", msgspec.json.schema(Stage))
        rec.layout(layout)
        rec.ropes(0, [RopeLine("west.H1", "world", (0, 0, 10), "load", (0, 0, 1))])
        for second, name in ((0, "take up"), (3, "hold")):
            payload = msgspec.msgpack.encode(Stage(name, second))
            rec.event(second * SECOND, 0, "commander", "stage", 0, "Stage", payload)
        rec.samples(msgspec.msgpack.encode([0, [i * SECOND for i in range(n)], rows.tobytes()]))
        return rec.close()


@pytest.fixture(scope="module")
def lifts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("lifts")
    for name in CRANES:
        run(load(name), folder / f"{name}.mcap", in_process=True)
    return {name: folder / f"{name}.mcap" for name in CRANES}


def table(found: Facts, title: str) -> Table:
    return next(table for table in tables_of(found) if table.title == title)


def column(made: Table, name: str) -> list[object]:
    (i,) = (i for i, x in enumerate(made.columns) if x.name == name)
    return [plain(row[i]) for row in made.rows]


def test_every_number_in_the_report_agrees_with_the_samples(recorded: Path) -> None:
    found = facts(Recording(recorded))
    ropes = table(found, "Ropes and slings")
    row = {name: column(ropes, name)[0] for name in ("rope", "peak tension", "at", "stage", "limit", "use")}
    use = pytest.approx(100 * 4.4 / 4.3)
    assert row == {"rope": "west.H1", "peak tension": 440.0, "at": 2.0, "stage": "take up", "limit": 430.0, "use": use}


def test_the_report_escapes_text_of_scenes_and_marks_utilisations_above_100_percent_red(
    recorded: Path, tmp_path: Path
) -> None:
    text = report(recorded, tmp_path / "report.html").read_text()
    assert "<b>lift</b>" not in text
    assert "&lt;b&gt;lift" in text
    assert "&lt;i&gt;7" in text
    assert "It has no verdict." in text
    assert re.findall(r'<td class="n red">(.*?)</td>', text) == ["102.3"]
    assert text.count("data:image/png;base64,") == 2
    with pytest.raises(RecordingError, match=r"must end in \.html, \.pdf, .* or \.dxf; choose such a name"):
        report(recorded, tmp_path / "report.doc")


def test_the_report_is_printed_to_pdf_if_a_browser_exists(
    recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if CHROMIUM:
        printed = report(recorded, tmp_path / "report.pdf").read_bytes()
        assert printed.startswith(b"%PDF")
        assert b"/MediaBox [0 0 594.95" in printed, "A4"
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(RecordingError) as error:
        report(recorded, tmp_path / "other.pdf")
    assert str(error.value) == (
        f"{tmp_path}/other.pdf: no Chromium or Chrome is installed to print a PDF; write {tmp_path}/other.html "
        "and print that from any browser"
    )


def test_the_report_of_a_recorded_mechanism_needs_neither_ropes_nor_stages(tmp_path: Path) -> None:
    run(load("pendulum", ["end=2 s"]), tmp_path / "pendulum.mcap", in_process=True)
    text = report(tmp_path / "pendulum.mcap", tmp_path / "pendulum.html").read_text()
    assert "<h2>Scene</h2>" in text
    assert "<h2>Stages</h2>" not in text
    assert "<svg" not in text, "nothing hangs on a hook"


@pytest.mark.parametrize("name", CRANES)
def test_the_report_table_of_each_quantity_contains_the_value_of_its_check_on_any_crane(
    lifts: dict[str, Path], name: str
) -> None:
    found = facts(Recording(lifts[name]))
    assert found.verdict is not None
    titles = {table.title for table in tables_of(found)}
    assert titles >= {"Checks", "Ropes and slings", "Hook load", "Smallest clearances", "Stages", "Path of the block"}
    ropes = table(found, "Ropes and slings")
    peaks = dict(zip(column(ropes, "rope"), column(ropes, "peak tension"), strict=True))
    assert peaks == {rope: peak.tension / 1e3 for rope, peak in found.peaks.items()}
    for check in (c for c in found.verdict.checks if c.basis and c.value is not None and c.quantity != "clearance"):
        value = check.value * OF_QUANTITY.get(check.quantity, UNITS.get(check.unit, 1.0))
        if check.quantity in ("rope tension", "sling tension"):
            row = dict(zip(column(ropes, "rope"), ropes.rows, strict=True))[check.subject]
            assert any(x == pytest.approx(value, rel=1e-9) for x in row if isinstance(x, float))
        else:
            made = table(found, check.quantity.capitalize())
            assert (check.subject, value) in zip(column(made, "item"), column(made, "worst"), strict=True)
    (least,) = (c.value for c in found.verdict.checks if c.quantity == "clearance" and c.basis)
    assert min(column(table(found, "Smallest clearances"), "smallest")) == least


def test_the_report_contains_tables_computed_from_the_scene(recorded: Path) -> None:
    verdict = msgspec.convert(
        {"red": False, "line": "GREEN", "tables": [{"title": "Mats", "columns": [{"name": "mat"}], "rows": [["A"]]}]},
        RecordedVerdict,
    )
    assert column(table(facts(Recording(recorded), verdict), "Mats"), "mat") == ["A"]


def test_a_report_compares_two_alternatives(lifts: dict[str, Path], tmp_path: Path, monkeypatch) -> None:
    a, b = (facts(Recording(lifts[name])) for name in ("crawler", "hall"))
    sheet = alternatives(a, b)
    assert (sheet.title, sheet.state) == ("crawler and hall", "red")
    uses = next(table for table in sheet.tables if table.title == "Largest use of each quantity")
    hook = next(row for row in uses.rows if row[0] == "hook load")
    most = [max(c.use for c in f.verdict.checks if c.quantity == "hook load") for f in (a, b)]
    assert [hook[3], hook[7]] == [100 * use for use in most]
    monkeypatch.setattr("sys.argv", ["heavylift", "report", *(str(f.rec.path) for f in (a, b)), "-o", "both.json"])
    monkeypatch.chdir(tmp_path)
    main()
    assert json.loads((tmp_path / "both.json").read_text())["title"] == "crawler and hall"


def test_the_report_names_the_project_that_the_scene_or_the_command_states(tmp_path: Path, capsys, monkeypatch) -> None:
    project = "project={name: Block <17>, number: 4711, author: A. Planner, date: 2026-11-28, revision: 2}"
    run(load("lift", ["end=2 s", project]), tmp_path / "lift.mcap", in_process=True)
    monkeypatch.setattr(
        "sys.argv", ["heavylift", "report", str(tmp_path / "lift.mcap"), "--json", "--author", "B. Other"]
    )
    main()
    found = json.loads(capsys.readouterr().out)
    assert found["title"] == "Lift report: Block <17>"
    assert found["tables"][0]["rows"][:3] == [
        ["project", "4711, Block <17>", "", ""],
        ["revision", "2", "2026-11-28", ""],
        ["prepared", "B. Other", "2026-11-28", ""],
    ]


def test_the_printed_report_of_a_lift_has_blank_cells_for_signatures(lifts: dict[str, Path]) -> None:
    issue = report_sheet(Recording(lifts["hall"]), revision="B", author="A. Planner").tables[0]
    assert issue.blank
    assert [row[0] for row in issue.rows] == ["revision", "prepared", "checked", "approved"]
    assert issue.rows[0][1] == "B"
    assert issue.rows[3][1:] == ("", "", "")


def test_a_missing_report_library_is_named_with_its_extra(recorded: Path, tmp_path: Path, monkeypatch) -> None:
    for library, ending, message in (("openpyxl", ".xlsx", "xlsx"), ("ezdxf", ".dxf", "drawings")):
        monkeypatch.setitem(sys.modules, library, None)
        with pytest.raises(RecordingError, match=rf"need.? {library}: pip install 'heavylift\[{message}\]'"):
            report(recorded, tmp_path / f"lift{ending}")
        assert not (tmp_path / f"lift{ending}").exists()
