"""The parts of `heavylift run` that print a sheet: runs of a yard file, and of a scene for many seeds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer
from heavylift.coordinator.commands.common import options as o

if TYPE_CHECKING:
    from heavylift.nodes.scene import LoadedScene


def run_seeds(
    context: typer.Context, scene: LoadedScene, count: int, seed: int, report: list[Path] | None, force: bool,
    strict: bool, fail_on: str, as_json: bool,
) -> None:  # fmt: skip
    """Run a scene for many random seeds, then print and report the verdict on the quantiles of its results."""
    from heavylift.coordinator.sweeps.seeds import replicated
    from heavylift.recordings.sheets.workbook import write

    for parameter in o.given(context):
        if parameter.name not in {*o.BOTH, "replications", "seed", "report", "force", "accuracy"}:
            raise typer.BadParameter(f"{parameter.opts[0]} is for a single run; leave it or --replications out")
    sheet = replicated(scene, count, seed).sheet(scene.plan.name)
    o.tell(sheet, as_json)
    for path in report or ():
        typer.echo(f"wrote {write(sheet, path, 'a report', force)}", err=True)
    o.end_by(strict, fail_on, sheet.state)


def run_yard_file(
    file: str, output: Path | None, force: bool, sets: list[str] | None, in_process: bool, processes: int,
    replications: int, seed: int, report: list[Path] | None, strict: bool, fail_on: str, as_json: bool,
) -> None:  # fmt: skip
    """Run a yard file; print its results, and write those that the options request."""
    from heavylift.coordinator.yards.running import run_yard
    from heavylift.nodes.yard.exchange import FORMATS
    from heavylift.recordings.sheets.workbook import write

    exports = [path for path in report or () if path.suffix.lower() in FORMATS]
    if replications and exports:
        raise typer.BadParameter("replications do not have a single schedule to export; leave out --replications")
    if replications and (output or in_process):
        raise typer.BadParameter("replications are not recorded and use all cores; leave out -o and --in-process")
    recording = None if replications else output or Path(f"{Path(file).stem}.mcap")
    count = 0 if processes == o.AUTO else processes
    drawn = bool(report) and not replications
    runs = replications, seed, exports, drawn
    sheet, made = run_yard(file, sets or [], recording, in_process, count, force, *runs)
    o.tell(sheet, as_json)
    for path in report or ():
        done = path if path in exports else write(sheet, path, "a report", force)
        typer.echo(f"wrote {done}", err=True)
    if made:
        typer.echo(f"wrote {made.recording}\ndigest {made.digest}", err=True)
    o.end_by(strict, fail_on, sheet.state)
