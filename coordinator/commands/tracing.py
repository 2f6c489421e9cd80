"""`heavylift trace`, where the time of a run went, and `heavylift measured`, a real lift beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from heavylift.coordinator.commands.common.app import File, Force, Json, app


@app.command()
def trace(
    file: File,
    perfetto: Annotated[Path | None, typer.Option("--perfetto", help="file for ui.perfetto.dev, .json")] = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Show who worked and who waited for whom in a run.    heavylift trace turnover.mcap --perfetto trace.json"""
    import json

    from heavylift.coordinator.trace import Timeline, data, text, trace_events
    from heavylift.recordings.write.partfile import PartFile

    timeline = Timeline(file)
    if perfetto is not None:
        with PartFile(perfetto, "a trace", (".json",), force) as written:
            written.stream.write(json.dumps(trace_events(timeline)).encode())
        perfetto = written.path
    typer.echo(json.dumps(data(timeline)) if as_json else text(timeline))
    if perfetto is not None and not as_json:
        typer.echo(f"\nwrote {perfetto}; open it at ui.perfetto.dev")


@app.command()
def measured(
    file: File,
    log: Annotated[Path, typer.Argument(help="log of the real lift, .csv")],
    maps: Annotated[
        list[str] | None,
        typer.Option("--map", help="map.yaml, or 'cell_H1=rope/tension/west.H1 [kN] +- 5 kN' (95 %)"),
    ] = None,
    offset: Annotated[str, typer.Option("--offset", help="time 0 of the log in the run; default estimated")] = "",
    estimate: Annotated[
        list[str] | None, typer.Option("--estimate", help="input of the scene to fit: block.mass, block.com.x, ...")
    ] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="default NAME-measured.mcap")] = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Put a real lift beside its run; estimate inputs.    heavylift measured lift.mcap log.csv --map map.yaml

    Writes a new recording with the channels of the log beside the run's, which plot, view and report draw dashed. For
    each: E = run - log and its uncertainty u_val, 95 %, after ASME V&V 20. --estimate fits inputs of the scene, names
    those that the log does not tell, and writes the others into a scene beside the recording.
    """
    import json

    from heavylift.coordinator.measured.measuring import measure
    from heavylift.kernel.errors import RecordingError
    from heavylift.nodes.scene.text.units import TIME

    try:
        given = TIME.read(offset) if offset else None
    except ValueError as error:
        raise RecordingError(f"--offset '{offset}': {error}") from None
    if not maps:
        raise RecordingError(
            f"{log}: say which column is which channel, such as --map 'cell=rope/tension/west.H1 [kN]'"
        )
    found = measure(
        file, log, maps, given, estimate or [], output, force, lambda told: typer.echo(f"  {told}", err=True)
    )
    typer.echo(json.dumps(found.data()) if as_json else "\n".join(found.told))
    if not as_json:
        typer.echo(f"wrote {found.recording}" + (f" and {found.scene}" if found.scene else ""))
