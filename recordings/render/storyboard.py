"""A picture of the lift itself: some instants of a recording side by side, seen along the rails.

The instants are spread evenly over the way that the bodies have gone (shift and turn), so a long wait takes no frame.
Drawn from what the recording holds for any viewer: boxes of /scene, frames of /poses, lines of /ropes.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.text import duration
from heavylift.recordings.format.viewer_messages import Box, SceneUpdate, corners, turned
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.signal import Signal
from heavylift.recordings.write.outputs import output_path
from numpy.typing import NDArray

from .paper import FORMATS, on_paper, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["storyboard"]

Floats = NDArray[np.float64]
TURN_LENGTH = 20.0  # [m] way that one radian of turning counts as
GRID = 200  # instants between which the way is measured
SWAY = 0.5  # [m] way between two of them that may be swing
FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))


def storyboard(path: str | Path, out: str | Path, frames: int = 6, force: bool = False) -> Path:
    """Draw `frames` instants of the recording into a .png or .svg; RecordingError if that cannot be done."""
    out = output_path(out, "a picture", FORMATS)
    rec = Recording(path)
    with rec.reading(), on_paper():
        return save(_figure(rec, frames), out, force)


def _figure(rec: Recording, frames: int) -> Figure:
    names = [name for name in rec.signals() if name.startswith("pose/")]
    if not names:
        raise RecordingError(f"{rec.path}: there are no poses to draw; record a scene with bodies")
    from matplotlib.figure import Figure as Canvas

    instants = np.concatenate([np.array(times) / 1e9 for times, _ in rec.blocks(names[:1])])
    coarse = np.unique(np.linspace(0, len(instants) - 1, GRID).round().astype(int))
    times = _instants(list(rec.picked(names, coarse).values()), frames)
    wanted = np.unique(np.minimum(np.searchsorted(instants, times), len(instants) - 1))
    poses = {name.removeprefix("pose/"): pose for name, pose in rec.picked(names, wanted).items()}
    columns = min(frames, 3)
    rows = -(-frames // columns)
    figure = Canvas(figsize=(4.2 * columns, 3.2 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    boxes = [(box, corners(box)) for box in rec.boxes()]
    ropes, stages = _ropes(rec, times), rec.stages()
    for ax, t, lines in zip(axes, times, ropes, strict=False):
        _frame(ax, t, poses, boxes, lines)
        stage = next((name for at, name in reversed(stages) if at <= t), rec.run.get("scene", ""))
        ax.set_title(f"{stage}, {duration(t)}", fontsize=9, loc="left")
    for ax in axes[len(times) :]:
        ax.set_visible(False)
    return figure


def _instants(poses: list[Signal], frames: int) -> list[float]:
    """Times that cut the way of all bodies, as far as it is seen along x, into equal parts."""
    t = poses[0].t
    way = np.zeros(len(t))
    for pose in poses:
        place, quaternion = pose.values[:, 1:3], pose.values[:, 3:]
        step = np.linalg.norm(np.diff(place, axis=0), axis=1)
        cosine = np.abs((quaternion[1:] * quaternion[:-1]).sum(axis=1))
        step += TURN_LENGTH * 2.0 * np.arccos(np.minimum(cosine, 1.0))
        way[1:] += np.cumsum(np.maximum(step - SWAY, 0.0))
    if way[-1] == 0.0:
        way = t
    wanted = np.linspace(0.0, way[-1], frames)
    return [float(x) for x in np.interp(wanted, way, t)]


def _ropes(rec: Recording, times: list[float]) -> list[Floats]:
    """(n, 2, 3) ends of the rope lines at the message next after each time."""
    found: list[Floats] = []
    empty = np.zeros((0, 2, 3))
    last = empty
    for raw in rec.messages("/ropes"):
        while len(found) < len(times) and raw.log_time * 1e-9 > times[len(found)]:
            found.append(last)
        lines = [x for e in SceneUpdate.FromString(raw.data).entities for x in e.lines]
        last = np.array([[q.x, q.y, q.z] for x in lines for q in x.points]).reshape(-1, 2, 3)
    return found + [last] * (len(times) - len(found))


def _frame(ax: Axes, t: float, poses: dict[str, Signal], boxes: list[tuple[Box, Floats]], lines: Floats) -> None:
    """One instant: faces from far to near, then ropes, seen along x."""
    from matplotlib.collections import LineCollection, PolyCollection

    faces = []
    for box, world in boxes:
        if box.body in poses:
            pose = poses[box.body]
            row = pose.values[min(int(np.searchsorted(pose.t, t)), len(pose.t) - 1)]
            world = turned(row[3:], world) + row[:3]
        faces += [(world[list(f), 0].mean(), world[list(f), 1:], box.colour) for f in FACES]
    faces.sort(key=lambda face: -face[0])
    ax.add_collection(
        PolyCollection(
            [f[1] for f in faces], facecolors=[f[2] for f in faces], edgecolors=(0, 0, 0, 0.25), linewidths=0.3
        )
    )
    ax.add_collection(LineCollection(list(lines[:, :, 1:]), colors="0.15", linewidths=0.8))
    ax.axhline(0.0, color="0.5", linewidth=1.0)
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.margins(0.03)
    ax.set_axis_off()
