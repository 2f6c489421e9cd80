"""Tables in a scene's folder: data, lugs and vibration modes of blocks, and responses of vessels to waves.

    block: {from: blocks.csv#B17, lugs from: lugs.csv#B17, at: [40 m, 70 m, 4 m]}
    vessels: {barge: {responses from: barge.csv#loaded, ...}}

Likewise for each of `blocks`.

The column heads are keys with their units, such as `mass [t]`, `com x [m]`; a column without a unit is a remark, unless
it is an axis. The first column names the row; in a table of lugs it names the block, the second one the lug, and
without `#B17` the first one the lug. `modes from` likewise refers to a table of block, mode, place (lug or support),
its displacement x, y, z and in one row of each mode the frequency, mass and damping. Keys in the same file take
precedence over the row, and so do files and settings merged over it; the row takes precedence over the file that this
one extends. An empty cell is an error, unless a key of higher precedence replaces it; lugs and modes of a table replace
all those of the extended file.

For responses, and for `loads from` under `floating`, each column such as `surge [m/m]` has a column `surge phase
[deg]`; `period` and `heading` (relative to the bow) give the wave of a row. Between rows real and imaginary parts are
interpolated linearly; waves outside the rows are an error.
"""

from math import floor, pi, sqrt

from heavylift.kernel.algebra.elementary import atan2, cos, sin
from heavylift.kernel.errors import SceneError

from . import units
from .faults import closest, raise_faults
from .source import Data, Mark, Path, SourceText
from .table_files import AXES, Found, SceneTable, TableCell, lay, table

BLOCK = "block"
ROW, LUGS, MODES = "from", "lugs from", "modes from"
SLIDES, TURNS = ("surge", "sway", "heave"), ("roll", "pitch", "yaw")
DIMENSIONS = {"responses": (units.RESPONSE, units.TURN_RESPONSE), "loads": (units.STIFFNESS, units.MOMENT_RESPONSE)}
RADIUS, SET_UP, CHARTS = "radius", ("counterweight", "outriggers"), "charts from"
WAVE = {"period": units.TIME, "heading": units.ANGLE}
TURN = 2.0 * pi
SAME = 1e-9  # [s, rad] between waves that are the same


def tabled(source: SourceText) -> None:
    """Replace references to table files in blocks and vessels by the values in these tables.

    Raises SceneError with all errors of the scene so far if a table or row cannot be read."""
    for base in ((BLOCK,), *(("blocks", name) for name in _names(source.data.get("blocks")))):
        _tabled(source, base)
    for name in _names(source.data.get("vessels")):
        for base, key in ((("vessels", name), "responses"), (("vessels", name, "floating"), "loads")):
            given = source.at(base)
            if isinstance(given, dict) and f"{key} from" in given:
                _answers(source, base, given, key)


def _tabled(source: SourceText, base: Path) -> None:
    block = source.at(base)
    if not isinstance(block, dict):
        return
    for word in (ROW, LUGS, MODES):
        if word not in block:
            continue
        at = (*base, word)
        named, mark = block.pop(word), source.mark(at)
        try:
            if not isinstance(named, str):
                raise SceneError(f"write the table and the row, such as '{word}: blocks.csv#B17'")
            file, _, row = (part.strip() for part in named.partition("#"))
            read = table(source.root, file)
            if word == ROW:
                lay(source, base, block, _block(source, base, read, read.only(row), mark), mark)
            else:
                key, reader = ("lugs", _lugs) if word == LUGS else ("modes", _modes)
                into = block.setdefault(key, {})
                source.keys.setdefault((*base, key), source.keys.get(at, mark))
                if isinstance(into, dict):
                    for name in [x for x in into if not _wins(source, (*base, key, x), mark)]:
                        del into[name]
                    lay(source, (*base, key), into, reader(source, base, read, row), mark)
        except (SceneError, ValueError) as error:
            source.fault(at, str(error), mark=mark)
        raise_faults(source, source.faults)


def charted(source: SourceText) -> None:
    """Replace references to tables at hooks, such as `charts from: rt59.csv`, by the capacity charts in the files.

    The columns are `radius [m]`, optionally `counterweight [t]` and `outriggers [m]`, and one column of capacities for
    each boom length, such as `boom 24 m [t]`; a cell is empty if there is no capacity at its radius.
    """
    several = [(of, name) for of in ("types", "machines") for name in _names(source.data.get(of))]
    for base in (("mechanism", "hooks"), *((*path, "hooks") for path in several)):
        for hook in _names(source.at(base)):
            given, at = source.at((*base, hook)), (*base, hook, CHARTS)
            if not isinstance(given, dict) or CHARTS not in given:
                continue
            named, mark, key = given.pop(CHARTS), source.mark(at), source.keys.get(at)
            try:
                if not isinstance(named, str):
                    raise SceneError(f"write a table, such as '{CHARTS}: charts.csv'")
                given["capacity charts"], cells = _charts(table(source.root, named))
                source.keys[(*base, hook, "capacity charts")] = key or mark
                source.values |= {(*base, hook, "capacity charts", *below): x for below, x in cells.items()}
            except (SceneError, ValueError) as error:
                source.fault(at, str(error), mark=mark)


def _names(data: Data) -> list[str]:
    return list(data) if isinstance(data, dict) else []


def _charts(read: SceneTable) -> tuple[list[Data], dict[Path, Mark]]:
    """Return a chart for each boom length, counterweight and base, with the places of its cells."""
    file, head, rows = read
    places = {column.key: i for i, column in enumerate(head) if column.unit}
    booms = [i for i, column in enumerate(head) if column.key.startswith("boom ")]
    others = [c for c in head if c.unit and not c.key.startswith("boom ") and c.key not in (RADIUS, *SET_UP)]
    if RADIUS not in places or not booms or others:
        message = (
            f"cannot have '{others[0].key}'" if others else f"needs '{RADIUS} [m]' and columns such as 'boom 24 m [t]'"
        )
        raise SceneError(f"{file}:{rows[0][0].mark.line - 1 if rows else 1}: the header of a chart {message}")
    found: dict[tuple[str, ...], dict[str, Data]] = {}
    marks: dict[Path, Mark] = {}
    for row in rows:
        for i in (i for i in booms if row[i].text):
            own = {key: read.text(row, places[key]) for key in SET_UP if key in places}
            key = (head[i].key, *own.values())
            made = found.setdefault(key, {"boom": head[i].key.removeprefix("boom "), **own, "chart": []})
            number, chart = list(found).index(key), made["chart"]
            assert isinstance(chart, list)
            at, radius = (number, "chart", len(chart)), row[places[RADIUS]].mark
            marks |= {(number,): row[i].mark, (number, "boom"): head[i].mark, (number, "chart"): row[i].mark}
            marks |= {(number, name): row[places[name]].mark for name in own}
            marks |= {at: radius, (*at, 0): radius, (*at, 1): row[i].mark}
            chart.append([read.text(row, places[RADIUS]), read.text(row, i)])
    return list(found.values()), marks


def _wins(source: SourceText, path: Path, named: Mark) -> bool:
    """Return whether a value written in the scene takes precedence over a table; `named`: place of the table's name."""
    return source.layer(source.mark(path, on_key=True)) >= source.layer(named)


def _block(source: SourceText, base: Path, read: SceneTable, row: list[TableCell], named: Mark) -> Found:
    """Return the keys of a block that a row of a table gives."""
    found: Found = {}
    for i, (column, cell) in enumerate(zip(read.head, row, strict=True)):
        path = (*base, column.key)
        if not i or not (column.unit or column.axis) or (source.at(path) is not None and _wins(source, path, named)):
            continue
        if not cell.text:
            message = f"the row '{row[0].text}' is empty in column '{f'{column.key} {column.axis}'.strip()}'"
            source.fault(path, message, "write its value, or remove the column", mark=cell.mark)
            continue
        text = read.text(row, i)
        known = found.get(column.key)
        taken = known[0][AXES.index(column.axis)] if known and column.axis and isinstance(known[0], list) else known
        if taken is not None:
            source.fault((*base, column.key), f"the row gives '{column.key}' twice", mark=column.mark)
        elif not column.axis:
            found[column.key] = (text, column.mark, {(): cell.mark})
        else:
            value, mark, cells = found.setdefault(column.key, ([None] * 3, column.mark, {(): cell.mark}))
            assert isinstance(value, list)
            value[AXES.index(column.axis)] = text
            cells[(AXES.index(column.axis),)] = cell.mark
    for key, (value, mark, _) in found.items():
        if isinstance(value, list) and None in value and not source.faults:
            lacking = ", ".join(f"'{key} {x}'" for x, y in zip(AXES, value, strict=True) if y is None)
            source.fault((*base, key), f"the row has no {lacking}", mark=mark)
    return found


def _lugs(source: SourceText, base: Path, read: SceneTable, block: str) -> Found:
    """Return the lugs of a block in a table, by name."""
    if others := [c.key for c in read.head if c.unit and (c.axis or c.key) not in AXES]:
        raise SceneError(
            f"{read.file}: a lug has only the quantities x, y and z, not '{others[0]}'; write remarks in "
            "columns without a unit"
        )
    chosen, places = _chosen(read, block, " [m]")
    found: Found = {}
    for row in chosen:
        name = row[1 if block else 0]
        if name.text in found:
            source.fault((*base, "lugs", name.text), f"the lug '{name.text}' is given twice", mark=name.mark)
        value: list[Data] = [read.text(row, place) for place in places]
        marks: dict[Path, Mark] = {(): name.mark, **{(i,): row[place].mark for i, place in enumerate(places)}}
        found[name.text] = (value, name.mark, marks)
    return found


def _modes(source: SourceText, base: Path, read: SceneTable, block: str) -> Found:
    """Return the modes of a block in a table, by name; each displaced place has its own row."""
    chosen, places = _chosen(read, block, "")
    first, head = 1 if block else 0, read.head
    numbers = [i for i, column in enumerate(head) if i > first + 1 and i not in places and column.unit]
    found: Found = {}
    for row in chosen:
        name, place = row[first], row[first + 1]
        value, _, marks = found.setdefault(name.text, ({"shape": {}}, name.mark, {(): name.mark}))
        assert isinstance(value, dict)
        shape = value["shape"]
        assert isinstance(shape, dict)
        if place.text in shape:
            source.fault((*base, "modes", name.text), f"the place '{place.text}' is given twice", mark=place.mark)
        shape[place.text] = [row[x].text for x in places]
        marks |= {("shape", place.text, i): row[x].mark for i, x in enumerate(places)}
        for i in (i for i in numbers if row[i].text):
            text = read.text(row, i)
            if value.setdefault(head[i].key, text) != text:
                message = f"a mode has one {head[i].key}, and '{name.text}' has {value[head[i].key]}, too"
                source.fault((*base, "modes", name.text), message, mark=row[i].mark)
            marks[head[i].key,] = row[i].mark
    return found


def _chosen(read: SceneTable, block: str, unit: str) -> tuple[list[list[TableCell]], list[int]]:
    """Return the rows of a block, and the indices of the columns x, y and z."""
    chosen = read.named(block) if block or not read.rows else read.rows
    places = {column.axis or column.key: i for i, column in enumerate(read.head)}
    if lacking := [x for x in AXES if x not in places]:
        raise SceneError(f"{read.file} has no column {', '.join(f'{x}{unit}' for x in lacking)}")
    return chosen, [places[x] for x in AXES]


Answer = tuple[dict[str, float], list[float], list[TableCell]]  # of a row: its wave, parts of all motions, its cells


def _answers(source: SourceText, base: Path, given: dict[str, Data], key: str) -> None:
    """Insert the responses of a vessel to the scene's wave, from its table."""
    word = f"{key} from"
    named, mark = given.pop(word), source.mark((*base, word))
    into = given.setdefault(key, {})
    source.keys.setdefault((*base, key), source.keys.get((*base, word), mark))
    try:
        file, _, name = (part.strip() for part in str(named).partition("#"))
        read = table(source.root, file)
        kinds = dict(zip((*SLIDES, *TURNS), (x for x in DIMENSIONS[key] for _ in SLIDES), strict=True))
        heads = {column.key: i for i, column in enumerate(read.head)}
        known = {**kinds, **WAVE, **{f"{x} phase": units.ANGLE for x in kinds}}
        if others := [c.key for c in read.head if c.unit and c.key not in known]:
            raise SceneError(
                f"{file}: unknown column '{others[0]}' in the {key} of a vessel: {closest(others[0], known)}"
            )
        moved = [x for x in kinds if x in heads]
        if lacking := [f"{x} phase" for x in moved if f"{x} phase" not in heads]:
            raise SceneError(f"{file} has no column '{lacking[0]} [deg]'; add the phases of this motion")

        def number(row: list[TableCell], what: str) -> float:
            try:
                return known[what].read(read.text(row, heads[what]))
            except ValueError as error:
                source.fault((*base, key, what), str(error), mark=row[heads[what]].mark)
                return 0.0

        waves = [x for x in WAVE if x in heads]
        answers: list[Answer] = []
        for row in read.named(name) if name or not read.rows else read.rows:
            polar = [(number(row, x), number(row, f"{x} phase")) for x in moved]
            parts = [r * float(of(angle)) for r, angle in polar for of in (cos, sin)]
            answers.append(({x: number(row, x) for x in waves}, parts, row))
        values, cells = _between(answers, waves, _met(source, base[:2]), file)
    except (SceneError, ValueError) as error:
        if not source.faults:
            source.fault((*base, word), str(error), mark=mark)
    raise_faults(source, source.faults)
    found: Found = {}
    for i, x in enumerate(moved):
        a, b = values[2 * i : 2 * i + 2]
        unit = next(name for name, factor in kinds[x].units.items() if factor == 1)
        value: list[Data] = [f"{sqrt(a * a + b * b)!r} {unit}", f"{float(atan2(b, a)) if a or b else 0.0!r} rad"]
        marks = [cells[heads[x]].mark, cells[heads[f"{x} phase"]].mark]
        found[x] = (value, read.head[heads[x]].mark, {(): marks[0], (0,): marks[0], (1,): marks[1]})
    if isinstance(into, dict):
        lay(source, (*base, key), into, found, mark)


def _met(source: SourceText, vessel: Path) -> dict[str, float]:
    """Return the wave as a vessel meets it: period [s], heading relative to the bow [rad]; empty in still water."""
    waves, own = source.data.get("waves"), source.at(vessel)
    if not isinstance(waves, dict) or not isinstance(own, dict):
        return {}
    angles = [units.ANGLE.read(x.get("heading", 0.0)) for x in (waves, own)]
    return {"period": units.TIME.read(waves.get("period")), "heading": angles[0] - angles[1]}


def _between(
    rows: list[Answer], axes: list[str], met: dict[str, float], file: str
) -> tuple[list[float], list[TableCell]]:
    """Return the responses interpolated between rows, and the cells of a neighbouring row."""
    if not axes:
        if len(rows) > 1:
            raise SceneError(
                f"{file} has several rows for the same wave, such as line {rows[1][2][0].mark.line}; keep one"
            )
        return rows[0][1], rows[0][2]
    axis, rest = axes[0], axes[1:]
    known = sorted({wave[axis] for wave, _, _ in rows})
    x = met.get(axis, known[0])
    if axis == "heading":
        x -= TURN * floor((x - known[0] + SAME) / TURN)
    low, high = max((k for k in known if k <= x + SAME), default=x), min((k for k in known if k >= x - SAME), default=x)
    if low not in known or high not in known:
        ends = " to ".join(WAVE[axis].show(k) for k in (known[0], known[-1]))
        message = f"{file} covers waves with {'a' if axis == 'period' else 'a relative'} {axis} of {ends}"
        raise SceneError(f"{message}, but the wave of the scene has {WAVE[axis].show(x)}")
    at_ends = (_between([row for row in rows if row[0][axis] == k], rest, met, file) for k in (low, high))
    (a, cells), (b, _) = at_ends
    part = (x - low) / (high - low) if high > low else 0.0
    return [p + part * (q - p) for p, q in zip(a, b, strict=True)], cells
