"""Any signals of recordings as curves over time: a panel per unit, rated values as limits, stages shaded.

`curves("run.mcap", ["rope/tension/*", "joint/position/west.*"], "run.html")`; the suffix decides: .png or .svg are
pictures, .html is a page with zoom and cursor that needs no network.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from heavylift.kernel.errors import RecordingError
from heavylift.recordings.format.samples import MEASURED
from heavylift.recordings.format.settings import settings
from heavylift.recordings.read.export import matching
from heavylift.recordings.read.port_series import said, silent
from heavylift.recordings.read.reader import Recording
from heavylift.recordings.read.signal import titles
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import written

from .curves_drawn import Curve, Figure, Panel, page, picture
from .paper import FORMATS

LARGER = {"N": (1e-3, "kN"), "N m": (1e-3, "kN m"), "J": (1e-6, "MJ")}
PANELS = 16  # in one figure
MANY = 60  # curves: more than that nobody can tell apart


def curves(path: str | Path, patterns: Sequence[str], out: str | Path, force: bool = False) -> Path:
    """Draw the columns that match one of the patterns (tensions without one) into a .png, .svg or .html file; of a DEVS
    run what its ports said."""
    out = checked(out)
    rec = Recording(path)
    with rec.reading():
        chosen = "; ".join(settings(rec.run).values())
        title = f"{rec.run.get('scene', rec.run.get('model', ''))}, {rec.path.name}" + (f"\n{chosen}" if chosen else "")
        panels = _of_ports(rec, patterns) if silent(rec) else panels_of(rec, patterns or ["rope/tension/*"])
        figure = Figure(title, panels, rec.stages())
        return drawn(figure, out, force)


def checked(out: str | Path) -> Path:
    """The path if curves can be written there."""
    return output_path(out, "a figure", (*FORMATS, ".html"))


def drawn(figure: Figure, out: Path, force: bool = False) -> Path:
    """Write the figure in the form that the suffix asks for."""
    if out.suffix.lower() != ".html":
        return picture(figure, out, force)
    return written(page(figure), out, "a figure", (*FORMATS, ".html"), force)


def panels_of(rec: Recording, patterns: Sequence[str]) -> list[Panel]:
    """The columns that match, and what was measured of them, by unit, with the rated values of ropes as limits."""
    wanted = matching(rec, patterns)
    measured = [(MEASURED + name, column) for name, column in wanted if MEASURED + name in rec.signals()]
    wanted += [x for x in measured if x not in wanted and x[1] in rec.columns(x[0])]
    if len(wanted) > MANY:
        raise RecordingError(
            f"{rec.path}: {len(wanted)} curves in one figure; name fewer, such as 'rope/tension/west.*'"
        )
    rec.load([*dict.fromkeys(name for name, _ in wanted)])
    rated = rec.fact("rated", {})
    panels: dict[str, Panel] = {}
    for name, column in wanted:
        signal = rec.signal(name)
        title = titles(signal)[signal.names.index(column)]
        factor, unit = larger(title[len(column) + 2 : -1])
        panel = panels.setdefault(unit, Panel(unit, []))
        model = next((c for c in panel.curves if f"{MEASURED}{c.name}" == f"{name}/{column}"), None)
        colour = model.colour if model else len(panel.curves)
        panel.curves.append(Curve(f"{name}/{column}", signal.t, signal[column] * factor, colour, model is not None))
        if name in ("rope/tension", "rope/peak") and column in rated:
            panel.limits[column] = rated[column] * factor
    if not any(len(curve.t) > 1 for panel in panels.values() for curve in panel.curves):
        raise RecordingError(f"{rec.path}: has no samples to draw; let the run last longer")
    return list(panels.values())


def _of_ports(rec: Recording, patterns: Sequence[str]) -> list[Panel]:
    """What ports of a DEVS run said, each in a panel of its own."""
    found = said(rec, patterns)
    if not found:
        raise RecordingError(f"{rec.path}: has no events to draw; let the run last longer")
    if len(found) > PANELS:
        named = ", ".join(f"'{x.name}'" for x in found[:2])
        raise RecordingError(f"{rec.path}: {len(found)} ports in one figure; name some of them, such as {named}")
    return [
        Panel("", [Curve(c, x.t, x[c], i, spoken=True) for i, c in enumerate(x.names)], title=x.name) for x in found
    ]


def larger(unit: str) -> tuple[float, str]:
    """Factor and unit in which people read these numbers."""
    return LARGER.get(unit, (1.0, unit))
