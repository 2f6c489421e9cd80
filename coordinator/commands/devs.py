"""`heavylift devs`: any DEVS model, distributed."""

from __future__ import annotations

import os
import sys
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Annotated

import typer
from heavylift.coordinator.commands.common.app import Force, Json, app


@app.command()
def devs(
    model: Annotated[str, typer.Argument(help="module:function or file.py:function that returns a Coupled")],
    until: Annotated[str, typer.Option("--until", help="end of simulation: --until 10s; default no activity")] = "",
    output: Annotated[Path | None, typer.Option("-o", "--output", help="recording; default none")] = None,
    force: Force = False,
    processes: Annotated[int, typer.Option("--processes", help="deal the nodes out over so many processes")] = 0,
    in_process: Annotated[bool, typer.Option("--in-process", help="all models in this process")] = False,
    microsteps: Annotated[int, typer.Option("--microsteps", help="so many steps in no time are a loop")] = 10_000,
    deadline: Annotated[str, typer.Option("--deadline", help="for a process to show progress")] = "60 s",
    as_json: Json = False,
) -> None:
    """Run a DEVS model, each child a process.    heavylift devs my_models:build --until 10s -o run.mcap"""
    import dataclasses
    import json

    from heavylift.coordinator.run.models import run_models
    from heavylift.coordinator.run.watch import Watch
    from heavylift.coordinator.transport.printable import printable
    from heavylift.kernel.errors import ModelError
    from heavylift.nodes.devs import NEVER, ns
    from heavylift.nodes.scene.text.units import TIME

    from .running import patience_s

    if PathFinder.find_spec(model.partition(":")[0].partition(".")[0], [os.getcwd()]):
        sys.path.append(os.getcwd())  # a module in the folder where the user stands; what is installed comes first
    try:
        end = ns(TIME.read(until)) if until else NEVER
    except ValueError as error:
        raise ModelError(f"--until: {error}") from None
    patience = patience_s(deadline)

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
