"""`heavylift branch`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from heavylift.coordinator.commands.common.app import File, Force, Json, Sets, Strict, app, written_to


@app.command()
def branch(
    file: File,
    at: Annotated[str, typer.Option("--at", help="where: 'stage travel', 'end of stage travel', '120 s' or 2:00")],
    sets: Sets = None,
    edited: Annotated[str, typer.Option("--scene", help="an edited scene, in place of the one in the recording")] = "",
    output: Annotated[Path | None, written_to("recording; default NAME-branch.mcap")] = None,
    force: Force = False,
    strict: Strict = False,
    as_json: Json = False,
) -> None:
    """Run a recorded lift otherwise from some time on.    heavylift branch lift.mcap --at 'stage up' --set end='2 min'

    What if: up to there every event and sample must come again, else it is refused. The mechanics go on from the last
    checkpoint in the recording, or begin at the start where it has none for the changed scene.
    """
    from heavylift.coordinator.run.branch import Branch
    from heavylift.coordinator.run.branch import branch as simulate
    from heavylift.coordinator.run.progress import Progress, summary

    what = Branch.of(file, at, sets or [], edited or None)
    with Progress(what.scene.plan, as_json) as watch:
        result = simulate(what, output, watch, force)
    summary(what.scene.plan, result, as_json)
    if strict and result.verdict is not None and result.verdict.red:
        raise typer.Exit(1)
