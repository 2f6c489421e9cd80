"""Drawings: plan, elevation and rigging sketch of each key instant on a sheet of A4, with a title block.

As SVG, a drawing is an <svg> element in millimetres of its sheet.

As DXF, drawings are in metres and side by side: each view is in true size, with real dimensions. The sheet has the
scale of plan and elevation; the rigging sketch beside them is drawn in its own true size.
"""

import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np
from heavylift.kernel.description.findings import clock
from heavylift.kernel.errors import RecordingError, extra
from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import RecordedVerdict
from heavylift.recordings.sheets.sheet import Chart
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .ink import TEXT, DimensionLine, Path, Text, View, parts, points_of
from .instants import DrawnInstant, instants_of
from .views import general, rigging

INK, RED = "#111", "#a3182b"
STYLES = {
    "crane": ("#ececec", "#444", 0.22), "block": ("#e8cfc4", INK, 0.35), "deck": ("#d3ab9a", INK, 0.2),
    "hook": ("#555", INK, 0.2), "frame": ("#bcd3d2", INK, 0.25), "world": ("#e4e4e4", "#888", 0.18),
    "rope": ("none", INK, 0.18), "thin": ("none", "#666", 0.12), "axis": ("none", "#666", 0.13),
    "near": ("none", RED, 0.35), "frame line": ("none", INK, 0.35),
}  # fmt: skip


def svg_of(views: Sequence[View], size: tuple[float, float], title: str) -> str:
    """Return views as SVG on a sheet of this size [mm]."""
    body = "".join(f"<g>{''.join(_items(view, size[1]))}</g>" for view in views)
    fonts = 'font-family="DejaVu Sans, Arial, sans-serif"'
    box = f'viewBox="0 0 {size[0]:g} {size[1]:g}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" class="drawing" role="img" {box} {fonts}>'
    return f"{head}<title>{escape(title)}</title>{body}</svg>"


def _items(view: View, height: float) -> Iterable[str]:
    x0, y0 = view.place

    def at(x: float, y: float) -> tuple[float, float]:
        return x0 + x, height - y0 - y

    every = [(item, part) for item in view.items for part in parts(item)]
    yield from (_path(part, at) for _, part in every if isinstance(part, Path))
    for item, part in every:
        if isinstance(part, Text):
            yield _ground(part, at) if isinstance(item, DimensionLine) else ""
            yield _text(part, *at(*part.at))


def _ground(item: Text, at: Callable[[float, float], tuple[float, float]]) -> str:
    """Return the white ground of a number, which lines of other dimensions may cross."""
    box = points_of(item)
    (x, y), (right, top) = at(*box.min(axis=0)), at(*box.max(axis=0))
    return f'<rect x="{x:.2f}" y="{top:.2f}" width="{right - x:.2f}" height="{y - top:.2f}" fill="#fff"/>'


def _path(item: Path, at: Callable[[float, float], tuple[float, float]]) -> str:
    fill, stroke, width = STYLES[item.style]
    points = " ".join("{:.2f},{:.2f}".format(*at(x, y)) for x, y in item.points)
    dash = ' stroke-dasharray="3 0.8 0.6 0.8"' if item.style == "axis" else ""
    shape, fill = ("polygon", fill) if item.closed else ("polyline", "none")
    return f'<{shape} points="{points}" fill="{fill}" stroke="{stroke}" stroke-width="{width}"{dash}/>'


def _text(item: Text, x: float, y: float) -> str:
    turn = f' transform="rotate({-item.angle:g} {x:.2f} {y:.2f})"' if item.angle else ""
    bold = ' font-weight="bold"' if item.bold else ""
    place = f'x="{x:.2f}" y="{y:.2f}" font-size="{item.size:g}" text-anchor="{item.anchor}"'
    return f'<text {place}{turn}{bold} fill="{INK}">{escape(item.words)}</text>'


SIZE = 283.0, 196.0  # [mm] A4 without its margins
EDGE = 0.3  # [mm] of the border within the sheet
STRIP = 17.0  # height of the title block
LEFT = 172.0  # width of plan and elevation
MARGIN = 1.5  # [mm] around a view on its own sheet
BOLD = 0.72  # of its height: a bold letter
CELLS = (0.0, 62.0, 150.0, 202.0, 242.0, SIZE[0])


def svg_alone(view: View, room: tuple[float, float]) -> str:
    """Return a view as SVG, centred on a sheet of at least the size `room` [mm]."""
    points = np.concatenate([points_of(item) for item in view.items])
    low, high = points.min(axis=0), points.max(axis=0)
    width, height = np.maximum(high - low + 2 * MARGIN, room).tolist()
    view.place = (width - float(low[0] + high[0])) / 2, (height - float(low[1] + high[1])) / 2
    return svg_of([view], (width, height), view.title)


class Drawing(NamedTuple):
    """A drawing: the views on a sheet; the last view is the frame with the title block."""

    title: str
    views: list[View]


def drawings(rec: Recording, verdict: RecordedVerdict | None, project: Mapping[str, str]) -> list[Chart]:
    """Return the drawings of a recording with suspended loads, as SVG charts."""
    return [Chart(x.title, svg_of(x.views, SIZE, x.title)) for x in drawn(rec, verdict, project)]


def drawn(rec: Recording, verdict: RecordedVerdict | None, project: Mapping[str, str]) -> list[Drawing]:
    """Return the drawings of a recording with suspended loads, as views."""
    with rec.reading():
        found = instants_of(rec, verdict)
        return [_drawing(x, i, len(found), rec, project) for i, x in enumerate(found, 1)]


def _drawing(x: DrawnInstant, number: int, of: int, rec: Recording, project: Mapping[str, str]) -> Drawing:
    title = f"Drawing {number}: {x.title}, {clock(x.t, 1)}"
    height = SIZE[1] - STRIP
    plan, elevation = general(x, (LEFT, height))
    sketch = rigging(x, (SIZE[0] - LEFT, height))
    sizes = [_extent(view) for view in (plan, elevation)]
    spare = height - sum(high[1] - low[1] for low, high in sizes)
    y = STRIP + max(0.0, spare / 3)
    for view, (low, high) in zip((elevation, plan), sizes[::-1], strict=True):
        view.place = (LEFT - (low[0] + high[0])) / 2, y - low[1]
        y += high[1] - low[1] + max(0.0, spare / 3)
    low, high = _extent(sketch)
    sketch.centre = (low[0] + high[0]) / 2, (low[1] + high[1]) / 2
    sketch.place = LEFT + (SIZE[0] - LEFT - low[0] - high[0]) / 2, STRIP + (height - low[1] - high[1]) / 2
    frame = _frame()
    whose = " ".join(filter(None, (project.get("number"), project.get("name")))) or "-"
    _title_block(
        frame,
        (
            ("Project", whose, f"scene {rec.run.get('scene', rec.path.stem)}"),
            ("Drawing", x.title, f"at {clock(x.t, 1)} of the run, digest {rec.result.get('digest', 'none')[:12]}"),
            ("Scale, dimensions in m", f"1 : {elevation.scale:g}", f"rigging 1 : {sketch.scale:g}"),
            ("Prepared", project.get("author") or "-", project.get("date", "")),
            ("Sheet, revision", f"{number} of {of}", f"revision {project.get('revision') or '0'}"),
        ),
    )
    return Drawing(title, [plan, elevation, sketch, frame])


def _extent(view: View) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the lower and upper corner of all items of a view, after adding its title."""
    points = np.concatenate([points_of(item) for item in view.items])
    (x, y), (right, top) = points.min(axis=0), points.max(axis=0)
    view.items.append(Text((x, top + 3.0), view.title, size=3.0, bold=True))
    return (float(x), float(y)), (float(right), float(top) + 6.0)


def _frame() -> View:
    """Return the frame of a sheet: border, title block, and the line between the views."""
    frame, (width, height) = View("", 1.0), SIZE
    corners = [[EDGE, EDGE], [width - EDGE, EDGE], [width - EDGE, height - EDGE], [EDGE, height - EDGE], [EDGE, EDGE]]
    frame.items.append(Path(np.array(corners), "frame line"))
    frame.items.append(Path(np.array([[EDGE, STRIP], [width - EDGE, STRIP]]), "frame line"))
    frame.items.append(Path(np.array([[LEFT, STRIP], [LEFT, height - EDGE]]), "thin"))
    return frame


def _title_block(frame: View, cells: Sequence[tuple[str, str, str]]) -> None:
    """Add a title block to a frame: a heading and two lines in each cell."""
    for (x, right), (head, first, second) in zip(pairwise(CELLS), cells, strict=True):
        size = min(2.8, (right - x - 4.0) / (BOLD * max(1, len(first))))
        frame.items.append(Path(np.array([[x, EDGE], [x, STRIP]]), "thin"))
        frame.items += [Text((x + 2.0, 12.6), head, size=1.9), Text((x + 2.0, 7.6), first, size=size, bold=True)]
        frame.items.append(Text((x + 2.0, 3.0), second, size=2.2))


ENDINGS = (".dxf",)
COLOURS = {"crane": 8, "block": 30, "deck": 32, "hook": 250, "frame": 130, "world": 9, "rope": 7, "thin": 8, "axis": 8,
           "near": 1, "frame line": 7, "dimension": 7, "text": 7}  # fmt: skip
METRES = 6  # $INSUNITS


def write_dxf(
    rec: Recording,
    out: str | FilePath,
    verdict: RecordedVerdict | None,
    project: Mapping[str, str],
    force: bool = False,
) -> FilePath:
    """Write a recording's drawings to a .dxf file; raises RecordingError without ezdxf or a suspended load."""
    path = output_path(out, "a drawing", ENDINGS)
    missing = "drawings as DXF need ezdxf: pip install 'heavylift[drawings]'; or write the report as .html or .pdf"
    library: Any = extra("ezdxf", RecordingError(missing))
    found = drawn(rec, verdict, project)
    if not found:
        raise RecordingError(f"{rec.path}: no load hangs on a hook, so there is nothing to draw")
    library.options.write_fixed_meta_data_for_testing = True  # equal recordings give equal files
    document = library.new("R2010", setup=True, units=METRES)
    for name, colour in COLOURS.items():
        document.layers.add(name.replace(" ", "-"), color=colour)
    x = 0.0
    for drawing in found:
        scale = drawing.views[0].scale / 1e3
        for view in drawing.views:
            own = view.scale / 1e3 if view.title else scale
            middle = np.array(view.centre)
            place = (np.array(view.place) + middle) * scale - middle * own + [x, 0.0]
            _view(document.modelspace(), view, own, place)
        x += (SIZE[0] + 20.0) * scale
    text = io.StringIO()
    document.write(text)
    return written(f"999\n{GENERATOR}\n{text.getvalue()}", path, "a drawing", ENDINGS, force)


def _view(space: Any, view: View, scale: float, place: Any) -> None:
    """Draw the items of a view in true size [m]."""
    for item in view.items:
        if isinstance(item, Path):
            points = np.asarray(item.points) * scale + place
            space.add_lwpolyline(points.tolist(), close=item.closed, dxfattribs={"layer": item.style.replace(" ", "-")})
        elif isinstance(item, DimensionLine):
            a, b = (np.array(p) * scale + place for p in (item.a, item.b))
            along = item.way == "h"
            base = (a[0], item.at * scale + place[1]) if along else (item.at * scale + place[0], a[1])
            sizes = {"dimtxt": TEXT * scale, "dimtsz": 0.8 * scale, "dimexo": 0.8 * scale, "dimexe": 1.2 * scale,
                     "dimgap": 0.7 * scale, "dimlfac": 1.0, "dimdec": 2, "dimzin": 0, "dimtad": 1}  # fmt: skip
            kind = {"layer": "dimension"}
            words = f"{item.words.partition(' ')[0]} <>" if " " in item.words else "<>"
            space.add_linear_dim(
                base=base, p1=a, p2=b, angle=0 if along else 90, text=words, override=sizes, dxfattribs=kind
            ).render()
        else:
            from ezdxf.enums import TextEntityAlignment as Align

            align = {"start": Align.LEFT, "middle": Align.CENTER, "end": Align.RIGHT}[item.anchor]
            at = (np.array(item.at) * scale + place).tolist()
            made = space.add_text(
                item.words, height=item.size * scale, rotation=item.angle, dxfattribs={"layer": "text"}
            )
            made.set_placement(at, align=align)
