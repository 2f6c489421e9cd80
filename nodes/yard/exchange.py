"""Export of schedules: CSV, Microsoft Project XML (MSPDI), iCalendar (RFC 5545), Gantt charts.

In XML a block is a summary task, and its steps are the tasks in it; predecessors are links of type 1, finish to start.
"""

import csv
import io
from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as Xml

from heavylift.kernel.errors import SceneError, extra
from heavylift.recordings.sheets.sheet import COLOURS, INK, LIMIT, PAPER, QUIET, in_page, styled
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .fields import at
from .network import Yard

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SPACE = "http://schemas.microsoft.com/project"
FORMATS = (".csv", ".xml", ".ics", ".svg", ".png")
HEADS = ("block", "step", "start", "end", "critical")
Spans = Sequence[tuple[float, float, bool]]  # start and end [s], critical
LABELLED = 60  # blocks whose names are legible in a chart


def exported(yard: Yard, spans: Spans, out: str | Path, force: bool = False) -> Path:
    """Write a yard's schedule to the file `out`, in the format of its suffix; raises RecordingError if impossible."""
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
            minutes = round((end - start) / 60)
            _fill(
                Xml.SubElement(tasks, "Task"), UID=str(identity), ID=str(identity),
                Name=block if n < 0 else yard.activities[n].step, Manual="1", OutlineLevel="1" if n < 0 else "2",
                Start=_iso(yard, start), Finish=_iso(yard, end), Summary="1" if n < 0 else "0",
                Duration=f"PT{minutes // 60}H{minutes % 60}M0S",
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


def _iso(yard: Yard, t: float) -> str:
    return f"{at(yard.start, t):%Y-%m-%dT%H:%M:%S}"


def _fill(element: Xml.Element, **texts: str) -> None:
    for key, text in texts.items():
        Xml.SubElement(element, key).text = text


def figure(yard: Yard, spans: Spans) -> "Figure":
    """Return a Gantt chart of the start and end [s] of all activities, with the critical ones outlined."""
    from matplotlib import dates
    from matplotlib.figure import Figure

    drawing: Any = dates  # without types

    last = dict[str, float]()
    for one, (_, end, _) in zip(yard.activities, spans, strict=True):
        last[one.block] = max(end, last.get(one.block, end))
    blocks = sorted(last, key=lambda block: last[block])
    place, steps = {block: n for n, block in enumerate(blocks)}, [*dict.fromkeys(x.step for x in yard.activities)]
    with styled("none"):
        made = Figure(figsize=(11.0, min(2.0 + 0.16 * len(blocks), 12.0)), facecolor=PAPER, layout="constrained")
        axes = made.subplots()
        for k, step in enumerate(steps):
            own = [n for n, one in enumerate(yard.activities) if one.step == step]
            days = [[float(drawing.date2num(at(yard.start, t))) for t in spans[n][:2]] for n in own]
            axes.barh(
                [place[yard.activities[n].block] for n in own], [max(b - a, 1 / 48) for a, b in days],
                left=[a for a, _ in days], height=0.8, color=COLOURS[k % len(COLOURS)], label=step,
                edgecolor=[LIMIT if spans[n][2] else "none" for n in own], linewidth=0.8,
            )  # fmt: skip
        for key, day in yard.contract.items():
            when = drawing.date2num(day + timedelta(1))
            axes.axvline(when, color=LIMIT, lw=0.8, ls="--")
            axes.text(
                when, 0.02, key, transform=axes.get_xaxis_transform(), color=LIMIT, fontsize=8, rotation=90, ha="right"
            )
        axes.set_ylim(len(blocks) - 0.5, -0.5)
        few = len(blocks) <= LABELLED
        axes.set_yticks(range(len(blocks)) if few else [], blocks if few else [])
        locator = drawing.AutoDateLocator()
        axes.xaxis.set_major_locator(locator)
        axes.xaxis.set_major_formatter(drawing.ConciseDateFormatter(locator))
        axes.grid(axis="x", color=QUIET, lw=0.4, alpha=0.3)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
        axes.yaxis.label.set_color(INK)
        axes.legend(loc="upper right", fontsize=8, frameon=False)
    return made


def gantt(yard: Yard, spans: Spans) -> str:
    """Return the Gantt chart as an <svg> element for an HTML page."""
    return in_page(figure(yard, spans))
