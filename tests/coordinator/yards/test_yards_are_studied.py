"""What-if of a yard: variants, limits, sensitivities, two plans beside each other, schedules that are planned."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from heavylift.coordinator.yards import YardStudy, axis_of
from heavylift.kernel import SceneError

YARD = """
heavylift yard: 1
start: 2027-01-04
resources: {crane: 1, crew: {units: 2}}
blocks: {from: blocks.csv}
steps:
  erect: {takes: uniform 4 h 8 h, needs: {crane: 1}}
  weld: {takes: lognormal mean 30 h sd 10 h, needs: {crew: 1}, after: erect}
contract: {delivery: 2027-01-08}
"""


@pytest.fixture
def study(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("yard.yaml").write_text(YARD)
    Path("blocks.csv").write_text("block,after\nA,\nB,\nC,\nD,\n")
    with ThreadPoolExecutor(1) as pool:
        yield YardStudy("yard.yaml", count=40, executor=pool)


def rows(sheet, n=0):
    return sheet.tables[n].rows


def test_all_combinations_of_a_yard_study_use_the_same_random_streams(study):
    sheet = study.varied(["resources.crew.units=1..4 by 1", "resources.crane={1, 2}"])
    assert [row[:2] for row in rows(sheet)] == [(f"{n}", f"{m}") for n in range(1, 5) for m in (1, 2)]
    ends = [row[4] for row in rows(sheet)]
    assert ends[0] > ends[2] > ends[4]  # more crews, earlier at P90
    assert sheet.state == "green"
    assert rows(sheet)[0][5].state == "red"


def test_the_limit_of_a_yard_lies_between_the_last_green_value_and_the_next_other_value(study):
    sheet = study.limit("resources.crew.units=4..1")
    (row,) = rows(sheet)
    assert float(row[1]) - float(row[2]) == 1
    assert study.of(f"resources.crew.units={row[1]}").state == "green"
    assert study.of(f"resources.crew.units={row[2]}").state != "green"


def test_sensitivities_of_a_yard_give_the_gain_from_one_more_resource(study):
    found = {row[0]: row[2] for row in rows(study.sensitivities())}
    assert set(found) == {
        "crane, one more",
        "crew, one more",
        "erect takes what is expected",
        "weld takes what is expected",
    }
    assert found["crew, one more"] > max(0.1, found["crane, one more"])


def test_the_reported_gain_without_weather_equals_the_delay_caused_by_a_storm(study):
    """A storm lasts to 4:00: erection begins then, instead of at midnight."""
    hours = [f"2027-01-{4 + n // 24:02} {n % 24:02}:00,{1.5 if n < 4 else 0.5}" for n in range(20 * 24)]
    Path("sea.csv").write_text("\n".join(["time,Hs [m]", *hours]) + "\n")
    text = YARD.replace("resources:", "weather: {sea: {series: sea.csv}, alpha: {12 h: 0.9}}\nresources:")
    Path("yard.yaml").write_text(text.replace("needs: {crane: 1}", "needs: {crane: 1}, limits: {Hs: 1 m}"))
    found = {row[0]: row[2] for row in rows(study.sensitivities())}
    assert found["no weather"] == pytest.approx(4 / 24, abs=1e-6)


def test_comparing_the_plan_of_a_yard_with_itself_shows_no_difference(study):
    Path("other.yaml").write_text(YARD.replace("{units: 2}", "{units: 3}"))
    assert rows(study.beside("yard.yaml"), 1) == ((0.0, 0.0, 0.0),)
    assert rows(study.beside("other.yaml"), 1)[0][1] < 0


def test_an_optimised_schedule_is_written_and_its_robustness_simulated(study):
    pytest.importorskip("ortools")
    sheet = study.planned("planned.csv", 2.0, False)
    assert "gap" in sheet.lead
    assert Path("planned.csv").read_text().startswith("block,step,start,end")
    assert [row[0] for row in rows(sheet)] == ["as it is", "plan planned.csv"]


@pytest.mark.parametrize("text", ["resources.crew", "a=3..1 by 1", "=3"])
def test_a_yard_study_with_an_invalid_axis_is_refused(text):
    with pytest.raises(SceneError, match="--vary"):
        axis_of(text)
