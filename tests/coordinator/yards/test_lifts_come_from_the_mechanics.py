"""Lifts of a yard at rest, from a table, and simulated where they begin: the same day within their stated errors."""

from dataclasses import replace
from pathlib import Path

import pytest
from heavylift.coordinator.commands.common.app import app
from heavylift.coordinator.replay import RecordedRun
from heavylift.coordinator.run import resume_model
from heavylift.coordinator.run.verify import verify
from heavylift.coordinator.yards import in_place, interpolated, load_yard, ran, run_yard
from heavylift.nodes.scenes import bundled
from heavylift.nodes.yard import LiftOrder, YardWeather, at_rest, expected
from typer.testing import CliRunner

YARD = """
heavylift yard: 1
start: 2027-01-04
weather: {wind: {monthly: wind.csv, persistence: 0.9}}
resources: {goliath: {type: goliath-900, units: 1}}
blocks: {from: blocks.csv}
steps:
  erect: {lift: crane.yaml, set: {block.mass: =mass}, WAY}
contract: {delivery: 2027-01-06}
"""
WAYS = {"rest": "by: rest", "run": "by: run", "table": "by: table, over: {mass: 200..300 t by 100 t}"}
BLOCKS = "block,after,mass [t]\nA,,210\nB,A,285\n"
WIND = "month,scale [m/s],shape\n" + "".join(f"{n},6,2\n" for n in range(1, 13))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = bundled()["lift"].read_text().replace("limits: {", "limits: {wind: 9 m/s, ")
    scene = scene.replace("wind: 10 m/s, area", "wind: 9 m/s, area")
    gust = "interlocks:\n  gust: {when: wind >= 10 m/s, until: wind <= 8 m/s, stops: all}\n"
    Path("crane.yaml").write_text(f"{scene}wind: {{speed: 2 m/s, direction: [1, 0, 0]}}\n{gust}")
    Path("blocks.csv").write_text(BLOCKS)
    Path("wind.csv").write_text(WIND)
    return tmp_path


def written(way):
    Path("yard.yaml").write_text(YARD.replace("WAY", WAYS[way]))
    return "yard.yaml"


def test_the_wind_limits_to_begin_stop_and_resume_a_lift_are_those_of_the_scene(folder):
    lift = at_rest(LiftOrder("crane.yaml", ("block.mass=250 t",)))
    assert (lift.wind, lift.stop, lift.resume, lift.state) == (9.0, 10.0, 8.0, "green")
    assert [name for name, _ in lift.stages] == ["take up slack", "lift off", "up", "sideways", "swing"]
    assert lift.stages[-1][1] == pytest.approx(20.0)


def test_lift_durations_from_statics_and_from_a_table_agree_with_simulation_within_their_stated_error(folder):
    ends = {}
    for way in WAYS:
        yard = load_yard(written(way))
        ends[way] = [one.lift.seconds for one in yard.activities]
        if way != "run":
            errors = [one.lift.error * one.lift.seconds for one in yard.activities]
            assert 0 < max(one.lift.error for one in yard.activities) < 0.02
            simulated = [in_place(one.order, 2.0).seconds for one in yard.activities]
            for found, true, error in zip(ends[way], simulated, errors, strict=True):
                assert abs(found - true) <= error
            end = expected(replace(yard, weather=YardWeather())).delivery
            assert abs(end - sum(simulated)) <= sum(errors) + 1e-6
    assert ends["table"] != ends["rest"]


@pytest.mark.large
def test_the_computed_wind_limit_agrees_with_a_search_over_runs(folder):
    found = ran(LiftOrder("crane.yaml", ("block.mass=250 t", "limits.wind=6 m/s"), windy=12.0))
    assert found.state == "green"
    assert 5.9 <= found.wind <= 6.0


def test_interpolation_in_a_lift_table_is_exact_for_multilinear_functions():
    import numpy as np

    axes = [np.array([1.0, 2.0, 5.0]), np.array([0.0, 10.0])]
    grid = np.array([[[x * y + 3 * x - y, 7.0] for y in axes[1]] for x in axes[0]])
    for x, y in [(1.0, 0.0), (5.0, 10.0), (3.3, 2.5), (2.0, 9.0)]:
        assert interpolated(axes, grid, (x, y)) == pytest.approx([x * y + 3 * x - y, 7.0])


def test_a_yard_run_with_simulated_lifts_has_one_digest_in_several_processes_and_if_verified_or_resumed(
    folder,
):
    sheet, made = run_yard(written("run"), output="a.mcap", in_process=True)
    assert sheet.state == "amber"
    assert run_yard("yard.yaml", processes=2)[1].digest == made.digest
    found = verify(RecordedRun(Path("a.mcap")))
    assert (found.same, found.digest) == (True, made.digest)
    whole = Path("a.mcap").read_bytes()
    Path("cut.mcap.part").write_bytes(whole[: len(whole) // 3])
    assert resume_model("cut.mcap.part").digest == made.digest
    assert CliRunner().invoke(app, ["resume", "cut.mcap.part", "-o", "again.mcap"]).exit_code == 0


def test_a_yard_has_a_red_verdict_if_a_simulated_lift_is_red(folder):
    text = Path("crane.yaml").read_text()
    Path("crane.yaml").write_text(
        text.replace("wind >= 10 m/s, until: wind <= 8 m/s", "wind >= 1 m/s, until: wind <= 0.5 m/s")
    )
    found = in_place(LiftOrder("crane.yaml", ("block.mass=250 t",), "run"), 2.0)
    assert found.state == "red"
    assert found.why
