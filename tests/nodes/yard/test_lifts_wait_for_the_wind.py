"""Weather of a yard: lifts wait for calm wind, are interrupted by strong wind, and continue."""

import random
import re
from bisect import bisect_left
from collections import Counter
from datetime import date, datetime, timedelta
from itertools import pairwise
from math import log
from pathlib import Path

import pytest
from heavylift.kernel import HeavyliftError, SceneError
from heavylift.nodes.devs import NEVER, Simulator
from heavylift.nodes.yard import HOUR, HourlySeries, Lift, Weather, coupled, load

START = date(2027, 1, 4)


def drawn(months, scale=6.0, shape=2.0, persistence=0.8, seed=5):
    wind = HourlySeries(START, scales=(scale,) * 12, shapes=(shape,) * 12, persistence=persistence)
    own, found = random.Random(seed), []
    state = wind.begin(own, True)
    for day in range(30 * months):
        hours, state = wind.hours(day, state, own)
        found += hours
    return found


@pytest.mark.parametrize(("scale", "shape"), [(6.0, 2.0), (9.0, 1.6)])
def test_random_wind_has_the_weibull_distribution_of_its_month(scale, shape):
    found = sorted(drawn(240, scale, shape))
    for p in (0.1, 0.5, 0.9, 0.99):
        assert found[int(p * len(found))] == pytest.approx(scale * (-log(1 - p)) ** (1 / shape), rel=0.03)


def test_random_wind_has_the_stated_correlation_from_hour_to_hour():
    """The share of hours after a strong one that are strong is that of two normal variables with this correlation."""
    found = drawn(480, persistence=0.8)
    limit = 6.0 * (-log(0.5)) ** 0.5  # the median: P(both above) = 1/4 + asin(rho) / (2 pi)
    both = sum(a > limit and b > limit for a, b in pairwise(found)) / len(found)
    assert both == pytest.approx(0.25 + 0.9273 / (2 * 3.14159265), abs=0.006)


def test_the_weather_model_reports_when_the_wind_crosses_a_limit_and_how_long_each_calm_lasts():
    draw, limits = random.Random(3), (3.0, 5.0, 8.0)
    speeds = tuple(draw.uniform(0, 10) for _ in range(24 * 20))
    model = Weather("weather", HourlySeries(START, speeds), limits, 0)
    simulator = Simulator(model)
    simulator.start()
    told = {}
    for _ in range(200):
        hour = simulator.next_time.t // HOUR
        told[hour] = model.change
        simulator.step() if hasattr(simulator, "step") else simulator.run(simulator.next_time.t + 1)
    hours = [
        0,
        *(n for n in range(1, max(told) + 1) if bisect_left(limits, speeds[n]) != bisect_left(limits, speeds[n - 1])),
    ]
    assert [*told] == hours
    for hour, change in told.items():
        assert change.speed == speeds[hour]
        for k, limit in enumerate(limits):
            above = next(n for n in range(hour, len(speeds)) if speeds[n] > limit)
            assert change.calm[k] == (above * HOUR if above > hour else -1)


BLOCKS = "block,after,mass [t]\nA,,100\nB,A,200\n"
YARD = """
heavylift yard: 1
start: 2027-01-04
weather: {{wind: {{series: wind.csv}}, forecast: {forecast}}}
resources: {{crane: {{type: goliath-900, units: 1}}}}
blocks: {{from: blocks.csv}}
steps:
  erect: {{lift: lift, set: {{block.mass: =mass}}, takes: 1 h}}
"""


def written(folder, speeds, forecast="0 h", text=YARD, blocks=BLOCKS):
    begin = datetime(2027, 1, 4)
    rows = [f"{begin + timedelta(hours=n):%Y-%m-%d %H:%M},{speed}" for n, speed in enumerate(speeds)]
    (folder / "wind.csv").write_text("\n".join(["time,wind [m/s]", *rows]) + "\n")
    (folder / "blocks.csv").write_text(blocks)
    (folder / "yard.yaml").write_text(text.format(forecast=forecast))
    return folder / "yard.yaml"


def three_hours(orders):
    """Lifts of three hours that begin up to 8 m/s, stop above 10 m/s and go on up to 7 m/s."""
    return [Lift((("up", 3600.0), ("down", 7200.0)), 8.0, 10.0, 7.0) for _ in orders]


def ran(yard):
    model = coupled(yard)
    simulator = Simulator(model)
    simulator.start()
    simulator.run(NEVER - 1)
    schedule = model.children["dispatcher"].result()
    return [t / 3600 for t in schedule.starts], [t / 3600 for t in schedule.ends], schedule, model


def test_wind_makes_a_lift_wait_stop_and_continue(tmp_path):
    #         0  1  2  3  4  5   6   7  8  9  10 ...
    speeds = [9, 9, 5, 5, 9, 11, 10, 8, 7, 6] + [5] * 38
    yard = load(written(tmp_path, speeds), lifter=three_hours)
    starts, ends, schedule, model = ran(yard)
    assert starts == [2, 9]  # above 8 m/s it does not begin
    assert ends == [9, 13]  # three of its four hours are done at 5, when 11 m/s stop it; 7 m/s at 8 let it go on
    work = model.children["step-erect"].result()
    assert (work.stopped, work.stops) == (3 * 3600.0, 1)
    assert schedule.waits[2] == 2 * 3600.0


@pytest.mark.parametrize(("forecast", "start"), [("0 h", 0), ("2 h", 0), ("3 h", 5), ("9 h", 5)])
def test_a_lift_begins_if_the_wind_forecast_stays_within_its_limit(tmp_path, forecast, start):
    speeds = [5, 5, 9, 5, 9, 5, 5, 5, 5, 5] + [5] * 38
    assert ran(load(written(tmp_path, speeds, forecast), lifter=three_hours))[0][0] == start


def test_lifts_in_random_wind_begin_and_end_at_the_times_found_by_stepping_hour_by_hour(tmp_path):
    for seed in range(10):
        draw = random.Random(seed)
        speeds = [draw.randint(4, 12) for _ in range(24 * 30)]
        starts, ends, *_ = ran(load(written(tmp_path, speeds), lifter=three_hours))
        hour = 0
        for start, end in zip(starts, ends, strict=True):
            hour = next(n for n in range(hour, 9999) if speeds[n] <= 8)
            assert start == hour
            hour = next(n for n in range(hour + 1, 9999) if speeds[n] <= 8)  # after an hour of rigging in any wind
            left, stands = 3, False
            while left:
                stands = speeds[hour] > (7 if stands else 10)
                left -= not stands
                hour += 1
            assert end == hour


def test_strong_wind_does_not_stop_rigging_but_delays_the_lift_of_the_rigged_block(tmp_path):
    speeds = [5, 5, 20, 20, 9, 9, 8, 10, 5] + [5] * 38
    text = YARD.replace("takes: 1 h", "takes: 3 h")
    starts, ends, _, model = ran(load(written(tmp_path, speeds, text=text), lifter=three_hours))
    work = model.children["step-erect"].result()
    assert (starts[0], ends[0]) == (0, 9), "rigged at 3, lifted from 6, when 8 m/s allow it"
    assert (work.stopped, work.stops) == (3 * 3600.0, 0)


def test_a_lift_for_which_the_wind_is_always_too_strong_is_reported_by_name(tmp_path):
    with pytest.raises(HeavyliftError, match="A erect waits forever for weather"):
        ran(load(written(tmp_path, [9] * 48), lifter=three_hours))


def test_a_lift_without_weather_limits_begins_when_its_crane_is_free(tmp_path):
    text = YARD.replace("weather: {{wind: {{series: wind.csv}}, forecast: {forecast}}}\n", "")
    assert ran(load(written(tmp_path, [20] * 48, text=text), lifter=three_hours))[1] == [4, 8]


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("wind.csv", "05:00,5", "05:30,5", r"wind.csv:7:1: error: .*does not follow an hour"),
        ("wind.csv", "05:00,5", "05:00,-5", r"wind.csv:7:18: error: .*positive number"),
        ("wind.csv", "05:00,5", "05:00,calm", r"wind.csv:7:18: error: .*'calm'"),
        ("wind.csv", "time,", "hour,", r"wind.csv:1:1: error: .*the columns are time, wind"),
        ("yard.yaml", "series", "serie", r"yard.yaml:4:\d+: error: .*not known here"),
        ("yard.yaml", "lift: lift", "lift: lifft", r"yard.yaml:8:\d+: error: .*lifft"),
        ("yard.yaml", "goliath-900", "goliath-840", r"yard.yaml:8:\d+: error: .*the yard has no 'goliath-900'"),
        ("yard.yaml", "=mass", "=weight", r"blocks.csv:2:1: error: .*sets the weight of 'A', which has none"),
        ("yard.yaml", "=mass}", "=mass}, by: magic", r"yard.yaml:8:\d+: error: .*no way to know a lift 'magic'"),
        (
            "yard.yaml",
            "=mass}",
            "=mass}, by: table, over: {mass: 150..250 t by 50 t}",
            r"blocks.csv:2:4: error: .*beyond",
        ),
        (
            "yard.yaml",
            "=mass}",
            "=mass}, by: table, over: {mass: 50..250 kg by 50 kg}",
            r"blocks.csv:2:4: error: .*unit",
        ),
        ("yard.yaml", "=mass}", "=mass}, by: table", r"yard.yaml:8:\d+: error: .*needs 'by: table', and axes"),
        ("yard.yaml", "lift: lift, set", "set", r"yard.yaml:8:\d+: error: .*for steps with a 'lift'"),
    ],
)
def test_invalid_lifts_and_weather_data_of_a_yard_are_reported_with_their_line(tmp_path, file, old, new, message):
    path = written(tmp_path, [5] * 48)
    text = (tmp_path / file).read_text()
    assert old in text
    (tmp_path / file).write_text(text.replace(old, new, 1))
    with pytest.raises(SceneError, match=message):
        load(path, lifter=three_hours)


def test_yard_settings_that_do_not_fit_a_scene_are_reported_at_the_row_of_the_block(tmp_path):
    path = written(tmp_path, [5] * 48, text=YARD.replace("block.mass: =mass", "block.weight: =mass"))
    with pytest.raises(SceneError, match=r"blocks.csv:2:1: error: .*block 'A': .*weight"):
        load(path)


def test_a_block_that_cannot_be_lifted_is_listed_as_a_finding_of_the_yard(tmp_path):
    from heavylift.nodes.yard import examined

    yard = load(written(tmp_path, [5] * 48, blocks=BLOCKS.replace("200", "1200")))
    sheet = examined(yard)
    assert sheet.state == "red"
    assert "1 lift cannot be carried out, first B" in sheet.lead
    (table,) = [x for x in sheet.tables if x.title == "Lifts that cannot be carried out"]
    ((block, step, why),) = table.rows
    assert (block, step) == ("B", "erect")
    assert re.match(r"blocks\.csv:3:\d+: \S", str(why.value)), "its file, row and column, and why"


def test_lifts_outside_the_table_of_simulated_lifts_are_computed_by_statics():
    """The bundled yard: its table reaches all blocks but those that two goliaths carry."""
    found = load("vlcc", lifter=three_hours).activities
    ways = [(one.order.way, Path(one.order.scene).name) for one in found if one.order]
    assert Counter(ways) == {("table", "vlcc-goliath.yaml"): 194, ("rest", "vlcc-tandem.yaml"): 6}
