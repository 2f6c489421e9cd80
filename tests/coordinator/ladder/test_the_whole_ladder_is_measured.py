"""`tradeoff`, `--within` and `--accuracy` are views of one ladder: a table, its page, settings that repeat a run."""

from __future__ import annotations

import csv
import json
import shlex
from itertools import pairwise
from pathlib import Path

import pytest
from heavylift.coordinator.cli import main
from heavylift.coordinator.ladder import MeasuredLadder, measure, write
from heavylift.coordinator.ladder.within import within
from heavylift.coordinator.run.simulate import simulate
from heavylift.kernel import SceneError
from heavylift.nodes.plan import MEANT
from heavylift.nodes.scene import load

SCENE = ["end=20 s"]


@pytest.fixture(scope="module")
def measured() -> MeasuredLadder:
    return measure(load("hall", SCENE), "rope tension", limit=1e-3, budget=120.0)


def test_tighter_time_steps_give_smaller_errors_and_the_cheapest_sufficient_model_level_is_recommended(
    measured: MeasuredLadder,
) -> None:
    errors = [row.worst for row in measured.rows]
    assert errors[-1] < errors[0]
    passing = [row for row in measured.rows if row.worst <= 1e-3]
    assert measured.pick is min(passing, key=lambda row: row.run_s)
    assert measured.advice.startswith(f"Use {measured.pick}: ")


def test_page_and_table_and_figure_of_a_speed_against_accuracy_trade_off_show_the_same_numbers(
    measured: MeasuredLadder, tmp_path: Path
) -> None:
    for kind in (".html", ".csv", ".json", ".png", ".svg"):
        write(measured, tmp_path / f"out{kind}")
    html, data = (tmp_path / "out.html").read_text(), json.loads((tmp_path / "out.json").read_text())
    assert measured.advice in html
    assert data["advice"] == measured.advice
    rows = list(csv.reader((tmp_path / "out.csv").read_text().splitlines()))
    assert len(rows) == 1 + len(data["rows"]) == 1 + len(measured.rows)
    assert "<script" not in html


def test_the_command_printed_in_a_row_of_the_trade_off_selects_its_method_and_tolerance(
    measured: MeasuredLadder,
) -> None:
    assert measured.pick is not None
    words = shlex.split(measured.pick.command)
    scene = load("hall", [word for before, word in pairwise(words) if before == "--set"])
    assert scene.question is None
    assert f"{scene.plan.method} at {scene.plan.tolerance:.0e}".replace("e-0", "e-") == measured.pick.how


@pytest.mark.parametrize(
    ("ask", "budget", "told"),
    [
        ("swng", 60.0, "is not a known quantity"),
        ("lift-off time", 60.0, "this run does not have that quantity"),
        ("", 1e-3, "too little"),
    ],
)
def test_a_trade_off_over_figures_that_cannot_be_measured_is_refused(ask: str, budget: float, told: str) -> None:
    with pytest.raises(SceneError, match=told):
        measure(load("pendulum", SCENE), ask, budget=budget)


def test_a_run_with_a_time_limit_reports_settings_that_reproduce_its_digest() -> None:
    found = within("pendulum", SCENE, MEANT, "2 h")  # of which the age of this process is a part
    same = [word for word in shlex.split(found.message.partition("the same run: ")[2]) if word != "--set"]
    assert simulate(found.scene).digest == simulate(load("pendulum", [*SCENE, *same])).digest


@pytest.mark.parametrize(
    ("given", "told"),
    [({"seconds": "1 ms"}, "the time is too short; this computer needs about"),
     ({"factor": -1.0}, "give a number greater than 0"),
     ({"seconds": "1 s", "rate": 1.0}, "give only one of --within"), ({"seconds": "soon"}, "--within 'soon'")],
)  # fmt: skip
def test_a_limit_of_wall_time_that_is_too_short_is_refused(given: dict[str, object], told: str) -> None:
    with pytest.raises(SceneError, match=told):
        within("pendulum", SCENE, MEANT, **given)  # type: ignore[arg-type]


def test_an_accuracy_without_named_quantities_applies_to_the_default_quantities(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["heavylift", "run", "pendulum", "--in-process", "--accuracy", "1 %", "--set", SCENE[0], "--json"]
    monkeypatch.setattr("sys.argv", words)
    main()
    answer = json.loads(capsys.readouterr().out)["answer"]
    assert {"swing", "position"} <= {*answer["errors"]}
    assert answer["told"].startswith("swing within ")
