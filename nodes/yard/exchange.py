"""Export and import of schedules: CSV, Microsoft Project XML (MSPDI), iCalendar (RFC 5545), figures.

In XML a block is a summary task, and its steps are the tasks in it; predecessors are links of type 1, finish to start.
"""

import csv
import io
from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from xml.etree import ElementTree as Xml

from heavylift.kernel.errors import SceneError, extra
from heavylift.nodes.scene.text.table_files import TableCell
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .fields import at
from .gantt import figure
from .network import Yard

SPACE = "http://schemas.microsoft.com/project"
FORMATS = (".csv", ".xml", ".ics", ".svg", ".png")
HEADS = ("block", "step", "start", "end", "critical")
Spans = Sequence[tuple[float, float, bool]]  # start and end [s], critical
Planned = dict[tuple[str, str], tuple[datetime, datetime]]  # start and end by block and step
MOST_BYTES = 1 << 26


def exported(yard: Yard, spans: Spans, out: str | Path, force: bool = False) -> Path:
    """Write a schedule in the format that the suffix of `out` names; raises RecordingError if that is impossible."""
    path = output_path(out, "a schedule", FORMATS)
    forms: dict[str, Callable[[Yard, Spans], str | bytes]] = {".csv": table_of, ".xml": project_of, ".ics": calendar_of}
    make = forms.get(path.suffix.lower())
    content = make(yard, spans) if make else drawn(yard, spans, path.suffix.lower()[1:])
    return written(content, path, "a schedule", FORMATS, force)


def drawn(yard: Yard, spans: Spans, form: str) -> bytes:
    """Return the Gantt chart as a figure in the format `form`."""
    file = io.BytesIO()
    figure(yard, spans).savefig(file, format=form, dpi=110, metadata={"Date": None} if form == "svg" else None)
    return file.getvalue()


def table_of(yard: Yard, spans: Spans) -> str:
    """Return the schedule as CSV text with a row for each activity."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(HEADS)
    for one, (start, end, critical) in zip(yard.activities, spans, strict=True):
        when = (f"{at(yard.start, t):%Y-%m-%d %H:%M}" for t in (start, end))
        rows.writerow((one.block, one.step, *when, "yes" if critical else ""))
    return text.getvalue()


def project_of(yard: Yard, spans: Spans) -> bytes:
    """Return the schedule as an MSPDI project: tasks with their links and resources."""
    root = Xml.Element("Project", xmlns=SPACE)
    _fill(root, Name=yard.name, StartDate=_iso(yard, 0.0), ScheduleFromStart="1")
    tasks, number, identity = Xml.SubElement(root, "Tasks"), dict[int, int](), 0
    for block in dict.fromkeys(one.block for one in yard.activities):
        own = [n for n, one in enumerate(yard.activities) if one.block == block]
        ends = min(spans[n][0] for n in own), max(spans[n][1] for n in own)
        for n in (-1, *own):
            identity += 1
            number[n] = identity
            start, end = ends if n < 0 else spans[n][:2]
            _fill(
                Xml.SubElement(tasks, "Task"), UID=str(identity), ID=str(identity),
                Name=block if n < 0 else yard.activities[n].step, Manual="1", OutlineLevel="1" if n < 0 else "2",
                Start=_iso(yard, start), Finish=_iso(yard, end), Summary="1" if n < 0 else "0",
                Duration=f"PT{(end - start) / 3600:.0f}H0M0S",
            )  # fmt: skip
    found = {task.findtext("UID"): task for task in tasks}
    for n, one in enumerate(yard.activities):
        for m, lag in one.after:
            link = Xml.SubElement(found[str(number[n])], "PredecessorLink")
            _fill(link, PredecessorUID=str(number[m]), Type="1", LinkLag=str(round(lag / 6e9)))
    resources, assigned = Xml.SubElement(root, "Resources"), Xml.SubElement(root, "Assignments")
    for k, (name, units) in enumerate(yard.capacities.items(), 1):
        _fill(Xml.SubElement(resources, "Resource"), UID=str(k), ID=str(k), Name=name, MaxUnits=str(units))
    places = {name: str(k) for k, name in enumerate(yard.capacities, 1)}
    needs = [(n, need) for n, one in enumerate(yard.activities) for need in one.needs]
    for k, (n, need) in enumerate(needs, 1):
        given = {"UID": str(k), "TaskUID": str(number[n]), "ResourceUID": places[need.resource]}
        _fill(Xml.SubElement(assigned, "Assignment"), **given, Units=str(need.units))
    Xml.indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root) + b"\n"


def calendar_of(yard: Yard, spans: Spans) -> bytes:
    """Return the schedule as an iCalendar file with an event for each activity, in local time."""
    extra("icalendar", SceneError("a calendar needs icalendar: pip install 'heavylift[yard]'"))
    from icalendar import Calendar, Event

    made = Calendar()
    made.add("prodid", "-//heavylift//yard//EN")
    made.add("version", "2.0")
    for one, (start, end, critical) in zip(yard.activities, spans, strict=True):
        event = Event()
        event.add("uid", f"{one.block}-{one.step}@{yard.name}".replace(" ", "-"))
        event.add("dtstamp", datetime(yard.start.year, yard.start.month, yard.start.day))
        event.add("summary", one.name)
        event.add("dtstart", at(yard.start, start))
        event.add("dtend", at(yard.start, max(end, start + 60)))
        event.add("categories", [one.step, *(["critical"] if critical else [])])
        made.add_component(event)
    return bytes(made.to_ical())


def planned_in_project(path: Path, name: str) -> Planned:
    """Read the start and end of all tasks without subtasks in an MSPDI file; raises SceneError if it cannot be read."""
    try:
        data = path.read_bytes()
        if len(data) > MOST_BYTES or b"<!DOCTYPE" in data or b"<!ENTITY" in data:
            raise SceneError(f"{name}: is too large, or defines entities, which no project needs")
        tasks = Xml.fromstring(data).findall(f"{{{SPACE}}}Tasks/{{{SPACE}}}Task")
    except OSError as error:
        raise SceneError(f"the schedule '{name}' cannot be read: {error.strerror}") from None
    except Xml.ParseError as error:
        raise SceneError(f"{name}:{error.position[0]}:{error.position[1] + 1}: this is no XML: {error}") from None
    found, above = Planned(), dict[int, str]()
    for task in tasks:
        texts = {part.tag.rpartition("}")[2]: (part.text or "").strip() for part in task}
        level = int(texts.get("OutlineLevel") or 1) if (texts.get("OutlineLevel") or "1").isdigit() else 1
        above[level] = texts.get("Name", "")
        if level > 1 and texts.get("Summary") != "1":
            where = f"{name}: task {texts.get('UID', '')} '{above[level]}'"
            ends = _moment(texts.get("Start", ""), where), _moment(texts.get("Finish", ""), where)
            found[above.get(level - 1, ""), above[level]] = ends
    if not found:
        raise SceneError(f"{name}: has no tasks below a summary task; let each block be one, with its steps below it")
    return found


def planned_in_table(cells: dict[str, TableCell]) -> tuple[datetime, datetime]:
    """Read the start and end in a row of a schedule; raises ValueError if they are invalid."""
    try:
        start, end = (datetime.fromisoformat(cells[key].text).replace(tzinfo=None) for key in ("start", "end"))
    except ValueError as error:
        raise ValueError(f"{error}: write times as 2027-01-31 13:00") from None
    if end < start:
        raise ValueError("this ends before it starts")
    return start, end


def _moment(text: str, where: str) -> datetime:
    try:
        return datetime.fromisoformat(text).replace(tzinfo=None)
    except ValueError:
        raise SceneError(f"{where}: '{text}' is no time; export the schedule with start and finish") from None


def _iso(yard: Yard, t: float) -> str:
    return f"{at(yard.start, t):%Y-%m-%dT%H:%M:%S}"


def _fill(element: Xml.Element, **texts: str) -> None:
    for key, text in texts.items():
        Xml.SubElement(element, key).text = text
