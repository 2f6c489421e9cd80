"""Drawings as DXF, in metres: each view in its true size, with real dimensions; the drawings beside each other.

Paper is at the scale of plan and elevation; the rigging sketch is drawn in its own true size beside them.
"""

import io
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from heavylift.kernel.errors import RecordingError, extra
from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.verdict import Judged
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .ink import TEXT, DimensionLine, Path, View
from .sheets import SIZE, drawn

ENDINGS = (".dxf",)
COLOURS = {"crane": 8, "block": 30, "deck": 32, "hook": 250, "frame": 130, "world": 9, "rope": 7, "thin": 8, "axis": 8,
           "near": 1, "frame line": 7, "dimension": 7, "text": 7}  # fmt: skip
METRES = 6  # $INSUNITS


def write(
    rec: Recording, out: str | FilePath, verdict: Judged | None, project: Mapping[str, str], force: bool = False
) -> FilePath:
    """Write the drawings of a recording to a .dxf file; RecordingError if the library for it is not installed, or
    nothing hangs on hooks."""
    path = output_path(out, "a drawing", ENDINGS)
    missing = "drawings as DXF need ezdxf: pip install 'heavylift[drawings]'; or write the report as .html or .pdf"
    library: Any = extra("ezdxf", RecordingError(missing))
    found = drawn(rec, verdict, project)
    if not found:
        raise RecordingError(f"{rec.path}: nothing hangs on a hook, so there is nothing to draw")
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
    """The items of a view at their true size [m]."""
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
