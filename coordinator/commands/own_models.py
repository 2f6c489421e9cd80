"""Models of your own: `heavylift devs` runs any DEVS model, `heavylift trust` lets Python code of a folder run."""

from __future__ import annotations

import os
import sys
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Annotated

import typer
from heavylift.coordinator.commands.common.app import (
    Deadline,
    Force,
    InProcess,
    Json,
    Processes,
    app,
    deadline_s,
    quantity,
    written_to,
)


@app.command()
def devs(
    model: Annotated[str, typer.Argument(help="module:function or file.py:function that returns a Coupled")],
    until: Annotated[str, typer.Option("--until", help="end of simulation: --until 10s; default no activity")] = "",
    output: Annotated[Path | None, written_to("recording; default none")] = None,
    force: Force = False,
    processes: Processes = 0,
    in_process: InProcess = False,
    microsteps: Annotated[int, typer.Option("--microsteps", help="so many steps in no time are a loop")] = 10_000,
    deadline: Deadline = "60 s",
    as_json: Json = False,
) -> None:
    """Run a DEVS model, each child a process.    heavylift devs my_models:build --until 10s -o run.mcap"""
    import dataclasses
    import json

    from heavylift.coordinator.run.models import run_models
    from heavylift.coordinator.run.watch import Watch
    from heavylift.coordinator.transport.printable import printable
    from heavylift.nodes.devs import NEVER, ns
    from heavylift.nodes.scene.text.units import TIME

    if PathFinder.find_spec(model.partition(":")[0].partition(".")[0], [os.getcwd()]):
        sys.path.append(os.getcwd())  # a module in the folder where the user stands; what is installed comes first
    end = ns(quantity("--until", until, TIME)) if until else NEVER
    patience = deadline_s(deadline)

    class Aloud(Watch):
        def say(self, sentence: str) -> None:
            print(printable(sentence), file=sys.stderr)

    run = run_models(
        model, end, output, in_process, None, Aloud(), None, processes, microsteps, force, deadline=patience
    )
    if as_json:
        recording = str(run.recording) if run.recording else None
        told = {**dataclasses.asdict(run), "outcome": run.outcome.name.lower(), "recording": recording}
        typer.echo(json.dumps(told))
        return
    typer.echo(f"ended at {run.sim_s:g} s because {run.outcome.value}")
    typer.echo(f"{run.grants} grants in {run.wall_s:.2f} s\ndigest {run.digest}")
    if run.recording is not None:
        typer.echo(f"wrote {run.recording}")


@app.command()
def trust(
    folder: Annotated[Path | None, typer.Argument(help="folder with Python code; default: list those trusted")] = None,
    withdraw: Annotated[bool, typer.Option("--withdraw", help="trust it no longer")] = False,
    listed: Annotated[bool, typer.Option("--list", help="list the trusted folders")] = False,
) -> None:
    """Let Python code of a folder run when a scene or recording names it.    heavylift trust my_laws"""
    from heavylift.kernel import trust as kept

    if folder is not None:
        if withdraw:
            typer.echo(f"no longer trusted: {kept.withdraw(folder)}", err=True)
        else:
            typer.echo(f"trusted: {kept.trust(folder)}; `heavylift trust --withdraw` takes it back", err=True)
    elif withdraw:
        raise typer.BadParameter("say which folder to trust no longer")
    if listed or folder is None:
        for each in kept.trusted():
            typer.echo(each)
