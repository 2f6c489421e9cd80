"""Yard files: working time, fields, faults, and results of a yard run."""

import random
import re
from contextlib import suppress
from datetime import date, datetime, timedelta
from pathlib import Path

import pytest
from heavylift.coordinator.yards import run_yard, yard
from heavylift.kernel import HeavyliftError, SceneError
from heavylift.nodes.yard import Calendar, contract_states, duration, examined, load, public_holidays, working
from scipy.stats import binomtest

PAGE = Path(__file__).parents[3] / "nodes/yard/YARD.md"
START = date(2027, 1, 4)  # a Monday
HOUR = 3600 * 10**9
DAY_SHIFT, NIGHT = (480, 1020), (1200, 1740)  # 08:00 to 17:00, 20:00 to 05:00


@pytest.fixture
def folder(tmp_path):
    parts = PAGE.read_text().split("```")
    for part in parts:
        for kind, name in (("yaml\n", "yard.yaml"), ("csv\n", "blocks.csv")):
            if part.startswith(kind):
                (tmp_path / name).write_text(part.removeprefix(kind))
    return tmp_path


def changed(folder, name, old, new):
    path = folder / name
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_the_night_shift_of_friday_ends_on_saturday():
    calendar = working(START, (0, 1, 2, 3, 4), (NIGHT,), ())
    friday = 4 * 24 * HOUR
    assert calendar.open(friday + 12 * HOUR) == friday + 20 * HOUR
    assert calendar.add(friday + 20 * HOUR, 9 * HOUR) == friday + 29 * HOUR
    assert calendar.add(friday + 20 * HOUR, 10 * HOUR) == 7 * 24 * HOUR + 21 * HOUR


def test_the_end_of_work_by_a_calendar_equals_that_found_by_stepping_hour_by_hour():
    draw = random.Random(3)
    off = {START + timedelta(n) for n in (3, 4, 16)}
    calendar = working(START, (0, 1, 2, 3, 4, 5), (DAY_SHIFT, NIGHT), sorted(off))

    def works(hour):
        when = datetime(2027, 1, 4) + timedelta(hours=hour)
        early = when - timedelta(days=1)
        today, before = (x.weekday() < 6 and x.date() not in off for x in (when, early))
        return (today and (8 <= when.hour < 17 or when.hour >= 20)) or (hour >= 24 and before and when.hour < 5)

    for _ in range(50):
        t, work = draw.randrange(500), draw.randrange(1, 200)
        start = next(h for h in range(t, 2000) if works(h))
        assert calendar.open(t * HOUR) == start * HOUR
        hours = [h for h in range(start, 3000) if works(h)][:work]
        end = calendar.add(start * HOUR, work * HOUR)
        assert end == (hours[-1] + 1) * HOUR
        assert calendar.back(end, work * HOUR) == start * HOUR


def test_a_yard_without_a_calendar_works_at_all_times():
    calendar = Calendar()
    assert (calendar.open(5), calendar.add(5, 3), calendar.back(8, 3)) == (5, 8, 5)


def test_public_holidays_in_a_yard_calendar_are_those_of_its_country():
    pytest.importorskip("holidays")
    assert date(2027, 3, 1) in public_holidays("KR", START)
    with pytest.raises(ValueError, match="no holidays of 'Atlantis' are known"):
        public_holidays("Atlantis", START)


@pytest.mark.parametrize(
    ("text", "mean_h"),
    [
        *[("6 h", 6), ("fixed 90 min", 1.5), ("uniform 4 h 6 h", 5), ("triangular 4 h 6 h 11 h", 7)],
        *[("pert 4 h 6 h 14 h", 7), ("lognormal mean 30 h sd 10 h", 30), ("erlang 3 phases mean 6 h", 6)],
        *[("table 4 h 5 h 9 h", 6), ("exponential 2 days", 48)],
    ],
)
def test_durations_of_yard_files_are_read(text, mean_h):
    assert duration(text).mean == pytest.approx(mean_h * 3600)


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("blocks.csv", "K1,,,410,", "K1,D1,,410,", r"blocks.csv:2:4: error: .*circle: "),
        ("blocks.csv", "K2,K1,", "K2,K9,", r"blocks.csv:3:4: error: .*there is no block 'K9'"),
        ("blocks.csv", "K2,K1,2027-01-06", "K2,K1,6.1.2027", r"blocks.csv:3:7: error: .*not a valid date"),
        ("blocks.csv", ",420,40", ",420,forty", r"blocks.csv:4:\d+: error: .*not a valid duration"),
        ("blocks.csv", "block,after", "block,affter", r"blocks.csv:1:7: error: .*no column 'affter'"),
        ("blocks.csv", "K2,K1", "K1,K1", r"blocks.csv:3:1: error: .*given twice"),
        ("yard.yaml", "needs: {fitters: 6}", "needs: {fitter: 6}", r"yard.yaml:13:\d+: error: .*no resource 'fitter'"),
        ("yard.yaml", "needs: {fitters: 6}", "needs: {fitters: 60}", r"needs 60 of 'fitters', which has 12"),
        ("yard.yaml", "fitters: 12", "fitters: -1", r"'-1' is not a valid number of units"),
        ("yard.yaml", "until: {goliath: fit-up}", "until: {goliath: lift}", r"there is no step 'lift'"),
        ("yard.yaml", "after: erect", "after: weld", r"circle: "),
        ("yard.yaml", "works: day", "works: dawn", r"there is no shift 'dawn'"),
        ("yard.yaml", "days: mon-fri", "days: someday", r"yard.yaml:5:\d+: error: .*not a day of the week"),
        ("yard.yaml", "08:00-12:00", "8-12", r"'8-12' is not a valid shift"),
        ("yard.yaml", "2027-01-20..2027-01-21", "2027-01-20..2057-01-21", r"the calendar has no working time"),
        ("yard.yaml", "minimum slack", "minimal slack", r"there is no rule 'minimal slack'"),
        ("yard.yaml", "B2: 2027", "B7: 2027", r"there is no block 'B7'"),
        ("yard.yaml", "from: blocks.csv", "from: other.csv", r"there is no table 'other.csv'"),
        ("yard.yaml", "rule:", "rules:", r"yard.yaml:15:1: error: .*not known here"),
        ("yard.yaml", "triangular 4 h 6 h 9 h", "triangular 4 h 6 h", r"write it as 'triangular 4 h 6 h 12 h'"),
        ("yard.yaml", "triangular 4 h 6 h 9 h", "triangular 9 h 6 h 4 h", r"not in ascending order"),
    ],
)
def test_invalid_yard_files_are_reported_with_file_row_and_column(folder, file, old, new, message):
    changed(folder, file, old, new)
    if "2057" in new:
        changed(folder, file, "2027-01-20", "2026-12-01")
    with pytest.raises(SceneError, match=message) as found:
        load(folder / "yard.yaml")
    first = str(found.value).splitlines()[0]
    assert re.search(r"(yard\.yaml|blocks\.csv):\d+:\d+: error: \S.*\S$", first), "file, row and column, and a sentence"


@pytest.mark.parametrize("seed", range(40))
def test_corrupted_yard_files_end_with_a_one_sentence_error(folder, seed):
    draw, whole = random.Random(seed), {name: (folder / name).read_text() for name in ("yard.yaml", "blocks.csv")}
    for _ in range(5):
        name = draw.choice(sorted(whole))
        text, at = whole[name], draw.randrange(len(whole[name]))
        cut = draw.choice(["", ":", "-", "9", "x", "{", ",", '"', "\n", "+ 1e30 h", "null", "[]"])
        (folder / name).write_text(text[:at] + cut + text[at + draw.randrange(4) :])
        with suppress(HeavyliftError):
            assert examined(load(folder / "yard.yaml")).tables
        (folder / name).write_text(text)


def test_a_yard_whose_erection_places_never_become_free_is_reported_with_the_blocking_place(folder):
    changed(folder, "yard.yaml", "erection: [erect, fit-up]", "erection: [fit-up, weld]")
    changed(folder, "yard.yaml", "goliath: fit-up", "goliath: weld")
    changed(folder, "blocks.csv", "K1,,,", "K1,K2,,")
    changed(folder, "blocks.csv", "K2,K1,", "K2,,")
    with pytest.raises(Exception, match=r"K\d erect waits forever for goliath"):
        examined(load(folder / "yard.yaml"))


def test_settings_change_the_resources_and_the_dispatching_rule_of_a_yard(folder):
    assert load(folder / "yard.yaml", ["resources.goliath=2"]).capacities["goliath"] == 2
    assert load(folder / "yard.yaml", ["rule=LST"]).rule == "latest start"


def test_a_yard_run_has_equal_recordings_in_any_placement_on_processes(folder, monkeypatch):
    monkeypatch.chdir(folder)
    sheet, alone = run_yard("yard.yaml", output="a.mcap", in_process=True)
    assert sheet.state == "amber", "one run with expected durations is no proof"
    assert alone.recording == Path("a.mcap")
    assert run_yard("yard.yaml", processes=3)[1].digest == alone.digest


def test_replications_of_a_yard_give_quantiles_of_its_dates_and_probabilities_of_contract_dates(folder, monkeypatch):
    monkeypatch.chdir(folder)
    sheet, _ = run_yard("yard.yaml", replications=12, seed=3)
    (dates,) = [table for table in sheet.tables if table.title == "Key dates"]
    delivery = dates.rows[0]
    assert list(delivery[1:4]) == sorted(delivery[1:4])
    again, _ = run_yard("yard.yaml", replications=12, seed=3)
    assert again == sheet
    late, _ = run_yard("yard.yaml", ["contract.B2=2027-01-13"], replications=12, seed=3)
    assert late.state == "red"
    assert "B2" in late.lead


@pytest.mark.parametrize("runs", [20, 100, 700])
def test_a_contract_date_is_green_or_red_only_if_the_exact_confidence_interval_excludes_its_probability(folder, runs):
    """Peer: SciPy's exact confidence interval of a proportion."""
    found = load(folder / "yard.yaml", ["contract={delivery: 2027-02-12}"])
    for kept in range(0, runs + 1, max(1, runs // 50)):
        low, high = binomtest(kept, runs).proportion_ci(0.95, method="exact")
        wanted = "green" if low >= found.quantile else "red" if high <= found.quantile else "undecided"
        ends = [0.0] * kept + [1e9] * (runs - kept)
        assert contract_states(found, {"dispatcher.delivery": ends}) == {"delivery": wanted}, f"{kept} of {runs}"


def test_random_durations_of_yard_steps_do_not_depend_on_the_number_of_resources(folder):
    """Common random numbers: a block takes as long whatever the plan is."""
    one, two = (
        yard(str(folder / "yard.yaml"), [f"resources.welders={n}"], seed=5).children["step-weld"] for n in (8, 24)
    )
    for step in (one, two):
        step.start()
    assert one.times == two.times
