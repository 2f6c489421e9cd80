"""Commands to a run that goes on: pause, step, continue, command, stop."""

from __future__ import annotations

from typing import Annotated

import typer

from . import completing
from .app import Run, app

__all__: list[str] = []


@app.command()
def pause(run: Run = "") -> None:
    """Pause a run: all before that time is done, nothing at it.    heavylift pause turnover.mcap"""
    _order(run, "pause")


@app.command("continue")
def continue_(run: Run = "") -> None:
    """Let a paused run go on.    heavylift continue turnover.mcap"""
    _order(run, "continue")


@app.command()
def step(
    run: Run = "",
    by: Annotated[str, typer.Option("--by", help="simulated time, such as '500 ms'")] = "1 s",
    event: Annotated[bool, typer.Option("--event", help="to the next event")] = False,
) -> None:
    """Let a run go on for a while and pause it again.    heavylift step turnover.mcap --by 1s"""
    from heavylift.kernel.errors import ProtocolError
    from heavylift.nodes.devs import ns
    from heavylift.nodes.scene.units import DURATION

    try:
        length = DURATION.read(by)
    except ValueError as error:
        raise ProtocolError(f"--by: {error}") from None
    if length <= 0.0:
        raise ProtocolError(f"--by {by}: a step is longer than zero")
    _order(run, "step", None if event else ns(length))


@app.command()
def command(
    run: Annotated[
        str,
        typer.Argument(help="the recording that it writes, its run id, or its scene", autocompletion=completing.runs),
    ],
    words: Annotated[str, typer.Argument(help="target: what to do, as in the action list of a scene")],
) -> None:
    """Give an order, as soon as may be.    heavylift command lift "crane H1: hoist 3 m/min by 1 m" """
    _order(run, "command", text=words)


@app.command()
def stop(run: Run = "") -> None:
    """End a run in order; its recording is whole.    heavylift stop turnover.mcap"""
    _order(run, "stop")


def _order(run: str, do: str, by_ns: int | None = None, text: str = "") -> None:
    import msgspec

    from ..live.orders import Order, order

    typer.echo(order(run, msgspec.convert({"do": do, "by_ns": by_ns, "text": text}, Order)))
