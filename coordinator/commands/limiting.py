"""`heavylift limits`, `heavylift plan`: how far numbers of a scene may go, and how quick it can be."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app
from heavylift.kernel.errors import SceneError

if TYPE_CHECKING:
    from heavylift.coordinator.ladder.certificate import Certificate


@app.command()
def limits(
    scene: o.Scene,
    of: Annotated[list[str] | None, typer.Option("--of", help="'block.com.x', 'hoist accel', 'PATH=1..20 m'")] = None,
    every: Annotated[bool, typer.Option("--all", help="of all moves, usual and uncertain inputs")] = False,
    output: Annotated[Path | None, o.written_to("page with table and figure: limits.html")] = None,
    workers: Annotated[int, typer.Option("--workers", help="processes; default all cores")] = 0,
    limit: Annotated[str, typer.Option("--limit", help="wall time of a run")] = "60 s",
    sets: o.Sets = None,
    force: o.Force = False,
    as_json: o.Json = False,
) -> None:
    """Find how far a number may go before the verdict is red.    heavylift limits lift --of 'block.mass=300..900 t'

    The verdict is that of a run, the limit lies between its last green and its first red value. A number is one that
    --set takes, or 'hoist speed', 'trolley accel' and their like: of all such orders, in proportion. Exit code 1 where
    it is red at the start, never turns red, or is green again beyond; with --all only if it is red at the start.
    """
    from heavylift.coordinator.sweeps.limiting import askable, limits_of_all
    from heavylift.coordinator.sweeps.limits_page import limits_sheet, limits_table
    from heavylift.recordings.sheets.terminal import table_text
    from heavylift.recordings.sheets.writing import write

    if bool(of) == every:
        raise SceneError("limits: say --of 'block.mass=300..900 t', or --all")
    loaded, seconds = o.scene_of(scene, sets), o.wall_s("--limit", limit)
    found = limits_of_all(loaded, of or askable(loaded), seconds, workers, lambda text: typer.echo(text, err=True))
    if as_json:
        typer.echo(json.dumps([one.data() for one in found]))
    elif every:
        typer.echo(table_text(limits_table(found)))
    else:
        typer.echo("\n".join(map(str, found)))
    if output is not None:
        path = write(limits_sheet(loaded, found), output, "a table of limits", force)
        typer.echo(f"wrote {path}", err=as_json)
    if any(one.wrong for one in found) and (of or all(one.wrong for one in found)):
        raise typer.Exit(1)


@app.command()
def plan(
    scene: o.Scene,
    output: Annotated[Path | None, o.written_to("scene; default NAME-planned.yaml")] = None,
    force: o.Force = False,
    budget: Annotated[str, typer.Option("--budget", help="wall time of the search")] = "15 min",
    certify: Annotated[bool, typer.Option("--certify", help="tell how sure the figures of the new timing are")] = False,
    sets: o.Sets = None,
    as_json: o.Json = False,
) -> None:
    """Find the shortest timing within all limits, and write the scene with it.    heavylift plan lift

    Speeds of orders, ramps without swing, moves that begin while those before go on: first along the path at rest, then
    in runs, the last of which is green. Waits stay. Comments and layout of the scene are kept. Exit code 1 where it is
    red as it is written, or nothing is gained.
    """
    from heavylift.coordinator.sweeps.planning import planned
    from heavylift.recordings.write.outputs import output_path
    from heavylift.recordings.write.partfile import written

    loaded = o.scene_of(scene, sets)
    path = output_path(output or Path(f"{loaded.plan.name}-planned.yaml"), "a scene", (".yaml", ".yml"))
    found = planned(loaded, o.wall_s("--budget", budget), lambda told: typer.echo(f"  {told}", err=True))
    if found.after is None:
        typer.echo(json.dumps({"wrong": found.wrong}) if as_json else f"{loaded.plan.name}: {found.wrong}")
        raise typer.Exit(1)
    path = written(found.after.text, path, "a scene", (".yaml", ".yml"), force)
    sure = _certified(path) if certify else None
    if as_json:
        told = {**found.data(), "scene": str(path), "certified": sure.data() if sure else None}
        typer.echo(json.dumps(told))
        return
    typer.echo("\n".join([*found.told, *(sure.told if sure else []), f"wrote {path}"]))


def _certified(path: Path) -> Certificate:
    """Of a scene's run, whose recording is not kept."""
    from heavylift.coordinator.ladder.certificate import certifying
    from heavylift.coordinator.run.scene import run
    from heavylift.nodes.scene import load

    loaded = load(path)
    with tempfile.TemporaryDirectory(prefix="heavylift-") as folder, certifying(loaded) as found:
        typer.echo(f"  {found.price}", err=True)
        found.begin()
        recording = Path(folder) / "run.mcap"
        run(loaded, recording, in_process=True)
        return found.written(recording)
