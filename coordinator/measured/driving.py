"""Drives of a run that follow the log of a real machine: `west.H1.hoist=log.csv:hoist_speed [m/min] @ -36000 s`.

What a drive is called and which way it goes are the words of the action list: target and verb.  A column of speeds is
followed in straight lines from row to row; through one of places leads a spline of two parabolas per row, whose speed
at a row is the mean of those beside it.  `@` says at which time of the run the log's time 0 is.  The table stands in
the plan and so in the recording.
"""

import re
from collections.abc import Sequence
from dataclasses import replace

import msgspec
import numpy as np
from heavylift.kernel.errors import SceneError
from heavylift.nodes.models import build
from heavylift.nodes.models.assembly import drives
from heavylift.nodes.models.parts.drive import DriveActor
from heavylift.nodes.plan.actions import Move
from heavylift.nodes.plan.plan import Driven
from heavylift.nodes.scene import LoadedScene
from heavylift.nodes.scene.operator_command import spoken
from heavylift.nodes.scene.text.spelling import tidy
from heavylift.nodes.scene.text.units import STROKE, STROKE_SPEED, TIME
from heavylift.recordings.read.log import LogTable, read_log
from numpy.typing import NDArray

FORM = re.compile(r"(?P<target>.+?)\.(?P<verb>[^.=]+)=(?P<file>.+?\.\w+):(?P<column>[^@\[]+?)\s*(?:\[(?P<unit>.*)\])?"
                  r"\s*(?:@\s*(?P<start>.+))?")  # fmt: skip
EXAMPLE = "'west.H1.hoist=log.csv:hoist_speed'"
BEYOND = 1e-3  # [m or rad] beyond an end position that are noise
Floats = NDArray[np.float64]


def driven(scene: LoadedScene, texts: Sequence[str]) -> LoadedScene:
    """The scene with drives that follow logs; HeavyliftError names the option, or file, row and column at fault."""
    actors = {drive.element: drive for model in build(scene.plan).values() for drive in drives(model)}
    found: dict[str, Driven] = {}
    for text in texts:
        for log in _read(scene, text, actors):
            if log.actuator in found:
                raise SceneError(f"--drive '{text}': {log.actuator} follows {found[log.actuator].source} already")
            found[log.actuator] = log
    return replace(scene, plan=msgspec.structs.replace(scene.plan, driven=tuple(found.values())))


def _read(scene: LoadedScene, text: str, actors: dict[str, DriveActor]) -> list[Driven]:
    """The tables of all drives that one option names."""
    form = FORM.fullmatch(text.strip())
    if form is None:
        raise SceneError(f"--drive '{text}': write target, verb, file and column, such as {EXAMPLE}")
    log = read_log(form["file"])
    unit, column = tidy(form["unit"] or log.unit(form["column"])), form["column"]
    kind = next((kind for kind in (STROKE_SPEED, STROKE) if unit in kind.units), None)
    if kind is None:
        what = f"'{unit}' is no unit of a speed or place" if unit else "the unit is missing"
        raise log.error(1, column, f"{what}; write it behind the name, such as '{column} [m/min]'")
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
            raise SceneError(f"--drive '{text}': {form['target']} is no drive or winch that this scene models")
        sign = 1.0 if order.speed > 0.0 else -1.0
        distance = np.concatenate([[0.0], np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * np.diff(knots))])
        _within(log, column, rows, drive, t, drive.initial + sign * np.interp(t, knots, distance))
        times = tuple(np.round(knots * 1e9).astype(np.int64).tolist())
        source = f"{log.path.name}:{column}"
        out.append(Driven(actuator=order.actuator, source=source, accel=order.accel, times=times,
                          speeds=tuple((sign * speeds).tolist())))  # fmt: skip
    return out


def _spline(t: Floats, x: Floats) -> tuple[Floats, Floats]:
    """Knots and speeds of the spline with two parabolas per interval through positions x, at rest at both ends."""
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
        distance = f"leads {drive.element} from {drive.initial:.6g} to {x[i]:.6g} at {t[i]:.6g} s"
        end = f"beyond its end at {lower if x[i] < lower else upper:.6g}"
        raise log.error(rows[i], column, f"{distance}, {end}; let the scene begin elsewhere, or cut the log there")
