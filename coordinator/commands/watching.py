"""Commands about a run that goes on: watch."""

from __future__ import annotations

from typing import Annotated

import typer
from heavylift.coordinator.commands.common.app import Json, Run, app


@app.command()
def watch(
    run: Run = "",
    topics: Annotated[
        str, typer.Option("--topics", help="events of this source.port only, such as 'west.*' or '*.stage'")
    ] = "*",
    as_json: Json = False,
) -> None:
    """Print the events of a run, those so far and then each as it happens.    heavylift watch turnover.mcap"""
    from fnmatch import fnmatchcase

    import msgspec
    from heavylift.coordinator.live import find, observe
    from heavylift.coordinator.live.line import Lines
    from heavylift.kernel.errors import ProtocolError

    found = find(run)
    lines, observer = Lines(found.notice), observe(found)
    for number, event in observer:
        wanted = fnmatchcase(f"{event.source}.{event.port}", topics)
        if not wanted:
            lines.of(event)
        elif as_json:
            stage, value = lines.of(event)
            told = {"number": number, "t_ns": event.t, "microstep": event.k, "stage": stage}
            told |= {"source": event.source, "port": event.port, "index": event.index, "type": event.type}
            typer.echo(msgspec.json.encode({**told, "value": value}))
        else:
            typer.echo(lines.text(event))
    ended = observer.ended
    if as_json:
        typer.echo(msgspec.json.encode({"ended": ended}))
    elif ended.status == "finished":
        typer.echo(f"finished at {ended.sim_s:.6f} s")
    if ended.status != "finished":
        raise ProtocolError(f"the run has failed at {ended.sim_s:.6f} s: {ended.reason}")
