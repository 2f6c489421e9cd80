"""Steps whose wave limit depends on peak period and direction, against windows found hour by hour."""

import random
from datetime import datetime, timedelta
from itertools import pairwise

import pytest
from heavylift.coordinator.yards import run_yard
from heavylift.kernel import SceneError
from heavylift.nodes.devs import NEVER, Simulator
from heavylift.nodes.yard import coupled, examined, load

YARD = """
heavylift yard: 1
start: 2027-01-04
weather: {sea: {series: sea.csv}, alpha: {6 h: 1, 48 h: 0.9}}
resources: {vessel: 1}
blocks: {from: blocks.csv}
steps:
  lift: {takes: 4 h, needs: {vessel: 1}, limits: {Hs: %s}}
"""
BY_PERIOD = "{6 s: 2 m, 8 s: 1.2 m, 10 s: 0.8 m}"
LIMITS = {6.0: 2.0, 8.0: 1.2, 10.0: 0.8}


def written(folder, hours, limit=BY_PERIOD, columns="Hs [m],Tp [s],from [deg]", blocks="block,after\nA,\n", more=""):
    begin = datetime(2027, 1, 4)
    rows = [f"{begin + timedelta(hours=n):%Y-%m-%d %H:%M},{','.join(map(str, x))}" for n, x in enumerate(hours)]
    (folder / "sea.csv").write_text("\n".join([f"time,{columns}", *rows]) + "\n")
    (folder / "blocks.csv").write_text(blocks)
    (folder / "yard.yaml").write_text(YARD % limit + more)
    return load(folder / "yard.yaml")


def starts(of):
    model = coupled(of, 0)
    simulator = Simulator(model)
    simulator.start()
    simulator.run(NEVER - 1)
    return [t / 3600 for t in model.children["dispatcher"].result().starts]


@pytest.mark.parametrize(
    ("height", "period", "allowed"),
    [
        (2.0, 6.0, True),
        (2.01, 6.0, False),
        (1.2, 7.9, True),  # between two periods the lower of both limits holds
        (1.3, 6.1, False),
        (1.2, 8.0, True),
        (0.8, 8.1, True),
        (0.81, 9.9, False),
        (0.8, 10.0, True),
        (0.1, 10.1, False),  # no limit was ever computed there
        (0.1, 5.9, False),
    ],
)
def test_each_hour_of_sea_data_is_compared_with_the_wave_limit_at_the_peak_period_of_that_hour(
    tmp_path, height, period, allowed
):
    sea = [(height, period, 0)] * 30 + [(0.1, 8.0, 0)] * 30
    assert starts(written(tmp_path, sea)) == [0 if allowed else 30]


def test_a_swell_of_long_period_closes_a_weather_window_that_its_height_alone_leaves_open(tmp_path):
    """Hs is 1 m throughout; the period is above 8 s from hour 2 to 6, so the first 4 hours in a row begin at 7."""
    sea = [(1.0, 9.0 if 2 <= n < 7 else 7.0, 0) for n in range(48)]
    assert starts(written(tmp_path, sea)) == [7]
    assert starts(written(tmp_path, sea, "1 m")) == [0]


@pytest.mark.parametrize(("sector", "start"), [("330..30 deg", 4), ("30..330 deg", 0)])
def test_waves_from_outside_the_allowed_sector_of_a_yard_step_close_its_weather_window(tmp_path, sector, start):
    """From 90 degrees at first, and then from 30 degrees, at an edge of the first two sectors."""
    sea = [(0.5, 7.0, 90)] * 4 + [(0.5, 7.0, 30)] * 44
    assert starts(written(tmp_path, sea, f"1 m, from: {sector}")) == [start]


@pytest.mark.parametrize("seed", range(8))
def test_weather_windows_in_a_random_sea_agree_with_a_search_over_all_hours(tmp_path, seed):
    draw = random.Random(seed)
    periods = sorted(draw.sample(range(4, 16), draw.randint(2, 6)))
    limits = {float(x): round(draw.uniform(0.4, 1.5), 2) for x in periods}
    first, width = draw.randrange(360), draw.randrange(90, 300)
    sea = [(0.8, 8.0, 0)]
    while len(sea) < 24 * 60:
        h, p, d = sea[-1]
        h, p = max(0.1, round(h + draw.gauss(0.0, 0.08), 2)), min(max(round(p + draw.gauss(0.0, 0.4), 1), 3.0), 16.0)
        sea.append((0.8 + 0.9 * (h - 0.8), p, (d + draw.randrange(-9, 10)) % 360))
    sea += [(0.0, float(periods[0]), first)] * 48  # at last it is calm

    def limit(period):
        if period in limits:
            return limits[period]
        return min((min(limits[a], limits[b]) for a, b in pairwise(limits) if a < period < b), default=-1.0)

    takes = [draw.randint(2, 9) for _ in range(5)]
    blocks = "block,after,lift\n" + "".join(
        f"{b},{a},{t} h\n" for b, a, t in zip("ABCDE", ["", *"ABCD"], takes, strict=True)
    )
    text = "{" + ", ".join(f"{p:g} s: {h} m" for p, h in limits.items()) + f"}}, from: {first}..{first + width} deg"
    hour, want = 0, []
    for t in takes:
        factor = 1.0 if t <= 6 else 0.9
        good = [h <= factor * limit(p) and (d - first) % 360 <= width for h, p, d in sea]
        hour = next(n for n in range(hour, len(sea)) if all(good[n : n + t]))
        want.append(hour)
        hour += t
    assert starts(written(tmp_path, sea, text, blocks=blocks)) == want


def test_a_lift_planned_outside_its_weather_window_is_postponed_to_the_next_window(tmp_path):
    """Planned for hour 10, at which the period is above the limit until hour 15."""
    (tmp_path / "plan.csv").write_text("block,step,start,end\nA,lift,2027-01-04 10:00,2027-01-04 14:00\n")
    sea = [(1.0, 9.0 if 8 <= n < 15 else 7.0, 0) for n in range(48)]
    assert starts(written(tmp_path, sea, more="plan: plan.csv\n")) == [15]
    assert starts(written(tmp_path, sea, "1 m", more="plan: plan.csv\n")) == [10]


def test_a_sea_without_periods_is_compared_with_the_lowest_limit_and_the_report_says_so(tmp_path):
    sea = [(0.9,)] * 30 + [(0.8,)] * 30
    of = written(tmp_path, sea, columns="Hs [m]")
    assert starts(of) == [30]
    for sheet in (examined(of), run_yard(str(tmp_path / "yard.yaml"), in_process=True)[0]):
        assert "the sea has no peak periods, so the limit is the lowest of all, 0.8 m" in str(sheet.parts)
    assert "peak periods" not in str(examined(written(tmp_path, sea, "1 m", "Hs [m]")).parts)


def test_hours_whose_waves_are_longer_than_all_periods_of_a_limit_are_counted_in_the_report(tmp_path):
    of = written(tmp_path, [(0.1, 12.0, 0)] * 5 + [(0.1, 8.0, 0)] * 30)
    assert "closed in 5 of 35 hours" in str(examined(of).parts)


@pytest.mark.parametrize(
    ("limit", "columns", "words"),
    [
        ("{8 s: 1 m}", "Hs [m],Tp [s],from [deg]", "write one height for each of two or more periods"),
        ("{6 s: 1 m, 8 m: 2 m}", "Hs [m],Tp [s],from [deg]", "8 m"),
        ("{6 s: 1 m, 8 s: 0 m}", "Hs [m],Tp [s],from [deg]", "write a height above 0"),
        ("1 m, from: north", "Hs [m],Tp [s],from [deg]", "is not a valid sector"),
        ("1 m, from: 0..90 deg", "Hs [m],Tp [s],wind [m/s]", "the sea has no directions"),
        ("1 m, from: 90..90 deg", "Hs [m],Tp [s],from [deg]", "a sector without width"),
        ("1 m", "Hs [m],Tp [m],from [deg]", "sea.csv:2"),
        ("1 m", "Hs [m],Tz [s],from [deg]", "the columns are"),
    ],
)
def test_invalid_wave_limits_that_depend_on_the_period_are_reported_in_one_sentence(tmp_path, limit, columns, words):
    with pytest.raises(SceneError, match=words):
        written(tmp_path, [(1.0, 7.0, 3)] * 24, limit, columns)
