"""Assignment of log columns to channels of a recording: `cell_H1: rope/tension/west.H1 [kN] +- 5 kN`.

A map is a YAML file of such lines, or each line an option `cell_H1=...`. The unit may be in the log's head instead. The
sensor's uncertainty after `+-`, in the channel's units or in %, is at a level of 95 %. `clock: time [s]` names the
log's times. A mass in place of a force is its weight. A channel `measured/NAME`, such as measured/wind, is not in the
run.

Drives of a run that follow a log: `west.H1.hoist=log.csv:hoist_speed [m/min] @ -36000 s`, by target and verb of the
action list; `@`: time of the run at the log's time 0. Speeds are followed in straight lines from row to row, positions
by a spline of two parabolas per row, whose speed at a row is the mean of those beside it.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import msgspec
import numpy as np
from heavylift.kernel.errors import RecordingError, SceneError
from heavylift.nodes.models import build
from heavylift.nodes.models.assembly import drives
from heavylift.nodes.models.parts.drive import DriveActor
from heavylift.nodes.plan.actions import Move
from heavylift.nodes.plan.plan import Driven
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.operator_command import spoken
from heavylift.nodes.scene.text.faults import closest, raise_faults
from heavylift.nodes.scene.text.files import content
from heavylift.nodes.scene.text.source import Fault, Mark, SourceText, read
from heavylift.nodes.scene.text.spelling import PLUS, tidy
from heavylift.nodes.scene.text.uncertainty import half_width
from heavylift.nodes.scene.text.units import DIMENSIONS, MASS, STROKE, STROKE_SPEED, TIME, offered
from heavylift.recordings import Recording
from heavylift.recordings.format.samples import ERROR, MEASURED
from heavylift.recordings.read.log import LogTable, read_log
from heavylift.recordings.read.signal import chosen, titles
from numpy.typing import NDArray

LINE = re.compile(rf"(?P<channel>[^\[±]+?)\s*(?:\[(?P<unit>[^\]]*)\])?\s*(?:(?:{PLUS})\s*(?P<half>.+))?")
EXAMPLE = "'rope/tension/west.H1 [kN] +- 5 kN'"
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LogChannel:
    """A measured channel: its signal in the recording, its values (n,), and the standard uncertainties (n,) of the
    sensor.

    `model`: whether the run also has this channel; `stated`: whether the map states the uncertainty.
    """

    signal: str
    column: str
    unit: str
    values: Floats
    sigma: Floats
    model: bool
    stated: bool

    @property
    def name(self) -> str:
        """The name of the channel as users write it, SIGNAL/COLUMN."""
        return f"{self.signal}/{self.column}"


@dataclass(frozen=True)
class LogSignals:
    """A measured log whose columns are assigned to signals: times (n,) [s] and channels."""

    log: LogTable
    t: Floats
    channels: list[LogChannel]
    lines: dict[str, str]

    @property
    def compared(self) -> list[LogChannel]:
        """The measured channels for which the run has a simulated signal."""
        return [channel for channel in self.channels if channel.model]


def measured(rec: Recording, path: str | Path, maps: Sequence[str], gravity: float) -> LogSignals:
    """Read a measured log and assign its columns to signals by map files; raises HeavyliftError for a fault in
    either."""
    log, t = read_log(path), None
    channels, lines = list[LogChannel](), dict[str, str]()
    for source in map(_source, maps):
        faults = list(source.faults)
        for column, text in source.data.items():
            try:
                line = LINE.fullmatch(text.strip()) if isinstance(text, str) else None
                if line is None:
                    raise ValueError(f"write to which channel '{column}' belongs, such as {EXAMPLE}")
                if column in lines:
                    raise ValueError(f"column '{column}' is mapped twice; map it only once")
                if line["channel"] == "time":
                    t = log.seconds(column, line["unit"] or "")
                else:
                    channels.append(_channel(rec, log, column, line, gravity))
                lines[column] = line[0]
            except (ValueError, SceneError) as error:
                faults.append(Fault((column,), str(error)))
        raise_faults(source, faults)
    names = [channel.name for channel in channels]
    if twice := next((name for i, name in enumerate(names) if name in names[:i]), ""):
        raise RecordingError(f"{log.path}: two columns are mapped to {twice}; map only one column to it")
    if not any(channel.model for channel in channels):
        raise RecordingError(f"{log.path}: no column is mapped to a channel of {rec.path}; add one, such as {EXAMPLE}")
    return LogSignals(log, log.seconds() if t is None else t, channels, lines)


def _source(given: str) -> SourceText:
    """Return the lines of a map file, or the single line of an option, with their places."""
    column, equals, line = given.partition("=")
    if equals:
        place = Mark("--map", 1, len(column) + 2, given)
        return SourceText("--map", {column.strip(): line.strip()}, values={(column.strip(),): place})
    try:
        source = read(content(Path(given)).decode(), given)
    except (OSError, ValueError) as error:
        message = getattr(error, "strerror", "") or "it is not UTF-8 text"
        where = "give a YAML file, or 'COLUMN=CHANNEL [UNIT]'"
        raise RecordingError(f"{given}: the map cannot be read ({message}); {where}") from None
    if not source.data and not source.keys:
        raise RecordingError(f'{given}: is not a valid map; write lines such as "cell_H1: {EXAMPLE[1:-1]}"')
    return source


def _channel(rec: Recording, log: LogTable, column: str, line: re.Match[str], gravity: float) -> LogChannel:
    """Read one channel; raises ValueError for a wrong line of the map, RecordingError for a fault of the log."""
    name, unit = line["channel"], tidy(line["unit"] or log.unit(column))
    if not unit:
        raise log.error(1, column, f"the unit is missing; write it in the header or in the map, such as {EXAMPLE}")
    model = not name.startswith(MEASURED)
    if model:
        found = chosen(rec, name)
        if len(found) != 1 or name.startswith(ERROR):
            near = [f"{s}/{c}" for s in rec.signals() for c in rec.columns(s)]
            message = f"this matches {len(found)} channels" if found else "the run has no such channel"
            raise ValueError(f"{name}: {message}; {closest(name, near)}")
        signal, part = found[0]
        si = titles(rec.signal(signal))[rec.columns(signal).index(part)].rpartition("[")[2][:-1]
    else:
        signal, _, part = name.removeprefix(MEASURED).rpartition("/")
        if not part:
            raise ValueError(f"{name} does not name a channel; write one, such as {MEASURED}wind")
        signal = signal or part
        si = next((u for d in DIMENSIONS if unit in d.units for u, f in d.units.items() if f == 1), unit)
    units = _units(si, gravity) if model or si != unit else {unit: Fraction(1)}
    if unit not in units:
        raise ValueError(f"'{unit}' is not a unit of {name}; use {', '.join(offered(units))}")
    values = log.values(column) * float(units[unit])
    sigma = np.zeros(len(values)) if line["half"] is None else _stated(line["half"], values, units)
    return LogChannel(signal, part, si, values, sigma, model, bool(line["half"]))


def _units(si: str, gravity: float) -> dict[str, Fraction]:
    """Return units and their factors for a channel with this SI unit; for a force also units of mass, as weights."""
    fitting = [d for part in si.split(" or ") for d in DIMENSIONS if d.units.get(part) == 1]
    weights = {unit: factor * Fraction(gravity) for unit, factor in MASS.units.items()} if si == "N" else {}
    return {unit: factor for d in fitting for unit, factor in d.units.items() if unit} | weights


def _stated(half: str, values: Floats, units: Mapping[str, Fraction]) -> Floats:
    """Return standard uncertainties (n,) from a half-width at 95 % such as `3 %`; raises ValueError if it is none."""
    part, width = half_width(half, units)
    return 0.5 * (part * np.abs(values) + width)


FORM = re.compile(r"(?P<target>.+?)\.(?P<verb>[^.=]+)=(?P<file>.+?\.\w+):(?P<column>[^@\[]+?)\s*(?:\[(?P<unit>.*)\])?"
                  r"\s*(?:@\s*(?P<start>.+))?")  # fmt: skip
DRIVE_EXAMPLE = "'west.H1.hoist=log.csv:hoist_speed'"
BEYOND = 1e-3  # [m or rad] beyond an end position that are noise


def driven(scene: LoadedScene, texts: Sequence[str]) -> LoadedScene:
    """Return the scene with drives that follow measured logs; raises HeavyliftError that names the option, or file, row
    and column."""
    actors = {drive.element: drive for model in build(scene.plan).values() for drive in drives(model)}
    found: dict[str, Driven] = {}
    for text in texts:
        for log in _read(scene, text, actors):
            if log.actuator in found:
                raise SceneError(
                    f"--drive '{text}': {log.actuator} already follows {found[log.actuator].source}; leave one out"
                )
            found[log.actuator] = log
    return replace(scene, plan=msgspec.structs.replace(scene.plan, driven=tuple(found.values())))


def _read(scene: LoadedScene, text: str, actors: dict[str, DriveActor]) -> list[Driven]:
    """Return the tables of all drives that one option names."""
    form = FORM.fullmatch(text.strip())
    if form is None:
        raise SceneError(f"--drive '{text}': write target, verb, file and column, such as {DRIVE_EXAMPLE}")
    log = read_log(form["file"])
    unit, column = tidy(form["unit"] or log.unit(form["column"])), form["column"]
    kind = next((kind for kind in (STROKE_SPEED, STROKE) if unit in kind.units), None)
    if kind is None:
        what = f"'{unit}' is not a unit of a speed or place" if unit else "the unit is missing"
        raise log.error(1, column, f"{what}; write the unit after the name, such as '{column} [m/min]'")
    try:
        t = log.seconds() + (TIME.read(form["start"]) if form["start"] else 0.0)
    except ValueError as error:
        raise SceneError(f"--drive '{text}': {error}") from None
    values, late = log.values(column) * float(kind.units[unit]), t >= 0.0
    if late.sum() < 2:
        what = "no two rows lie within the run, which begins at 0 s; shift the log by '@'"
        raise log.error(log.rows[-1], column, what)
    t, values, rows = t[late], values[late], np.array(log.rows)[late].tolist()
    knots, speeds = _spline(t, values) if kind is STROKE else (t, np.concatenate([[0.0], values[1:]]))
    slow = f"0.0001 {'rad/s' if unit.startswith(('deg', 'rad')) else 'm/s'} until after 1 s"
    out = []
    for order in spoken(scene, f"{form['target'].replace('.', ' ')}: {form['verb']} {slow}").orders:
        if not isinstance(order, Move) or (drive := actors.get(order.actuator)) is None:
            raise SceneError(
                f"--drive '{text}': the scene does not model a drive or winch {form['target']}; name another"
            )
        sign = 1.0 if order.speed > 0.0 else -1.0
        distance = np.concatenate([[0.0], np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * np.diff(knots))])
        _within(log, column, rows, drive, t, drive.initial + sign * np.interp(t, knots, distance))
        times = tuple(np.round(knots * 1e9).astype(np.int64).tolist())
        source = f"{log.path.name}:{column}"
        out.append(Driven(actuator=order.actuator, source=source, accel=order.accel, times=times,
                          speeds=tuple((sign * speeds).tolist())))  # fmt: skip
    return out


def _spline(t: Floats, x: Floats) -> tuple[Floats, Floats]:
    """Return knots and speeds of a spline, two parabolas per interval, through `x` at times `t`, from rest to rest."""
    h, slope = np.diff(t), np.diff(x) / np.diff(t)
    v = np.concatenate([[0.0], (slope[:-1] * h[1:] + slope[1:] * h[:-1]) / (h[:-1] + h[1:]), [0.0]])
    knots, speeds = np.empty(2 * len(t) - 1), np.empty(2 * len(t) - 1)
    knots[::2], speeds[::2] = t, v
    knots[1::2], speeds[1::2] = t[:-1] + 0.5 * h, 2.0 * slope - 0.5 * (v[:-1] + v[1:])
    return knots, speeds


def _within(log: LogTable, column: str, rows: list[int], drive: DriveActor, t: Floats, x: Floats) -> None:
    """Raise RecordingError for the first row that moves a drive beyond its end position."""
    lower, upper = (end if end is not None else s * np.inf for end, s in zip(drive.ends, (-1.0, 1.0), strict=True))
    for i in np.flatnonzero((x < lower - BEYOND) | (x > upper + BEYOND)).tolist():
        distance = f"moves {drive.element} from {drive.initial:.6g} to {x[i]:.6g} at {t[i]:.6g} s"
        end = f"beyond its end at {lower if x[i] < lower else upper:.6g}"
        raise log.error(rows[i], column, f"{distance}, {end}; let the scene begin elsewhere, or cut the log there")
