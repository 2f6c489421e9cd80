"""`heavylift measured`, `heavylift sensitivities`: a real lift beside its run; what uncertain inputs do to a run."""

import json
from pathlib import Path
from typing import Annotated

import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app

Inputs = Annotated[
    list[str] | None, typer.Option("--input", help="uncertainty of an input (95 %): 'block.mass +- 3 %'")
]


@app.command()
def sensitivities(scene: o.Scene, inputs: Inputs = None, sets: o.Sets = None, as_json: o.Json = False) -> None:
    """Find which uncertain input moves which peak most.    heavylift sensitivities lift --input 'block.mass +- 3 %'

    Inputs are uncertain as the scene states (mass: 480 t +- 3 %, 480 t sd 5 t, 460..500 t) or --input does. Each takes
    two runs, four where events switch; bars are at a level of 95 %, shares are those of their squares.
    """
    from heavylift.coordinator.ladder.sensitivities import sensitivities as find

    found = find(o.scene_of(scene, sets), inputs or [], say=lambda x: typer.echo(f"  {x}", err=True))
    typer.echo(json.dumps(found.data()) if as_json else str(found))


@app.command()
def measured(
    file: o.File,
    log: Annotated[Path, typer.Argument(help="log of the real lift, .csv")],
    maps: Annotated[
        list[str], typer.Option("--map", help="map.yaml, or 'cell_H1=rope/tension/west.H1 [kN] +- 5 kN' (95 %)")
    ],
    offset: Annotated[str, typer.Option("--offset", help="time 0 of the log in the run; default estimated")] = "",
    estimate: Annotated[
        list[str] | None, typer.Option("--estimate", help="input of the scene to fit: block.mass, block.com.x, ...")
    ] = None,
    inputs: Inputs = None,
    output: Annotated[Path | None, o.written_to("default NAME-measured.mcap")] = None,
    force: o.Force = False,
    as_json: o.Json = False,
) -> None:
    """Compare a measured log with its run, and estimate inputs.    heavylift measured lift.mcap log.csv --map map.yaml

    Writes a new recording with the channels of the log beside the run's, which plot, view and report draw dashed. For
    each: E = run - log and its uncertainty u_val, 95 %, after ASME V&V 20; the scene or --input says how uncertain
    inputs are, which takes two runs for each. --estimate fits inputs of the scene, names
    those that the log does not tell, and writes the others into a scene beside the recording.
    """
    from heavylift.coordinator.measured.measuring import measure
    from heavylift.nodes.scene.text.units import TIME

    given = o.quantity("--offset", offset, TIME) if offset else None
    wanted = estimate or [], inputs or []
    found = measure(file, log, maps, given, *wanted, output, force, lambda x: typer.echo(f"  {x}", err=True))
    typer.echo(json.dumps(found.data()) if as_json else "\n".join(found.message))
    if not as_json:
        typer.echo(f"wrote {found.recording}" + (f" and {found.scene}" if found.scene else ""))
