"""Steps that wait for a weather window of the sea, with alpha factors, against windows found by hand."""

import random
from datetime import date, datetime, timedelta

import pytest
from heavylift.kernel import HeavyliftError, SceneError
from heavylift.nodes.devs import NEVER, Simulator
from heavylift.nodes.yard import HourlySeries, Weather, coupled, load

YARD = """
heavylift yard: 1
start: 2027-01-04
weather: {sea: {series: sea.csv}%s}
resources: {vessel: 1}
blocks: {from: blocks.csv}
steps:
  lift: {takes: %s, needs: {vessel: 1}, limits: {Hs: 1 m}%s}
"""
SHIFTS = YARD.replace("resources:", "calendar: {days: mon-sun, shifts: {day: '08:00-16:00'}}\nresources:")
ALPHA = ", alpha: {12 h: 0.93, 24 h: 89 %}"  # DNV-ST-N001, Hs 1 m


def yard(folder, heights, more=ALPHA, takes="12 h", step="", blocks="block,after\nA,\n", text=YARD, column="Hs [m]"):
    begin = datetime(2027, 1, 4)
    rows = [f"{begin + timedelta(hours=n):%Y-%m-%d %H:%M},{x}" for n, x in enumerate(heights)]
    (folder / "sea.csv").write_text("\n".join([f"time,{column}", *rows]) + "\n")
    (folder / "blocks.csv").write_text(blocks)
    (folder / "yard.yaml").write_text(text % (more, takes, step))
    return load(folder / "yard.yaml")


def starts(of, seed=0):
    model = coupled(of, seed)
    simulator = Simulator(model)
    simulator.start()
    simulator.run(NEVER - 1)
    found = model.children["dispatcher"].result()
    return [t / 3600 for t in found.starts], found.waits[2] / 3600


#         0                       10                                     20                     24
HEIGHTS = [0.9] * 10 + [0.95] * 2 + [0.92] * 6 + [0.95] + [0.90] * 12 + [0.5] * 12 + [1.2] + [0.5] * 50


@pytest.mark.parametrize(
    ("more", "takes", "start"),
    [
        ("", "12 h", 0),  # up to 1 m: all of the first 43 hours
        (ALPHA, "12 h", 19),  # up to 0.93 m: 10 h from 0, 6 h from 12, 24 h from 19
        (ALPHA, "13 h", 31 + 13),  # up to 0.89 m: 12 h from 31, then from 44 on
        (ALPHA, "6 h", 0),
        (", alpha: {24 h: 0.93}", "24 h", 19),
        (", alpha: {24 h: 0.93}", "25 h", None),
    ],
)
def test_a_step_begins_in_the_first_weather_window_that_is_long_enough_at_its_alpha_factor(
    tmp_path, more, takes, start
):
    of = yard(tmp_path, HEIGHTS, more, takes)
    if start is None:
        with pytest.raises(HeavyliftError, match="A lift needs a window of 25 h, longer than all with an alpha factor"):
            starts(of)
    else:
        assert starts(of) == ([start], start)


def test_the_weather_window_of_a_yard_step_that_pauses_at_night_includes_the_pause(tmp_path):
    """Eight working hours a day: twelve hours of work from Monday 8:00 end on Tuesday at 12:00, after 28 hours."""
    heights = [1.5] * 8 + [0.8] * 27 + [1.5] * 21 + [0.8] * 60
    of = yard(tmp_path, heights, ", alpha: {28 h: 0.9}", step=", works: day", text=SHIFTS)
    assert starts(of)[0] == [56], "from hour 8 only 27 hours are calm; the next shift in a calm sea begins at 56"
    of = yard(tmp_path, [1.5] * 8 + [0.8] * 28 + [1.5] * 80, ", alpha: {28 h: 0.9}", step=", works: day", text=SHIFTS)
    assert starts(of)[0] == [8]


@pytest.mark.parametrize("alpha", [ALPHA, ", alpha: {12 h: 0.93}"])
def test_a_yard_step_that_the_sea_prevents_late_in_a_shift_begins_in_the_next_shift(tmp_path, alpha):
    """From hour 14 on, four hours of work last 20 h (0.89, or no factor at all); from 8:00 on the next day, 4 h."""
    of = yard(tmp_path, [1.5] * 14 + [0.91] * 200, alpha, "4 h", ", works: day", text=SHIFTS)
    assert starts(of)[0] == [32]


def test_a_yard_step_is_refused_if_no_weather_window_can_ever_be_long_enough(tmp_path):
    of = yard(tmp_path, [0.5] * 48, ", alpha: {12 h: 0.93}", "9 h", ", works: day", text=SHIFTS)
    with pytest.raises(HeavyliftError, match="needs a window of 25 h, longer than all with an alpha factor"):
        starts(of)


@pytest.mark.parametrize("seed", range(12))
def test_steps_in_working_shifts_begin_in_the_first_weather_window_found_by_a_search_over_all_hours(tmp_path, seed):
    draw = random.Random(seed)
    heights = [1.5] * draw.randint(1, 24)
    while len(heights) < 24 * 120:
        heights += [draw.choice((0.88, 0.91, 0.95))] * draw.randint(3, 40) + [1.5] * draw.randint(1, 24)
    a, b = draw.randint(5, 8), draw.randint(14, 20)
    noon = draw.randint(a + 1, b - 2)
    text = SHIFTS.replace("08:00-16:00", f"{a:02}:00-{noon:02}:00 {noon + 1:02}:00-{b:02}:00")
    working = [a <= n % 24 < b and n % 24 != noon for n in range(24 * 120)]
    takes = draw.randint(3, b - a - 1)
    alpha = [(6, 0.97), (12, 0.93), (24, 0.89)]

    def end_of(hour):
        return [n for n in range(hour, hour + 48) if working[n]][takes - 1] + 1

    def allowed(hour):
        window = end_of(hour) - hour
        factor = next((x for length, x in alpha if window <= length), 0.0)
        return working[hour] and all(x <= factor for x in heights[hour : hour + window])

    listed = ", ".join(f"{length} h: {x}" for length, x in alpha)
    blocks = "block,after\n" + "".join(f"B{n},{f'B{n - 1}' if n else ''}\n" for n in range(15))
    of = yard(tmp_path, heights, f", alpha: {{{listed}}}", f"{takes} h", ", works: day", blocks, text)
    hour, want = 0, []
    for _ in range(15):
        want.append(next(n for n in range(hour, len(heights)) if allowed(n)))
        hour = end_of(want[-1])
    assert starts(of)[0] == want


def test_an_unchanging_sea_below_the_limit_offers_a_weather_window_longer_than_a_year(tmp_path):
    of = yard(tmp_path, [0.5] * 24, blocks="block,after\nA,\nB,A + 400 days\n")
    assert starts(of)[0] == [0, 12 + 400 * 24]


def test_wave_limits_do_not_delay_a_yard_without_weather_data(tmp_path):
    of = yard(tmp_path, [2.0] * 24, text=YARD.replace("weather: {sea: {series: sea.csv}%s}", "weather: none #%s"))
    assert starts(of)[0] == [0]


@pytest.mark.parametrize("seed", range(10))
def test_steps_in_random_seas_begin_in_the_weather_windows_found_by_stepping_hour_by_hour(tmp_path, seed):
    draw = random.Random(seed)
    heights, now = [], 1.0
    for _ in range(24 * 60):
        now = max(0.1, now + draw.gauss(0.0, 0.15) - 0.05 * (now - 0.9))
        heights.append(round(now, 3))
    takes = [draw.randint(3, 20) for _ in range(4)]
    rows = "".join(f"{b},{a},{t} h\n" for b, a, t in zip("ABCD", ["", *"ABC"], takes, strict=True))
    found, _ = starts(yard(tmp_path, heights, blocks=f"block,after,lift\n{rows}"))
    hour, want = 0, []
    for t in takes:
        limit = 0.93 if t <= 12 else 0.89
        hour = next(n for n in range(hour, 9999) if all(x <= limit for x in heights[n : n + t]))
        want.append(hour)
        hour += t
    assert found == want


def test_wind_and_waves_of_a_replication_come_from_the_same_year_of_data():
    years, found = tuple(float(n // 8760) for n in range(3 * 8760)), []
    for seed in range(1, 12):
        first = []
        for name in ("weather", "sea"):
            model = Weather(name, HourlySeries(date(2027, 1, 4), years, (0, 8760, 2 * 8760)), (0.5, 1.5, 2.5), seed)
            Simulator(model).start()
            first.append(model.at(0))
        assert first[0] == first[1]
        found.append(first[0])
    assert {*found} == {0.0, 1.0, 2.0}


@pytest.mark.parametrize(("last", "common"), [(2003, [2, 3]), (2002, [2])])
def test_weather_series_of_different_lengths_draw_from_their_common_years(tmp_path, last, common):
    """Wind of 2001 to 2003, sea from 2002 on, each hour with the last digit of its year."""
    for name, first, end in (("wind [m/s]", 2001, 2003), ("Hs [m]", 2002, last)):
        begin = datetime(first, 1, 1)
        times = (begin + timedelta(hours=n) for n in range((datetime(end + 1, 1, 1) - begin).days * 24))
        rows = (f"{t:%Y-%m-%d %H:%M},{t.year % 10}" for t in times)
        (tmp_path / f"{first}.csv").write_text("\n".join([f"time,{name}", *rows]) + "\n")
    text = YARD.replace("{sea: {series: sea.csv}", "{wind: {series: 2001.csv}, sea: {series: 2002.csv}")
    of = yard(tmp_path, [0.5] * 24, text=text).weather
    assert [[x.series[n] for n in x.begins] for x in (of.wind, of.sea)] == [common] * 2


def test_weather_series_without_a_common_year_are_refused(tmp_path):
    rows = [f"{datetime(2001, 1, 1) + timedelta(hours=n):%Y-%m-%d %H:%M},1" for n in range(8760)]
    (tmp_path / "wind.csv").write_text("\n".join(["time,wind [m/s]", *rows]) + "\n")
    with pytest.raises(SceneError, match="wind and sea have no year in common"):
        yard(tmp_path, [0.5] * 8760, text=YARD.replace("{sea:", "{wind: {series: wind.csv}, sea:"))


def test_one_weather_table_can_supply_both_the_wind_and_the_sea_of_a_yard(tmp_path):
    text = YARD.replace("sea: {", "wind: {series: sea.csv}, sea: {")
    of = yard(tmp_path, [f"{n},0.5" for n in range(24)], column="wind [m/s],Hs [m]", text=text).weather
    assert (of.wind.series, of.sea.series) == (tuple(map(float, range(24))), (0.5,) * 24)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"more": ", alpha: {12 h: 1.2}"}, "an alpha factor is above 0 and at most 1"),
        ({"more": ", alpha: 0.5"}, "write a factor for each length of window"),
        ({"more": ", alpha: [0.5]"}, "write a factor for each length of window"),
        ({"more": ", alpha: {12 h: 0.8, 24 h: 0.9}"}, "the factor of a longer window is not above"),
        ({"text": YARD.replace("sea: {series: sea.csv}", "forecast: 2 h")}, "alpha factors are of the sea"),
        ({"text": YARD.replace("weather: {sea: {series: sea.csv}%s}", "#%s")}, "the yard has no sea for it"),
        ({"text": YARD.replace("Hs: 1 m", "Hs: 0 m")}, "write a height above 0"),
        ({"text": YARD.replace("Hs: 1 m", "Hs: -1 m")}, "write a height above 0"),
        ({"more": ", alpha: {noon: 0.9}"}, "noon"),
        ({"column": "height [m]"}, "the columns are time, Hs"),
        ({"column": "Hs [s]"}, "sea.csv:2:"),
        ({"heights": [0.5] * 10}, "a series has the sea of a day at least"),
        ({"text": YARD.replace("Hs: 1 m", "Hz: 1 m")}, "this key is not known here"),
    ],
)
def test_invalid_sea_data_of_a_yard_are_reported_in_one_sentence(tmp_path, change, words):
    with pytest.raises(SceneError, match=words):
        yard(tmp_path, **{"heights": HEIGHTS, **change})


def test_a_step_for_which_no_weather_window_is_long_enough_is_reported_by_name(tmp_path):
    with pytest.raises(HeavyliftError, match="A lift waits forever for weather: in ten years"):
        starts(yard(tmp_path, [0.5] * 11 + [2.0] * 13))
