"""`heavylift trace`."""

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
    from heavylift.recordings.write.partfile import written

    timeline = Timeline(file)
    if perfetto is not None:
        perfetto = written(json.dumps(trace_events(timeline)), perfetto, "a trace", (".json",), force)
    typer.echo(json.dumps(data(timeline)) if as_json else text(timeline))
    if perfetto is not None and not as_json:
        typer.echo(f"\nwrote {perfetto}; open it at ui.perfetto.dev")
