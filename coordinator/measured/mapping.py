"""Which column of a log is which channel of a recording: `cell_H1: rope/tension/west.H1 [kN] +- 5 kN`.

A map is a YAML file of such lines, or each line an option `cell_H1=rope/tension/west.H1 [kN] +- 5 kN`.  The unit may
stand in the log's head instead.  What stands behind `+-`, in the channel's units or in %, is the sensor's uncertainty
at a level of 95 %, that is two standard uncertainties.  `clock: time [s]` names the log's times.  A mass in place of a
force is its weight, as load cells show it.  A channel `measured/NAME`, such as measured/wind, is none of the run's.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np
from heavylift.kernel.errors import RecordingError, SceneError
from heavylift.nodes.scene.text.faults import closest, raise_faults
from heavylift.nodes.scene.text.source import Fault, Mark, Source, read
from heavylift.nodes.scene.text.units import DIMENSIONS, MASS, NUMBER, TIME, tidy
from heavylift.recordings import Recording
from heavylift.recordings.read.extended import ERROR, MEASURED
from heavylift.recordings.read.log import DATES, Log, read_log
from heavylift.recordings.read.part import chosen
from heavylift.recordings.read.signal import titles
from numpy.typing import NDArray

__all__ = ["Channel", "Measured", "measured", "seconds"]

LINE = re.compile(r"(?P<channel>[^\[±]+?)\s*(?:\[(?P<unit>[^\]]*)\])?\s*(?:(?:\+-|\+/-|±)\s*(?P<half>.+))?")
HALF = re.compile(rf"(?P<number>{NUMBER})\s*(?P<unit>.*)")
EXAMPLE = "'rope/tension/west.H1 [kN] +- 5 kN'"
TIMES = ("time", "t")  # columns of times; the first stands for a channel, too
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Channel:
    """A measured channel: (signal, column) of the recording, values (n,) at the log's times in its unit, and standard
    uncertainties (n,) of the sensor; `model`: whether the run has it too; `stated`: whether the map says how uncertain
    it is."""

    signal: str
    column: str
    unit: str
    values: Floats
    sigma: Floats
    model: bool
    stated: bool

    @property
    def name(self) -> str:
        """As users write it."""
        return f"{self.signal}/{self.column}"


@dataclass(frozen=True)
class Measured:
    """A log as a map reads it: times (n,) [s] and channels."""

    log: Log
    t: Floats
    channels: list[Channel]
    lines: dict[str, str] = field(default_factory=dict)

    @property
    def compared(self) -> list[Channel]:
        """The channels that the run has, too."""
        return [channel for channel in self.channels if channel.model]


def measured(rec: Recording, path: str | Path, maps: Sequence[str], gravity: float) -> Measured:
    """Read a log by a map; HeavyliftError names what is wrong in map or log."""
    log, source = read_log(path), _source(maps)
    raise_faults(source, source.faults)
    t, channels, faults = None, list[Channel](), list[Fault]()
    for column, text in source.data.items():
        try:
            line = LINE.fullmatch(text.strip()) if isinstance(text, str) else None
            if line is None:
                raise ValueError(f"write the channel that '{column}' is, such as {EXAMPLE}")
            if line["channel"] == TIMES[0]:
                t = seconds(log, column, line["unit"] or "")
            else:
                channels.append(_channel(rec, log, column, line, gravity))
        except (ValueError, SceneError) as error:
            faults.append(Fault((column,), str(error)))
    raise_faults(source, faults)
    names = [channel.name for channel in channels]
    if twice := next((name for i, name in enumerate(names) if name in names[:i]), ""):
        raise RecordingError(f"{log.path}: two columns are mapped to {twice}; a channel has one")
    if not any(channel.model for channel in channels):
        raise RecordingError(f"{log.path}: no column is mapped to a channel of {rec.path}; add one, such as {EXAMPLE}")
    return Measured(log, seconds(log) if t is None else t, channels, {k: str(v) for k, v in source.data.items()})


def _source(maps: Sequence[str]) -> Source:
    """Lines of all maps with their places."""
    found = Source("--map")
    for given in maps:
        column, equals, line = given.partition("=")
        if equals:
            part = Source("--map", {column.strip(): line.strip()})
            part.values[column.strip(),] = Mark("--map", 1, len(column) + 2, given)
        else:
            try:
                part = read(Path(given).read_text("utf-8"), given)
            except (OSError, ValueError) as error:
                told = getattr(error, "strerror", "") or "it is not UTF-8 text"
                raise RecordingError(
                    f"{given}: no map can be read there ({told}); give a YAML file, or 'COLUMN=CHANNEL [UNIT]'"
                ) from None
            if not part.data and not part.keys:
                raise RecordingError(f'{given}: is no map; write lines such as "cell_H1: {EXAMPLE[1:-1]}"')
        if again := next((name for name in part.data if name in found.data), ""):
            raise RecordingError(f"{given}: column '{again}' is mapped twice; say once what it is")
        found = found.merge(part)
        found.name = part.name
    return found


def _channel(rec: Recording, log: Log, column: str, line: re.Match[str], gravity: float) -> Channel:
    """One channel; ValueError for what is wrong in its line, RecordingError for what is in the log."""
    name, unit = line["channel"], tidy(line["unit"] or log.unit(column))
    if not unit:
        raise log.error(1, column, f"the unit is missing; write it in the head or in the map, such as {EXAMPLE}")
    model = not name.startswith(MEASURED)
    if model:
        found = chosen(rec, name)
        if len(found) != 1 or name.startswith(ERROR):
            near = [f"{s}/{c}" for s in rec.signals() for c in rec.columns(s)]
            told = f"{len(found)} channels are meant" if found else "the run has no such channel"
            raise ValueError(f"{name}: {told}; {closest(name, near)}")
        signal, part = found[0]
        si = titles(rec.signal(signal))[rec.columns(signal).index(part)].rpartition("[")[2][:-1]
    else:
        signal, _, part = name.removeprefix(MEASURED).rpartition("/")
        signal, si = (
            signal or part,
            next((u for d in DIMENSIONS for u, f in d.units.items() if unit in d.units and f == 1), ""),
        )
    factor = _factors(si, gravity).get(unit)
    if factor is None:
        raise ValueError(
            f"'{unit}' is no unit of {name}; use {', '.join(_factors(si, gravity)) or 'one that scenes know'}"
        )
    values = log.values(column) * float(factor)
    return Channel(signal, part, si, values, _sigma(line["half"], si, values, gravity), model, bool(line["half"]))


def _factors(si: str, gravity: float) -> dict[str, Fraction]:
    """Units, with their factors, in which a channel of this SI unit, or of these, can be written."""
    parts = si.split(" or ")
    found = {u: f for part in parts for d in DIMENSIONS if d.units.get(part) == 1 for u, f in d.units.items() if u}
    weights = {unit: factor * Fraction(gravity) for unit, factor in MASS.units.items()} if si == "N" else {}
    return found | weights


def _sigma(half: str | None, si: str, values: Floats, gravity: float) -> Floats:
    """Standard uncertainties from the half-width that a line states."""
    if half is None:
        return np.zeros(len(values))
    form = HALF.fullmatch(half.strip())
    if form is None or (width := float(form["number"])) < 0.0:
        raise ValueError(f"'+- {half}' is no uncertainty: write a number and a unit, such as '+- 5 kN' or '+- 1 %'")
    unit = tidy(form["unit"])
    if unit == "%":
        return 0.5 * width / 100.0 * np.abs(values)
    if (factor := _factors(si, gravity).get(unit)) is None:
        raise ValueError(f"'+- {half}': '{unit}' is no unit of it; use %, {', '.join(_factors(si, gravity))}")
    return np.full(len(values), 0.5 * width * float(factor))


def seconds(log: Log, column: str = "", unit: str = "") -> NDArray[np.float64]:
    """(n,) times [s]; RecordingError if they do not rise or have gaps, or without a column or unit."""
    column = column or next((name for name, _ in log.head if name.lower() in TIMES), TIMES[0])
    t, unit = log.times(column), tidy(unit or log.unit(column))
    if unit == DATES:
        return t
    if unit not in TIME.units:
        told = f"'{unit}' is no unit of time" if unit else "the unit is missing"
        raise log.error(1, column, f"{told}; write it behind the name, such as '{column} [s]'")
    return t * float(TIME.units[unit])
