"""Lifts that were green once without being checked, each with the state and the exit codes that are right."""

from __future__ import annotations

import os
from math import inf
from pathlib import Path

import pytest
from heavylift.coordinator.commands import app
from heavylift.nodes.limits import percent
from heavylift.nodes.scene import load
from typer.testing import CliRunner

FOLDER = Path(__file__).parents[2] / "data" / "planners"
WHOLE = 1e-3  # of the block's weight, which its slings bear
SCENES = {  # what `check` and `run --strict` say, both with exit code 1
    "boom": "the block went",
    "steep": "bridle angle of legs.sling-",
    "hit3": "the block touched shed, which nothing orders",
    "hit4": "hit4.yaml:4:3: error: obstacles.shed: 'block' begins 1 m inside of 'shed'",
    "hit5": "hit5.yaml:4:3: error: obstacles.shed: 'block' begins 0.5 m inside of 'shed'",
    "cert": "at the worst of block.mass 510 t +- 5 %",
    "gap": "gap.csv:2:5: error: block.mass: the row 'B12' is empty in column 'mass'",
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.large(beyond=4)
def test_the_commands_check_and_run_report_the_same_reason_for_a_red_lift(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    scene, runner = os.path.relpath(FOLDER / f"{name}.yaml", tmp_path), CliRunner()
    checked = runner.invoke(app, ["check", scene])
    ran = runner.invoke(app, ["run", scene, "--in-process", "--strict", "-o", "run.mcap"])
    for result in (checked, ran):
        message = result.output or str(result.exception)
        assert (result.exit_code, SCENES[name] in message) == (1, True), message
        assert "error: " in message or ": RED: " in message
    for state in ("red", "undecided", "amber"):
        assert runner.invoke(app, ["check", scene, "--fail-on", state]).exit_code == 1


def test_the_assembly_load_is_reported_even_at_sling_angles_where_no_load_is_allowed() -> None:
    scene = load(str(FOLDER / "steep.yaml"))
    (row,) = (check for check in scene.checks if check.quantity == "assembly load")
    assert row.use == inf
    assert row.value == pytest.approx(30e3, rel=WHOLE), "the whole block, not what the ropes bore first"
    assert (row.shown, percent(row.use)) == ("30.0 t", "infinite")
