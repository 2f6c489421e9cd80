"""Commands about a scene that is not run: check, tree, equations, statics, modes."""

from __future__ import annotations

from typing import Annotated

import typer
from heavylift.coordinator.commands.common.app import After, At, Json, Scene, Sets, app


@app.command()
def check(scene: Scene, as_json: Json = False, sets: Sets = None) -> None:
    """Check a scene, show its static loads and what of it is modelled; starts nothing.    heavylift check lift"""
    import msgspec
    from heavylift.coordinator.participants.pause import check_steps
    from heavylift.nodes.scene import check as examine
    from heavylift.nodes.scene import load

    loaded = load(scene, sets or [])
    check_steps(loaded)
    found = examine(loaded)
    if not as_json:
        typer.echo(str(found))
        return
    told: dict[str, object] = {k: v for k, v in msgspec.to_builtins(found).items() if k != "lines"}
    told |= {"modelled": loaded.verdict.data() if loaded.verdict else None}
    typer.echo(msgspec.json.encode(told).decode())


@app.command()
def tree(scene: Scene, as_json: Json = False, sets: Sets = None) -> None:
    """Print the tree of DEVS models.    heavylift tree turnover"""
    import json

    from heavylift.nodes.models import tree as draw
    from heavylift.nodes.models import tree_data
    from heavylift.nodes.scene import load

    plan = load(scene, sets or []).plan
    typer.echo(json.dumps(tree_data(plan)) if as_json else draw(plan))


@app.command()
def equations(
    scene: Scene,
    formulation: Annotated[
        str, typer.Option("--formulation", help="recursive, articulated, embedding or augmented")
    ] = "recursive",
    latex: Annotated[bool, typer.Option("--latex", help="a LaTeX document")] = False,
    sets: Sets = None,
) -> None:
    """Print graph, path matrix and the equations of motion, body by body.    heavylift equations arm"""
    from heavylift.kernel.equations import equations as write
    from heavylift.nodes.models import system
    from heavylift.nodes.scene import load

    plan = load(scene, sets or []).plan
    typer.echo(write(system(plan), formulation, latex, f"Equations of motion: {plan.name}"))


@app.command()
def statics(scene: Scene, at: At = None, after: After = "", as_json: Json = False, sets: Sets = None) -> None:
    """Find where a scene comes to rest, and what ropes, pads and joints then carry.    heavylift statics lift"""
    import json

    from heavylift.coordinator.participants.pause import paused, resting
    from heavylift.kernel.analysis import equilibrium, reactions
    from heavylift.kernel.analysis import modes as about
    from heavylift.kernel.analysis.tables import statics_data, statics_text
    from heavylift.nodes.scene import load

    loaded = load(scene, sets or [])
    if at is None:
        path = resting(loaded, after)
        found, simulation = path.rest(), path.command
    else:
        simulation = paused(loaded, at, after)
        found = equilibrium(simulation)
    shown = found, reactions(simulation), about(simulation).growth
    notes = [note.sentence for note in simulation.notes]
    told = "\n".join([statics_text(*shown), *(f"note: {note}" for note in notes)])
    typer.echo(json.dumps(statics_data(*shown) | {"notes": notes}) if as_json else told)


@app.command()
def modes(scene: Scene, at: At = None, after: After = "", as_json: Json = False, sets: Sets = None) -> None:
    """Show frequencies, damping and modes about the pose at rest.    heavylift modes lift --after up"""
    import json

    from heavylift.coordinator.participants.pause import paused, resting
    from heavylift.kernel.analysis import equilibrium
    from heavylift.kernel.analysis import modes as about
    from heavylift.kernel.analysis.tables import modes_data, modes_text
    from heavylift.nodes.scene import load

    loaded = load(scene, sets or [])
    if at is None:
        path = resting(loaded, after)
        path.rest()
        simulation = path.command
    else:
        simulation = paused(loaded, at, after)
        equilibrium(simulation)
    found = about(simulation)
    typer.echo(json.dumps(modes_data(found)) if as_json else modes_text(found))
