"""Import of an existing schedule as the plan that a yard follows: CSV, or Microsoft Project XML (MSPDI)."""

from datetime import date, datetime
from functools import partial
from pathlib import Path
from xml.etree import ElementTree as Xml

from heavylift.kernel.errors import SceneError
from heavylift.nodes.scene.text.files import within
from heavylift.nodes.scene.text.source import Mark
from heavylift.nodes.scene.text.table_files import TableCell

from .exchange import SPACE
from .fields import Taking
from .network import Activity

Planned = dict[tuple[str, str], tuple[datetime, datetime]]  # start and end by block and step
MOST_BYTES = 1 << 26


def planned(given: Taking, start: date, activities: tuple[Activity, ...]) -> tuple[int, ...]:
    """Return the start of each activity [ns] in an existing schedule."""
    file = given.source.at(("plan",))
    if file is None or not activities:
        return ()
    found, marks, own = Planned(), dict[tuple[str, str], Mark](), given.source.root
    root = own if (own / str(file)).exists() else Path.cwd()  # of a bundled yard
    if str(file).lower().endswith(".xml"):
        find = partial(planned_in_project, name=str(file))
        found = given.take(("plan",), lambda x: find(within(root, root / str(x))), found)
    else:
        head, rows = given.table(("plan",), root)
        for row in rows:
            cells = dict(zip((column.key for column in head), row, strict=True))
            if lacking := [key for key in ("block", "step", "start", "end") if key not in cells]:
                given.source.fault(("plan",), f"a schedule has no column '{lacking[0]}'", mark=head[0].mark)
                return ()
            key = cells["block"].text, cells["step"].text
            marks[key] = row[0].mark
            if ends := given.take(("plan",), lambda _: planned_in_table(cells), None, row[0].mark):  # noqa: B023
                found[key] = ends
    number = {(one.block, one.step): n for n, one in enumerate(activities)}
    starts, zero = [-1] * len(activities), datetime(start.year, start.month, start.day)
    for key, (begin, _) in found.items():
        if key not in number:
            text = f"the schedule has a step '{key[1]}' of block '{key[0]}', which the yard has not"
            given.source.fault(("plan",), text, mark=marks.get(key))
        elif begin < zero:
            given.source.fault(("plan",), f"'{key[0]}' is planned before the yard's start", mark=marks.get(key))
        else:
            starts[number[key]] = round((begin - zero).total_seconds()) * 10**9
    return tuple(starts)


def planned_in_project(path: Path, name: str) -> Planned:
    """Return the start and end of all tasks without subtasks in an MSPDI file; raises SceneError for a bad file."""
    try:
        data = path.read_bytes()
        if len(data) > MOST_BYTES or b"<!DOCTYPE" in data or b"<!ENTITY" in data:
            raise SceneError(f"{name}: the file is too large, or defines XML entities, which are not allowed")
        tasks = Xml.fromstring(data).findall(f"{{{SPACE}}}Tasks/{{{SPACE}}}Task")
    except OSError as error:
        raise SceneError(f"the schedule '{name}' cannot be read: {error.strerror}") from None
    except Xml.ParseError as error:
        raise SceneError(
            f"{name}:{error.position[0]}:{error.position[1] + 1}: this is not valid XML: {error}"
        ) from None
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
        raise SceneError(
            f"{name}: the project has no tasks below a summary task; make each block a summary task, with its "
            "steps below it"
        )
    return found


def planned_in_table(cells: dict[str, TableCell]) -> tuple[datetime, datetime]:
    """Return the start and end in a row of a schedule; raises ValueError if they are invalid."""
    try:
        start, end = (datetime.fromisoformat(cells[key].text).replace(tzinfo=None) for key in ("start", "end"))
    except ValueError as error:
        raise ValueError(f"{error}: write times as 2027-01-31 13:00") from None
    if end < start:
        raise ValueError("this step ends before it starts; correct its times")
    return start, end


def _moment(text: str, where: str) -> datetime:
    try:
        return datetime.fromisoformat(text).replace(tzinfo=None)
    except ValueError:
        raise SceneError(f"{where}: '{text}' is not a valid time; export the schedule with start and finish") from None
