"""Export and import of schedules for other programs."""

import csv
import io
import re
from datetime import datetime, timedelta
from pathlib import Path
from xml.etree import ElementTree as Xml

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.yard import SPACE, calendar_of, expected, exported, load, project_of, table_of
from test_schedules_agree_with_theory import random_yard

HERE = Path(__file__).parent
SPANS_OF = ("starts", "ends", "critical")


def scheduled(yard):
    schedule = expected(yard)
    return [(a, b, bool(c)) for a, b, c in zip(*(getattr(schedule, key) for key in SPANS_OF), strict=True)]


@pytest.mark.parametrize("form", [".csv", ".xml"])
@pytest.mark.parametrize("seed", range(3))
def test_an_exported_schedule_is_read_again_as_the_same_plan(tmp_path, form, seed):
    yard = random_yard(tmp_path, seed)
    spans = scheduled(yard)
    path = exported(yard, spans, tmp_path / f"plan{form}")
    again = load(tmp_path / "yard.yaml", [f"plan={path.name}"])
    assert [t / 1e9 for t in again.plan] == [a for a, _, _ in spans]
    assert [span[:2] for span in scheduled(again)] == [span[:2] for span in spans], "what is critical is not exported"


def test_activities_of_an_imported_plan_begin_at_their_planned_times(tmp_path):
    yard = random_yard(tmp_path, 1)
    later = [(a + 7200.0, b + 7200.0, c) for a, b, c in scheduled(yard)]
    exported(yard, later, tmp_path / "plan.csv")
    assert [a for a, _, _ in scheduled(load(tmp_path / "yard.yaml", ["plan=plan.csv"]))] == [a for a, _, _ in later]


def test_exported_schedule_xml_contains_the_links_and_resources_of_the_network(tmp_path):
    yard = random_yard(tmp_path, 2)
    root = Xml.fromstring(project_of(yard, scheduled(yard)))
    names = {x.findtext(f"{{{SPACE}}}UID"): x for x in root.iter(f"{{{SPACE}}}Task")}
    for task in names.values():
        begin, end = (datetime.fromisoformat(task.findtext(f"{{{SPACE}}}{key}")) for key in ("Start", "Finish"))
        hours, minutes = re.fullmatch(r"PT(\d+)H(\d+)M0S", task.findtext(f"{{{SPACE}}}Duration")).groups()
        assert end - begin == timedelta(hours=int(hours), minutes=int(minutes))
    links = [x for x in root.iter(f"{{{SPACE}}}PredecessorLink")]
    assert len(links) == sum(len(one.after) for one in yard.activities)
    assert {x.findtext(f"{{{SPACE}}}PredecessorUID") for x in links} <= set(names)
    assert sum(1 for _ in root.iter(f"{{{SPACE}}}Assignment")) == sum(len(one.needs) for one in yard.activities)


def test_an_exported_calendar_has_an_event_for_each_activity(tmp_path):
    icalendar = pytest.importorskip("icalendar")
    yard = random_yard(tmp_path, 0)
    spans = scheduled(yard)
    events = icalendar.Calendar.from_ical(calendar_of(yard, spans)).walk("VEVENT")
    rows = [*csv.DictReader(io.StringIO(table_of(yard, spans)))]
    assert [str(x["summary"]) for x in events] == [f"{row['block']} {row['step']}" for row in rows]
    assert [f"{x['dtstart'].dt:%Y-%m-%d %H:%M}" for x in events] == [row["start"] for row in rows]
    for event, row in zip(events, rows, strict=True):  # an event takes a minute at least
        assert f"{event['dtend'].dt:%Y-%m-%d %H:%M}" == row["end"] or row["end"] == row["start"]


def test_the_gantt_chart_has_a_bar_for_each_activity(tmp_path):
    from heavylift.nodes.yard import figure

    yard = random_yard(tmp_path, 0)
    (axes,) = figure(yard, scheduled(yard)).axes
    assert len(axes.patches) == len(yard.activities)
    assert b"<svg" in exported(yard, scheduled(yard), tmp_path / "gantt.svg").read_bytes()


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("p.csv", "block,step,start,end\nB1,work,soon,later\n", r"p.csv:2:1: error: .*write times as"),
        ("p.csv", "block,step,start,end\nB99,work,2027-02-01,2027-02-02\n", r"p.csv:2:1: error: .*'B99'"),
        ("p.csv", "block,step,start\nB1,work,2027-02-01\n", r"p.csv:1:1: error: .*no column 'end'"),
        (
            "p.csv",
            "block,step,start,end\nB1,work,2026-02-01,2026-02-02\n",
            r"p.csv:2:1: error: .*before the yard's start",
        ),
        ("p.xml", "<Project>", r"error: .*p.xml:1:\d+: this is not valid XML"),
        ("p.xml", f'<Project xmlns="{SPACE}"/>', r"error: .*no tasks below a summary task"),
        ("p.xml", '<!DOCTYPE x [<!ENTITY a "b">]><x/>', r"error: .*defines XML entities"),
        ("q.csv", "", r"error: .*there is no table 'p.csv'"),
    ],
)
def test_invalid_schedule_files_of_a_yard_are_reported_with_file_and_row(tmp_path, monkeypatch, name, text, message):
    monkeypatch.chdir(tmp_path)
    random_yard(tmp_path, 0)
    (tmp_path / name).write_text(text)
    with pytest.raises(SceneError, match=message):
        load(tmp_path / "yard.yaml", [f"plan={name.replace('q', 'p')}"])
