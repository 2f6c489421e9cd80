"""`heavylift trace`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .app import File, Json, app


@app.command()
def trace(
    file: File,
    perfetto: Annotated[Path | None, typer.Option("--perfetto", help="file for ui.perfetto.dev, .json")] = None,
    as_json: Json = False,
) -> None:
    """Show who worked and who waited for whom in a run.    heavylift trace turnover.mcap --perfetto trace.json"""
    import json

    from heavylift.kernel.errors import RecordingError

    from ..trace import Timeline, data, text, trace_events

    timeline = Timeline(file)
    if perfetto is not None:
        try:
            perfetto.write_text(json.dumps(trace_events(timeline)))
        except OSError as error:
            raise RecordingError(f"{perfetto}: cannot be written ({error.strerror}); give another path") from None
    typer.echo(json.dumps(data(timeline)) if as_json else text(timeline))
    if perfetto is not None and not as_json:
        typer.echo(f"\nwrote {perfetto}; open it at ui.perfetto.dev")
