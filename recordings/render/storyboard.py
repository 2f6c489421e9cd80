"""A picture of the lift itself: some instants of a recording side by side, seen along the rails.

The instants divide the path of the bodies (displacement and rotation) evenly, so a long wait takes no frame. The
drawing uses the topics for viewers: boxes of /scene, frames of /poses, rope lines of /rig.

What all figures on paper share: ink, how text is set, how the file is written.

Names in recordings are drawn literally: a dollar sign begins no formula. Equal recordings give equal files.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import groupby, pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from heavylift.kernel.description.findings import clock
from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.format.viewer_messages import DrawnBox, RopeLine, corners, turned
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.signal import Signal
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import PartFile, written
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection, PolyCollection
    from matplotlib.figure import Figure
    from matplotlib.text import Text

INK, QUIET, BAND, LIMIT = "#1d2733", "#6b7682", "#f1f4f7", "#a3182b"
FORMATS = (".png", ".svg")
STEPS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400)  # [s]
TICKS = 9  # at most along an axis of times
NEAR = 2.5  # times what is drawn: a limit that is farther away is not
CLOSE = 0.05  # of the largest value: limits that are nearer to one another share a label


@contextmanager
def on_paper() -> Iterator[None]:
    """Return a context that sets the matplotlib style of figures for files."""
    from matplotlib import rc_context

    with rc_context({"svg.hashsalt": "heavylift", "font.size": 9.5, "axes.linewidth": 0.8, "text.parse_math": False}):
        yield


def tidied(axes: Axes, label: str) -> None:
    """Style the axes of a figure: light grid, no frame at the top and right, and a label for the values."""
    axes.set_ylabel(label, color=INK)
    axes.grid(axis="y", color="#d9dee3", lw=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def timed(axes: Axes) -> None:
    """Label the x axis with the time of the run: in seconds, or as h:min:s if it lasts a minute or longer."""
    from matplotlib.ticker import FixedLocator

    first, last = axes.get_xlim()
    if last < 60.0:
        axes.set_xlabel("Time [s]", color=INK)
        return
    step = next((x for x in STEPS if (last - first) / x <= TICKS), max(STEPS[-1], (last - first) / TICKS))
    axes.xaxis.set_major_locator(FixedLocator([k * step for k in range(math.ceil(first / step), int(last / step) + 1)]))
    axes.xaxis.set_major_formatter(lambda t, _: clock(t, 0 if step >= 1 else 2))
    axes.set_xlabel("Time [h:min:s]" if last >= 3600 else "Time [min:s]", color=INK)


def limited(axes: Axes, limits: Mapping[str, float], unit: str, high: float) -> float:
    """Draw lines at rated values not far above the largest value `high`; return the upper end of the axis."""
    near = {name: limit for name, limit in limits.items() if limit < NEAR * high}
    top = max([high, *near.values()])
    groups: list[list[str]] = []  # those whose lines are close to one another share a label
    for name in sorted(near, key=lambda x: (near[x], x)):
        if groups and near[name] - near[groups[-1][0]] < CLOSE * top:
            groups[-1].append(name)
        else:
            groups.append([name])
    for names in groups:
        values = [near[name] for name in names]
        for limit in sorted(set(values)):
            axes.axhline(limit, color=LIMIT, lw=1.1, ls=(0, (6, 3)), zorder=2)
        message = " to ".join(dict.fromkeys(map(digits, (values[0], values[-1]))))
        of = names[0] + (f" and {len(names) - 1} more" if len(names) > 1 else "")
        text = f"rated {message} {unit}" + (f": {of}" if len(groups) > 1 else "")
        axes.annotate(text, (1, values[-1]), xycoords=("axes fraction", "data"), xytext=(-4, 3), ha="right",
                      textcoords="offset points", color=LIMIT, size=8.5)  # fmt: skip
    return top


def digits(value: float) -> str:
    """Return a number as text, with thousands separated by a thin space."""
    text = f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
    return text.replace(",", "\u2009").replace("-", "\u2212")


def banded(axes: Axes, times: Sequence[float], last: float) -> Iterator[tuple[float, float]]:
    """Shade the background of every other stage of a figure; yield the start and end [s] of each stage."""
    for i, (start, stop) in enumerate(pairwise([*times, last])):
        if i % 2 == 0:
            axes.axvspan(start, stop, color=BAND, lw=0, zorder=0)
        yield start, stop


def spread(wanted: Sequence[float], highest: Sequence[float], gap: float) -> list[float]:
    """Return positions for labels: near the wanted ones, at least `gap` apart, none above its value in `highest`."""
    blocks: list[tuple[float, int]] = []  # mean place of labels that touch, how many they are
    for i, place in enumerate(wanted):
        blocks.append((place - i * gap, 1))
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (a, n), (b, m) = blocks[-2:]
            blocks[-2:] = [((a * n + b * m) / (n + m), n + m)]
    free = [mean for mean, n in blocks for _ in range(n)]
    places = [max(0.0, mean) + i * gap for i, mean in enumerate(free)]
    for i in reversed(range(len(places))):
        after = places[i + 1] - gap if i + 1 < len(places) else highest[i]
        places[i] = min(places[i], highest[i], after)
    return places


def save(figure: Figure, out: Path, force: bool = False, dpi: int = 160) -> Path:
    """Write a figure to a .png or .svg file and return its path; raises RecordingError if writing fails."""
    form = out.suffix.lower()[1:]
    metadata = {"Date": None, "Creator": GENERATOR} if form == "svg" else {"Software": GENERATOR}
    with PartFile(out, "a figure", FORMATS, force) as file, file.writing():
        figure.savefig(file.stream, format=form, dpi=dpi, metadata=metadata)
    return file.path


Floats = NDArray[np.float64]
TURN_LENGTH = 20.0  # [m] way that one radian of turning counts as
FILM, INSTANTS, FRAME_ms = ".gif", 80, 100
EIGHTH = 8  # of the frames of a film, which tell its colours
GRID = 200  # instants between which the way is measured
SWAY, LITTLE = 0.5, 0.2  # [m] way between two of them that may be swing; and of the largest, where all goes slowly
FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))


def storyboard(path: str | Path | Recording, out: str | Path, frames: int = 6, force: bool = False) -> Path:
    """Draw `frames` instants of a recording side by side into a .png or .svg file, or as a film into a .gif file.

    Raises RecordingError if this is impossible.
    """
    out = output_path(out, "a picture", (*FORMATS, FILM))
    rec = path if isinstance(path, Recording) else Recording(path)
    with rec.reading(), on_paper():
        if out.suffix.lower() != FILM:
            return save(_figure(_Drawing(rec, frames), frames), out, force)
        return written(_film(_Drawing(rec, INSTANTS)), out, "a picture", (*FORMATS, FILM), force)


class _Drawing:
    """Some instants of a recording, with the data for drawing them."""

    def __init__(self, rec: Recording, frames: int) -> None:
        names = [name for name in rec.signals() if name.startswith("pose/")]
        if not names:
            raise RecordingError(f"{rec.path}: there are no poses to draw; record a scene with bodies")
        coarse = np.unique(np.linspace(0, rec.topics["/poses"].messages - 1, GRID).round().astype(int))
        seen = list(rec.picked(names, coarse).values())
        wanted = np.unique(np.interp(_instants(seen, frames), seen[0].t, coarse[: len(seen[0].t)]).round().astype(int))
        self._poses = {name.removeprefix("pose/"): pose for name, pose in rec.picked(names, wanted).items()}
        self.times = [float(t) for t in next(iter(self._poses.values())).t]
        self._faces = [(*_faces(box, self._poses, self.times), box.colour) for box in rec.boxes()]
        self._ropes, self._stages = _ropes(rec, self.times, self._poses), rec.stages()
        self._scene = rec.run.get("scene", "")

    def title(self, i: int) -> str:
        """Return the name of the stage and the time of an instant as text."""
        stage = next((name for at, name in reversed(self._stages) if at <= self.times[i]), self._scene)
        return f"{stage}, {clock(self.times[i])}"

    def seen(self, i: int) -> tuple[Floats, list[Any], Floats]:
        """Return instant i as seen along the x axis: faces (n, 4, 2), farthest first, colours, rope lines (n, 2, 2)."""
        faces = [(*face, colour) for far, flat, colour in self._faces for face in zip(far[i], flat[i], strict=True)]
        faces.sort(key=lambda face: -face[0])
        flats = np.array([f[1] for f in faces]).reshape(-1, 4, 2)  # an array, as Matplotlib checks each one of a list
        return flats, [f[2] for f in faces], self._ropes[i][:, :, 1:]

    def draw(self, ax: Axes, i: int) -> tuple[PolyCollection, LineCollection, Text]:
        """Draw one instant: faces, ropes, and title."""
        from matplotlib.collections import LineCollection, PolyCollection

        faces, colours, lines = self.seen(i)
        bodies = PolyCollection(faces, facecolors=colours, edgecolors=(0, 0, 0, 0.25), linewidths=0.3)  # type: ignore[arg-type]
        ropes = LineCollection(list(lines), colors="0.15", linewidths=0.8)
        ax.add_collection(bodies)
        ax.add_collection(ropes, autolim=False)
        ax.update_datalim(_framed(faces, lines))
        ax.axhline(0.0, color="0.5", linewidth=1.0)
        ax.set_aspect("equal")
        ax.autoscale_view()
        ax.margins(0.03)
        ax.set_axis_off()
        # a place of its own: Matplotlib looks for one in each picture otherwise
        return bodies, ropes, ax.set_title(self.title(i), fontsize=9, loc="left", y=1.0)


def _framed(faces: Floats, lines: Floats) -> Floats:
    """Return the points (n, 2) that a picture must show; mooring lines below all bodies may run out of it."""
    bodies, ends = faces.reshape(-1, 2), lines.reshape(-1, 2)
    return np.concatenate([bodies, ends[ends[:, 1] >= bodies[:, 1].min(initial=np.inf)] if len(bodies) else ends])


def _figure(drawing: _Drawing, frames: int) -> Figure:
    from matplotlib.figure import Figure as Canvas

    columns = min(frames, 3)
    rows = -(-frames // columns)
    figure = Canvas(figsize=(4.2 * columns, 3.2 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for i, ax in enumerate(axes):
        if i < len(drawing.times):
            drawing.draw(ax, i)
        else:
            ax.set_visible(False)
    return figure


def _film(drawing: _Drawing) -> bytes:
    """Return a GIF film that shows all instants one after another."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Canvas
    from PIL import Image

    figure = Canvas(figsize=(6.4, 4.8), dpi=100, layout="constrained")
    canvas, ax = FigureCanvasAgg(figure), figure.subplots()
    instants = [drawing.seen(i) for i in range(len(drawing.times))]
    bodies, ropes, title = drawing.draw(ax, 0)
    ax.update_datalim(np.concatenate([_framed(faces, lines) for faces, _, lines in instants]))
    ax.autoscale_view()
    drawn = []
    for i, (faces, colours, lines) in enumerate(instants):
        bodies.set(verts=faces, facecolors=colours)
        ropes.set_segments(list(lines))
        title.set_text(drawing.title(i))
        canvas.draw()  # type: ignore[no-untyped-call]
        figure.set_layout_engine("none")  # as it is now
        drawn.append(np.asarray(canvas.buffer_rgba())[:, :, :3].copy())  # type: ignore[no-untyped-call]
    inks = Image.fromarray(np.concatenate(drawn[::EIGHTH])).quantize()
    pictures = [Image.fromarray(x).quantize(palette=inks, dither=Image.Dither.NONE) for x in drawn]
    data = io.BytesIO()
    message = {"comment": GENERATOR.encode(), "duration": FRAME_ms, "loop": 0}
    pictures[0].save(data, "gif", save_all=True, append_images=pictures[1:], **message)
    return data.getvalue()


def _instants(poses: list[Signal], frames: int) -> list[float]:
    """Return times [s] that divide the motion of all bodies, as seen along x, into equal parts."""
    t = poses[0].t
    steps = []
    for pose in poses:
        place, quaternion = pose.values[:, 1:3], pose.values[:, 3:]
        step = np.linalg.norm(np.diff(place, axis=0), axis=1)
        cosine = np.abs((quaternion[1:] * quaternion[:-1]).sum(axis=1))
        steps.append(step + TURN_LENGTH * 2.0 * np.arccos(np.minimum(cosine, 1.0)))
    sway = min(SWAY, LITTLE * float(np.max(steps, initial=0.0)))
    distance = np.concatenate([[0.0], np.cumsum(np.maximum(np.array(steps) - sway, 0.0).sum(axis=0))])
    if distance[-1] == 0.0:
        distance = t
    wanted = np.linspace(0.0, distance[-1], frames)
    return [float(x) for x in np.interp(wanted, distance, t)]


def _ropes(rec: Recording, times: list[float], poses: dict[str, Signal]) -> list[Floats]:
    """Return the ends (n, 2, 3) of the rope lines at each of the instants of `poses`."""
    rigs = rec.rigs()
    none: list[RopeLine] = []
    valid = [next((rig.lines for rig in reversed(rigs) if rig.t_ns * 1e-9 <= t), none) for t in times]
    found = list[Floats]()
    for _, group in groupby(range(len(times)), key=lambda i: id(valid[i])):
        own = list(group)
        lines = valid[own[0]]
        ends = [_end(body, p, poses, own) for x in lines for body, p in ((x.a_body, x.a), (x.b_body, x.b))]
        found.extend(np.array(ends).reshape(-1, 2, len(own), 3).transpose(2, 0, 1, 3))
    return found


def _end(body: str, p: tuple[float, float, float], poses: dict[str, Signal], own: list[int]) -> Floats:
    """Return the world positions (n, 3) of a point on a body at n instants."""
    rows = poses[body].values[own] if body in poses else np.tile((0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), (len(own), 1))
    out: Floats = turned(rows[:, 3:], np.array(p)) + rows[:, :3]
    return out


def _faces(box: DrawnBox, poses: dict[str, Signal], times: list[float]) -> tuple[Floats, Floats]:
    """Return how far the faces of a shape are at n instants (n, 6), and their corners as seen along x (n, 6, 4, 2)."""
    world = np.broadcast_to(corners(box), (len(times), 8, 3))
    if box.body in poses:
        pose = poses[box.body]
        rows = pose.values[np.minimum(np.searchsorted(pose.t, times), len(pose.t) - 1)][:, None]
        world = turned(rows[..., 3:], world) + rows[..., :3]
    faces = world[:, np.array(FACES)]
    return faces[..., 0].mean(axis=-1), faces[..., 1:]
