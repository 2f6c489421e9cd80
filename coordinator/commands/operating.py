"""Commands for a run in progress: watch, pause, step, continue, command, stop."""

import json
from typing import Annotated

import msgspec
import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app
from heavylift.kernel.errors import ProtocolError


@app.command()
def watch(
    run: o.Run = "",
    topics: Annotated[
        str, typer.Option("--topics", help="messages of this source.port, such as 'west.*'; '*' for all")
    ] = "",
    as_json: o.Json = False,
    ticket: Annotated[
        bool, typer.Option("--ticket", help="print the settings with which any Zenoh program can watch instead")
    ] = False,
) -> None:
    """Print stages, loads and landings of a run as they happen.    heavylift watch turnover.mcap"""
    from fnmatch import fnmatchcase

    from heavylift.coordinator.live import find, observe
    from heavylift.coordinator.live.observers import Lines
    from heavylift.kernel.description.findings import clock

    found = find(run)
    if ticket:
        from heavylift.coordinator.transport.session import observer_config

        typer.echo(
            msgspec.json.format(msgspec.json.encode(observer_config(found.directory, found.notice.run)).decode())
        )
        return
    lines, observer = Lines(found.notice), observe(found)
    for number, event in observer:
        if not (topics or as_json):
            if line := lines.report(event):
                typer.echo(line)
        elif not fnmatchcase(f"{event.source}.{event.port}", topics or "*"):
            lines.of(event)
        elif as_json:
            stage, value = lines.of(event)
            row = {"number": number, "t_ns": event.t, "microstep": event.k, "stage": stage}
            row |= {"source": event.source, "port": event.port, "index": event.index, "type": event.type}
            typer.echo(msgspec.json.encode({**row, "value": value}).decode())
        else:
            typer.echo(lines.text(event))
    ended = observer.ended
    if as_json:
        typer.echo(msgspec.json.encode({"ended": ended}).decode())
    elif ended.status == "finished":
        typer.echo(f"finished at {clock(ended.sim_s, 1)}")
    if ended.status != "finished":
        raise ProtocolError(f"the run has failed at {ended.sim_s:.6f} s: {ended.reason}")


@app.command()
def pause(run: o.Run = "", as_json: o.Json = False) -> None:
    """Pause a run before its next event.    heavylift pause turnover.mcap"""
    _order(run, "pause", as_json)


@app.command("continue")
def continue_(run: o.Run = "", as_json: o.Json = False) -> None:
    """Continue a paused run.    heavylift continue turnover.mcap"""
    _order(run, "continue", as_json)


@app.command()
def step(
    run: o.Run = "",
    by: Annotated[str, typer.Option("--by", help="simulated time, such as '500 ms'")] = "1 s",
    event: Annotated[bool, typer.Option("--event", help="to the next event")] = False,
    as_json: o.Json = False,
) -> None:
    """Run for a simulated duration and pause again.    heavylift step turnover.mcap --by 1s"""
    from heavylift.nodes.devs import NEVER, seconds

    length = o.duration_s("--by", by)
    if length <= 0.0:
        raise ProtocolError(f"--by {by}: a step must be longer than zero")
    _order(run, "step", as_json, by_ns=None if event else max(1, min(seconds(length), NEVER)))


@app.command()
def command(
    run: Annotated[
        str, typer.Argument(help="the recording that it writes, its run id, or its scene", autocompletion=o.run_names)
    ],
    words: Annotated[str, typer.Argument(help="target: what to do, as in the action list of a scene")],
    wait: Annotated[
        str, typer.Option("--wait", help="for the answer, at most; 0: not while the run is paused")
    ] = "30 s",
    as_json: o.Json = False,
) -> None:
    """Give an order and print its result.    heavylift command lift "crane H1: hoist 3 m/min by 1 m" """
    from heavylift.coordinator.live.announce import PATIENCE_s

    patience = o.duration_s("--wait", wait)
    _order(run, "command", as_json, patience or PATIENCE_s, text=words, wait=patience > 0.0)


@app.command()
def stop(run: o.Run = "", as_json: o.Json = False) -> None:
    """End a run with a complete recording.    heavylift stop turnover.mcap"""
    _order(run, "stop", as_json)


def _order(run: str, do: str, as_json: bool, patience: float | None = None, **message: object) -> None:
    """Send an order to a run and print its reply; raises the error of a refusal."""
    from heavylift.coordinator.live.announce import PATIENCE_s, RunOrder, ask

    what = msgspec.convert({"do": do, **message}, RunOrder)
    answer = ask(run, what, patience or PATIENCE_s, lambda text: typer.echo(text, err=True))
    if as_json:
        at = {} if answer.t_ns is None else {"t_s": answer.t_ns / 1e9}
        typer.echo(json.dumps({"done": answer.done, "said": answer.said, **at}))
    if not answer.done:
        raise ProtocolError(answer.said)
    if not as_json:
        typer.echo(answer.said)
