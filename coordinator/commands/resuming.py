"""`heavylift resume`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from heavylift.coordinator.commands.common import completing
from heavylift.coordinator.commands.common.app import Force, Json, Strict, app


@app.command()
def resume(
    file: Annotated[
        Path,
        typer.Argument(
            help="a cut-off recording (.mcap.part), or one of a run that failed", autocompletion=completing.recordings
        ),
    ],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="default NAME-resumed.mcap")] = None,
    force: Force = False,
    strict: Strict = False,
    as_json: Json = False,
) -> None:
    """Run to its end what was cut off, checked against what was recorded.    heavylift resume lift.mcap.part"""
    from heavylift.coordinator.participants.participant import PRELOAD
    from heavylift.coordinator.supervision.processes import Processes

    with Processes(PRELOAD) as crew:
        from heavylift.coordinator.run.progress import Progress, summary
        from heavylift.coordinator.run.resume import Beginning
        from heavylift.coordinator.run.resume import resume as go_on

        begun = Beginning.of(file, crew.directory.path)
        with Progress(begun.scene.plan, as_json) as watch:
            result = go_on(file, begun, output, watch, crew, force=force)
    summary(begun.scene.plan, result, as_json)
    if strict and result.verdict is not None and result.verdict.red:
        raise typer.Exit(1)
