"""A run says the same of its checks on the terminal, as JSON, in the report, on the 3D page and in a row of a sweep."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from heavylift.coordinator.commands import app
from heavylift.coordinator.sweeps import Task, Variant, played
from heavylift.nodes.limits import table_of
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from heavylift.recordings.documents import report_sheet
from heavylift.recordings.read import recorded_verdict
from heavylift.recordings.render.view import content
from heavylift.recordings.sheets import Sheet, data_of
from typer.testing import CliRunner

SCENES = ["crawler", "dock", "hall", "in-turn", "jib", "lift"]
LIMIT_S = 600.0  # of wall time


@pytest.mark.parametrize("name", SCENES)
def test_all_outputs_of_a_run_show_the_same_checks_and_the_same_unchecked_items(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()
    printed = runner.invoke(app, ["run", name, "--in-process", "-o", "run.mcap"]).output
    rec = Recording("run.mcap")
    verdict = recorded_verdict(rec)
    assert verdict is not None
    line, words = verdict.line, [(x.word, x.quantity, x.subject) for x in verdict.checks]
    (first,) = (x for x in printed.splitlines() if x.startswith("verdict: "))
    assert first == f"verdict: {line}"
    data = json.loads(runner.invoke(app, ["info", "run.mcap", "--json"]).output)["verdict"]
    assert data["line"] == line
    assert [(x.get("why") or x["state"], x["quantity"], x["subject"]) for x in data["checks"]] == words
    sheet = report_sheet(rec)
    tables = {x["title"]: x for x in data_of(sheet)["tables"]}
    assert line in sheet.lead
    (checks,) = data_of(Sheet("", "", "", (table_of(verdict.checks),)))["tables"]
    assert tables["Checks"]["rows"] == checks["rows"]
    facts = [tuple(x) for x in content(rec)["facts"]]
    assert ("verdict", line) in facts
    for what in verdict.not_modelled:
        assert what in printed
        assert f"Not modelled: {what}." in tables["Smallest clearances"]["notes"]
        assert ("not modelled", what) in facts
    row = played(Task.of(load(name), LIMIT_S, "none", True), Variant(0, (), ()))
    assert (row["verdict"], row["state"]) == (line, verdict.state)
