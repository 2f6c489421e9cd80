"""Commands about a recording: info, plot, view, report, compare, export, recover, trace, layout."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app
from heavylift.kernel.errors import RecordingError

if TYPE_CHECKING:
    from heavylift.recordings import Recording
    from heavylift.recordings.read.verdict import RecordedVerdict


@app.command()
def info(file: o.File, as_json: o.Json = False) -> None:
    """Print what a recording contains.    heavylift info turnover.mcap"""
    from heavylift.recordings import Recording, info as describe, info_data

    rec = Recording(file)
    found = _verdict(rec)
    typer.echo(msgspec.json.encode(info_data(rec, found)).decode() if as_json else describe(rec, found))
    if rec.complaints:
        raise typer.Exit(1)


@app.command()
def plot(
    file: o.File,
    signals: Annotated[
        list[str] | None,
        typer.Argument(help="signals or patterns, such as 'rope/tension/west.*', default tensions; a second recording"),
    ] = None,
    output: Annotated[Path | None, o.written_to("figure: .png, .svg, .html to zoom, or .gif of the lift")] = None,
    lift: Annotated[bool, typer.Option("--lift", help="the lift itself at some instants; as .gif a film")] = False,
    force: o.Force = False,
) -> None:
    """Draw signals, limits and stages.    heavylift plot turnover.mcap 'rope/tension/*' 'pose/block/?' -o x.html

    A second recording is drawn over the first: heavylift plot lift.mcap slower.mcap 'rope/tension/*'
    """
    from heavylift.recordings import Recording, curves, overlay, plot as tensions, storyboard
    from heavylift.recordings.write.outputs import beside

    out = output or beside(file, "-lift.png" if lift else "-signals.png" if signals else ".png")
    others, signals = _apart(file, signals or [])
    if others and lift:
        raise RecordingError(f"{others[0]}: --lift draws one recording; leave the second one out")
    if others:
        out = overlay(file, others[0], out, signals, force)
    elif lift:
        out = storyboard(file, out, force=force)
    elif signals or out.suffix.lower() == ".html":
        out = curves(file, signals or [], out, force)
    else:
        from heavylift.coordinator.record.scene import at_rest  # with all that runs

        rec = Recording(file)
        out = tensions(rec, out, force=force, rest=at_rest(rec))
    typer.echo(f"wrote {out}")


@app.command()
def view(
    file: o.File,
    other: Annotated[
        Path | None, typer.Argument(help="another recording, shown beside it", autocompletion=o.recording_files)
    ] = None,
    output: Annotated[Path | None, o.written_to("page; default NAME.html")] = None,
    force: o.Force = False,
) -> None:
    """Write one page with the lift in 3D, signals, stages, events.    heavylift view turnover.mcap

    A second recording is shown beside the first, as transparent bodies and dashed curves.
    """
    from heavylift.recordings import Recording, view as write
    from heavylift.recordings.write.outputs import beside

    out = write(file, output or beside(file, ".html"), _verdict(Recording(file)), force, other)
    typer.echo(f"wrote {out}; open it in a browser")


@app.command()
def report(
    file: o.File,
    other: Annotated[
        Path | None, typer.Argument(help="an alternative, shown beside it", autocompletion=o.recording_files)
    ] = None,
    output: Annotated[
        Path | None, o.written_to("document: .html, .pdf, .xlsx, .json, .txt; drawings: .dxf; default NAME-report.html")
    ] = None,
    revision: Annotated[str, typer.Option("--revision", help="of the document, instead of the scene's")] = "",
    author: Annotated[str, typer.Option("--author", help="who prepared it, instead of the scene's")] = "",
    force: o.Force = False,
    as_json: o.Json = False,
) -> None:
    """Write the planner's document: verdict, tables, drawings.    heavylift report turnover.mcap -o run.pdf

    A second recording is compared with the first: heavylift report lift.mcap slower.mcap
    """
    from heavylift.recordings import Recording, report as write
    from heavylift.recordings.documents import alternatives, facts, report_sheet
    from heavylift.recordings.read.verdict import as_recorded, complaints
    from heavylift.recordings.sheets.sheet import data_of
    from heavylift.recordings.sheets.workbook import FORMATS, write as write_sheet
    from heavylift.recordings.write.outputs import beside, output_path

    every = [Recording(path) for path in (file, other) if path is not None]
    verdicts, wrong = [_verdict(rec) for rec in every], [what for rec in every for what in complaints(rec)]
    given = {"revision": revision, "author": author}
    out = output or beside(file, "-report.html")
    if other is not None:
        out = output_path(out, "a report", FORMATS)
        drawn = out.suffix.lower() in (".html", ".pdf") and (output is not None or not as_json)
        one, second = map(facts, every, verdicts)
        found = alternatives(one, second, drawn)
    elif as_json:
        found = report_sheet(every[0], verdicts[0], False, **given)
    if as_json:
        more = {"verdict": verdicts[0], "wrong": wrong, "as_recorded": as_recorded(every[0])}
        typer.echo(msgspec.json.encode({**data_of(found), **more}).decode())
    if output is not None or not as_json:
        if other is not None:
            out = write_sheet(found, out, "a report", force)
        else:
            out = write(every[0], out, verdicts[0], force, **given)
        opened = "; open it in a browser" if out.suffix == ".html" else ""
        typer.echo(f"wrote {out}{opened}", err=as_json)
    if wrong:
        typer.echo("\n".join(f"heavylift: {what}" for what in wrong), err=True)
        raise typer.Exit(1)


def _apart(file: Path, given: list[str]) -> tuple[list[Path], list[str]]:
    """Split arguments into recordings to compare with (at most one) and names of signals."""
    others = [Path(x) for x in given if x.endswith(".mcap")]
    if len(others) > 1:
        raise RecordingError(
            f"{file}: can be compared with only one other recording, not with {len(others)}; compare them in pairs"
        )
    return others, [x for x in given if not x.endswith(".mcap")]


def _verdict(rec: Recording) -> RecordedVerdict | None:
    """Return the recorded verdict, or one computed from the recorded data."""
    from heavylift.coordinator.verdict import verdict_of

    return verdict_of(rec)


@app.command()
def compare(
    context: typer.Context,
    a: o.File,
    b: o.File,
    signals: Annotated[
        list[str] | None, typer.Argument(help="signals or patterns to draw; default those that differ most")
    ] = None,
    output: Annotated[Path | None, o.written_to("figure of both over one another: .png, .svg, .html")] = None,
    force: o.Force = False,
    as_json: o.Json = False,
) -> None:
    """Compare two runs: equal (exit code 0), or first difference (1).    heavylift compare a.mcap b.mcap

    Of two yard files: their dates and waits side by side, and by how much the second is later.
    """
    if o.yard_file(context, str(a), {"output", "force"}):
        from heavylift.coordinator.supervision.pool import Pool, cores

        with Pool(cores()) as pool:
            o.tell_study(o.study_of(str(a), [], 100, executor=pool).beside(str(b)), output, force, as_json)
        return
    from heavylift.recordings import compare as side_by_side, overlay

    found = side_by_side(a, b)
    if output is not None:
        typer.echo(f"wrote {overlay(a, b, output, signals or [], force)}", err=True)
    typer.echo(msgspec.json.encode(found, enc_hook=str).decode() if as_json else str(found))
    if not found.equal:
        raise typer.Exit(1)


@app.command()
def export(
    file: o.File,
    output: Annotated[Path, o.written_to("table, .csv or .parquet")],
    signals: Annotated[
        list[str] | None, typer.Option("--signal", help="signal or pattern, such as 'rope/tension/*'; default all")
    ] = None,
    force: o.Force = False,
) -> None:
    """Write signals as a table with units in the column names.    heavylift export turnover.mcap -o turnover.csv"""
    from heavylift.recordings import export as write

    typer.echo(f"wrote {write(file, output, signals or [], force)}")


@app.command()
def recover(
    file: Annotated[
        Path,
        typer.Argument(help="a cut-off or damaged recording (.mcap or .mcap.part)", autocompletion=o.recording_files),
    ],
    output: Annotated[Path | None, o.written_to("default NAME-recovered.mcap")] = None,
    force: o.Force = False,
) -> None:
    """Recover what a killed run has recorded.    heavylift recover turnover.mcap.part"""
    from heavylift.recordings import recover as save

    found = save(file, output, force)
    typer.echo(f"wrote {found.path}: {found}")


@app.command()
def trace(
    file: o.File,
    perfetto: Annotated[Path | None, typer.Option("--perfetto", help="file for ui.perfetto.dev, .json")] = None,
    force: o.Force = False,
    as_json: o.Json = False,
) -> None:
    """Print where the wall-clock time of a run went.    heavylift trace turnover.mcap --perfetto trace.json"""
    from heavylift.coordinator.trace import Timeline, data, text, trace_events
    from heavylift.recordings.write.partfile import written

    timeline = Timeline(file)
    if perfetto is not None:
        perfetto = written(json.dumps(trace_events(timeline)), perfetto, "a trace", (".json",), force)
    typer.echo(json.dumps(data(timeline)) if as_json else text(timeline))
    if perfetto is not None and not as_json:
        typer.echo(f"\nwrote {perfetto}; open it at ui.perfetto.dev")


@app.command()
def layout(
    file: o.File,
    output: Annotated[Path | None, o.written_to("default NAME-lichtblick.json")] = None,
    force: o.Force = False,
) -> None:
    """Write the layout stored in a recording, for Lichtblick or Foxglove.    heavylift layout turnover.mcap"""
    from heavylift.recordings import Recording
    from heavylift.recordings.render.foxglove import LAYOUT
    from heavylift.recordings.write.outputs import beside
    from heavylift.recordings.write.partfile import written

    found = Recording(file).attachments.get(LAYOUT)
    if found is None:
        raise RecordingError(f"{file}: has no layout attached; record the scene with `heavylift run`")
    path = written(found, output or beside(file, "-lichtblick.json"), "a layout", (".json",), force)
    typer.echo(f"wrote {path}; in Lichtblick: import this layout, then open {file}")
