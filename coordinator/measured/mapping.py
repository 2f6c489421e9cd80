"""Which column of a log is which channel of a recording: `cell_H1: rope/tension/west.H1 [kN] +- 5 kN`.

A map is a YAML file of such lines, or each line an option `cell_H1=rope/tension/west.H1 [kN] +- 5 kN`.  The unit may
stand in the log's head instead.  What stands behind `+-`, in the channel's units or in %, is the sensor's uncertainty
at a level of 95 %, that is two standard uncertainties.  `clock: time [s]` names the log's times.  A mass in place of a
force is its weight, as load cells show it.  A channel `measured/NAME`, such as measured/wind, is none of the run's.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from heavylift.kernel.errors import RecordingError, SceneError
from heavylift.nodes.scene.text.faults import closest, raise_faults
from heavylift.nodes.scene.text.files import content
from heavylift.nodes.scene.text.source import Fault, Mark, Source, read
from heavylift.nodes.scene.text.spelling import PLUS, tidy
from heavylift.nodes.scene.text.uncertainty import half_width
from heavylift.nodes.scene.text.units import DIMENSIONS, MASS, offered
from heavylift.recordings import Recording
from heavylift.recordings.format.samples import ERROR, MEASURED
from heavylift.recordings.read.log import LogTable, read_log
from heavylift.recordings.read.part import chosen
from heavylift.recordings.read.signal import titles
from numpy.typing import NDArray

LINE = re.compile(rf"(?P<channel>[^\[±]+?)\s*(?:\[(?P<unit>[^\]]*)\])?\s*(?:(?:{PLUS})\s*(?P<half>.+))?")
EXAMPLE = "'rope/tension/west.H1 [kN] +- 5 kN'"
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LogChannel:
    """A measured channel: (signal, column) of the recording, values (n,) in its unit, sensor's standard uncertainties
    (n,); `model`: the run has it too; `stated`: the map states its uncertainty."""

    signal: str
    column: str
    unit: str
    values: Floats
    sigma: Floats
    model: bool
    stated: bool

    @property
    def name(self) -> str:
        """The name as users write it."""
        return f"{self.signal}/{self.column}"


@dataclass(frozen=True)
class LogSignals:
    """A log read by a map: times (n,) [s], channels, and the lines of the map."""

    log: LogTable
    t: Floats
    channels: list[LogChannel]
    lines: dict[str, str]

    @property
    def compared(self) -> list[LogChannel]:
        """The channels that the run has too."""
        return [channel for channel in self.channels if channel.model]


def measured(rec: Recording, path: str | Path, maps: Sequence[str], gravity: float) -> LogSignals:
    """Read a log by a map; HeavyliftError names what is wrong in map or log."""
    log, t = read_log(path), None
    channels, lines = list[LogChannel](), dict[str, str]()
    for source in map(_source, maps):
        faults = list(source.faults)
        for column, text in source.data.items():
            try:
                line = LINE.fullmatch(text.strip()) if isinstance(text, str) else None
                if line is None:
                    raise ValueError(f"write the channel that '{column}' is, such as {EXAMPLE}")
                if column in lines:
                    raise ValueError(f"column '{column}' is mapped twice; say once what it is")
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
        raise RecordingError(f"{log.path}: two columns are mapped to {twice}; a channel has one")
    if not any(channel.model for channel in channels):
        raise RecordingError(f"{log.path}: no column is mapped to a channel of {rec.path}; add one, such as {EXAMPLE}")
    return LogSignals(log, log.seconds() if t is None else t, channels, lines)


def _source(given: str) -> Source:
    """The lines of a file, or the one of an option, with their places."""
    column, equals, line = given.partition("=")
    if equals:
        place = Mark("--map", 1, len(column) + 2, given)
        return Source("--map", {column.strip(): line.strip()}, values={(column.strip(),): place})
    try:
        source = read(content(Path(given)).decode(), given)
    except (OSError, ValueError) as error:
        message = getattr(error, "strerror", "") or "it is not UTF-8 text"
        where = "give a YAML file, or 'COLUMN=CHANNEL [UNIT]'"
        raise RecordingError(f"{given}: no map can be read there ({message}); {where}") from None
    if not source.data and not source.keys:
        raise RecordingError(f'{given}: is no map; write lines such as "cell_H1: {EXAMPLE[1:-1]}"')
    return source


def _channel(rec: Recording, log: LogTable, column: str, line: re.Match[str], gravity: float) -> LogChannel:
    """Read one channel; raises ValueError for its line, RecordingError for the log."""
    name, unit = line["channel"], tidy(line["unit"] or log.unit(column))
    if not unit:
        raise log.error(1, column, f"the unit is missing; write it in the head or in the map, such as {EXAMPLE}")
    model = not name.startswith(MEASURED)
    if model:
        found = chosen(rec, name)
        if len(found) != 1 or name.startswith(ERROR):
            near = [f"{s}/{c}" for s in rec.signals() for c in rec.columns(s)]
            message = f"{len(found)} channels are meant" if found else "the run has no such channel"
            raise ValueError(f"{name}: {message}; {closest(name, near)}")
        signal, part = found[0]
        si = titles(rec.signal(signal))[rec.columns(signal).index(part)].rpartition("[")[2][:-1]
    else:
        signal, _, part = name.removeprefix(MEASURED).rpartition("/")
        if not part:
            raise ValueError(f"{name} has no name; give it one, such as {MEASURED}wind")
        signal = signal or part
        si = next((u for d in DIMENSIONS if unit in d.units for u, f in d.units.items() if f == 1), unit)
    units = _units(si, gravity) if model or si != unit else {unit: Fraction(1)}
    if unit not in units:
        raise ValueError(f"'{unit}' is no unit of {name}; use {', '.join(offered(units))}")
    values = log.values(column) * float(units[unit])
    sigma = np.zeros(len(values)) if line["half"] is None else _stated(line["half"], values, units)
    return LogChannel(signal, part, si, values, sigma, model, bool(line["half"]))


def _units(si: str, gravity: float) -> dict[str, Fraction]:
    """Units and factors for a channel with this SI unit."""
    fitting = [d for part in si.split(" or ") for d in DIMENSIONS if d.units.get(part) == 1]
    weights = {unit: factor * Fraction(gravity) for unit, factor in MASS.units.items()} if si == "N" else {}
    return {unit: factor for d in fitting for unit, factor in d.units.items() if unit} | weights


def _stated(half: str, values: Floats, units: Mapping[str, Fraction]) -> Floats:
    """Standard uncertainties (n,) from a half-width at 95 % such as `3 %`; raises ValueError if it is none."""
    part, width = half_width(half, units)
    return 0.5 * (part * np.abs(values) + width)
