"""`run --replications`, `limits --replications` and `limits --scatter` as a user gives them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from heavylift.coordinator.commands import app
from typer.testing import CliRunner

SCENE = """\
heavylift: 1
name: sea
end: 12 s
samples: 2 Hz
method: dopri5
accuracy: 5%
waves: {seas: {wind: {Hs: 0.5 m, Tp: 8 s, components: 10}}, heading: 150 deg, ramp: 2 s}
limits: {signals: [height of barge <= 0.5 m]}
vessels:
  barge:
    mass: 14432 t
    type: barge-110
    com: [0 m, 0 m, 2 m]
    floating: {mooring: {surge: 400 kN/m, sway: 400 kN/m, yaw: 400 MN m/rad}}
actions: [{wait: 1 s}]
"""
COMMON = ["sea.yaml", "--replications", "10", "--json"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "sea.yaml").write_text(SCENE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_run_over_many_seeds_prints_the_quantiles_of_its_results_and_writes_them_to_a_file(here: Path) -> None:
    """Its table has the checks on the quantile, which strict exit codes follow; the report is the same sheet."""
    done = CliRunner().invoke(app, ["run", *COMMON, "--report", "seeds.json", "--fail-on", "amber"])
    sheet = json.loads(done.stdout)
    assert sheet == json.loads((here / "seeds.json").read_text())
    assert sheet["title"] == "sea: P90 over 10 seeds"
    checks, quantiles = sheet["tables"]
    assert ["sea state", "all", "P90"] in [row[1:4] for row in checks["rows"]]
    (row,) = quantiles["rows"]
    assert row[:2] == ["signal", "height of barge"]
    value, bound, mean, largest = (float(x.split()[0]) for x in row[2:6])
    assert mean <= value <= bound
    assert mean <= largest
    assert done.exit_code == (0 if sheet["state"] == "green" else 1)


def test_options_that_apply_to_a_single_run_are_refused_in_a_run_over_many_seeds(here: Path) -> None:
    done = CliRunner().invoke(app, ["run", *COMMON, "-o", "one.mcap"])
    assert done.exit_code == 2
    assert "-o is for a single run" in done.stderr
    assert not list(here.glob("*.mcap"))


def test_a_scatter_table_gives_the_share_of_time_in_which_a_lift_passes(here: Path) -> None:
    """Waves of half a metre heave the barge less than its limit, waves of forty metres more."""
    (here / "scatter.csv").write_text("Hs \\ Tp, 6, 9\n0.5, 10, 20\n40, 1, 4\n")
    done = CliRunner().invoke(app, ["limits", *COMMON, "--scatter", "scatter.csv", "-o", "operability.json"])
    assert done.exit_code == 0
    sheet = json.loads((here / "operability.json").read_text())
    assert sheet["lead"].endswith(f"in {3000 / 35:.1f} % of the time (30 of 35 occurrences)")
    assert [row[:3] for row in sheet["tables"][0]["rows"]] == [[6.0, 0.5, 11.0], [9.0, 0.5, 24.0]]


def test_a_lift_that_passes_in_no_sea_of_the_table_gives_exit_code_1(here: Path) -> None:
    (here / "scatter.csv").write_text("Hs \\ Tp, 9\n40, 4\n")
    done = CliRunner().invoke(app, ["limits", *COMMON, "--scatter", "scatter.csv"])
    assert (done.exit_code, json.loads(done.stdout)["state"]) == (1, "red")


@pytest.mark.parametrize("option", ["--depth 15", "--volume 3", "--height 2", "--length 7"])
def test_options_that_do_not_suit_the_kind_of_hull_data_are_refused(here: Path, option: str) -> None:
    done = CliRunner().invoke(app, ["hull", "x.nc", *option.split()])
    assert done.exit_code
    assert f"take no {option.split()[0]}" in str(done.exception)


@pytest.mark.parametrize("option", [["--gap-damping", "0.05"], ["--gap-source", "a model test"]])
def test_a_gap_damping_without_a_source_is_refused_and_so_is_a_source_alone(here: Path, option: list[str]) -> None:
    done = CliRunner().invoke(app, ["hull", "x.nc", *option])
    assert done.exit_code
    assert "give --gap-damping together with --gap-source" in str(done.exception)
