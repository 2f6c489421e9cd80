"""Commands about a recording: info, plot, view, report, compare, export, recover."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .app import File, app


@app.command()
def info(file: File) -> None:
    """Say what a recording holds.    heavylift info turnover.mcap"""
    from heavylift.recordings import info as describe

    typer.echo(describe(file))


@app.command()
def plot(
    file: File,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="picture, .png or .svg")] = None,
    lift: Annotated[bool, typer.Option("--lift", help="the lift itself at some instants")] = False,
) -> None:
    """Draw the rope tensions of a recording.    heavylift plot turnover.mcap -o tension.svg"""
    from heavylift.recordings import plot as tensions
    from heavylift.recordings import storyboard

    draw = storyboard if lift else tensions
    typer.echo(f"wrote {draw(file, output or file.with_suffix('.png'))}")


@app.command()
def view(
    file: File,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="page; default NAME.html")] = None,
) -> None:
    """Write one page with the lift in 3D, signals, stages, events.    heavylift view turnover.mcap"""
    from heavylift.recordings import view as write

    typer.echo(f"wrote {write(file, output or file.with_suffix('.html'))}; open it in a browser")


@app.command()
def report(
    file: File,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="document; default NAME-report.html")] = None,
) -> None:
    """Write the planner's document: ropes, cranes, stages, warnings.    heavylift report turnover.mcap"""
    from heavylift.recordings import report as write

    typer.echo(f"wrote {write(file, output or file.with_name(file.stem + '-report.html'))}; open it in a browser")


@app.command()
def compare(
    a: File,
    b: File,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object")] = False,
) -> None:
    """Say whether two runs are equal (exit code 0) or where they part (1).    heavylift compare a.mcap b.mcap"""
    import msgspec
    from heavylift.recordings import compare as side_by_side

    found = side_by_side(a, b)
    typer.echo(msgspec.json.encode(found, enc_hook=str).decode() if as_json else str(found))
    if not found.equal:
        raise typer.Exit(1)


@app.command()
def export(
    file: File,
    output: Annotated[Path, typer.Option("-o", "--output", help="table, .csv or .parquet")],
    signals: Annotated[
        list[str] | None, typer.Option("--signal", help="signal or pattern, such as 'rope/tension/*'; default all")
    ] = None,
) -> None:
    """Write signals as a table, units in the names.    heavylift export turnover.mcap -o turnover.csv"""
    from heavylift.recordings import export as write

    typer.echo(f"wrote {write(file, output, signals or [])}")


@app.command()
def recover(
    file: Annotated[Path, typer.Argument(help="a cut-off or damaged recording (.mcap or .mcap.part)")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="default NAME-recovered.mcap")] = None,
) -> None:
    """Save what a killed run has left.    heavylift recover turnover.mcap.part"""
    from heavylift.recordings import recover as save

    found = save(file, output)
    typer.echo(f"wrote {found.path}: {found}")
