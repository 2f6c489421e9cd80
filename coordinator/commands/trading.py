"""`heavylift tradeoff`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from heavylift.coordinator.commands.common.app import Force, Json, Scene, Sets, app

if TYPE_CHECKING:
    from heavylift.nodes.scene.text.units import Dimension


@app.command()
def tradeoff(
    scene: Scene,
    output: Annotated[
        list[Path] | None,
        typer.Option("-o", "--output", help="report: .html, .png, .svg, .csv, .json; default NAME-tradeoff.html"),
    ] = None,
    force: Force = False,
    ask: Annotated[str, typer.Option("--ask", help="what must be right: --ask 'rope tension, swing'")] = "",
    accuracy: Annotated[
        str, typer.Option("--accuracy", help="of each quantity asked; default the scene's own if it asks, else 1 %")
    ] = "",
    budget: Annotated[str, typer.Option("--budget", help="wall time for all runs")] = "5 min",
    coupling: Annotated[
        bool, typer.Option("--coupling", help="also what processes cost: held forces, messages")
    ] = False,
    sets: Sets = None,
    as_json: Json = False,
) -> None:
    """Measure speed against accuracy: which rung, method and step to use.    heavylift tradeoff lift --ask swing"""
    import json

    from heavylift.coordinator.tradeoff import measure, write
    from heavylift.coordinator.tradeoff.communication import communicating, hanging
    from heavylift.coordinator.tradeoff.files import checked, data
    from heavylift.nodes.scene import load
    from heavylift.nodes.scene.text.units import ACCURACY, DURATION

    loaded = load(scene, sets or [])
    outputs = [checked(path) for path in output or ([] if as_json else [Path(f"{loaded.plan.name}-tradeoff.html")])]
    limit = _read("--accuracy", accuracy, ACCURACY) if accuracy else None
    seconds = _read("--budget", budget, DURATION)
    if coupling:
        hanging(loaded)
    measured = measure(loaded, ask, limit, seconds, lambda told: typer.echo(f"  {told}", err=True))
    if coupling:
        measured = communicating(loaded, measured)
    outputs = [write(measured, path, force) for path in outputs]
    if as_json:
        typer.echo(json.dumps(data(measured)))
        return
    typer.echo(measured.verdict.sentence)
    for path in outputs:
        typer.echo(f"wrote {path}")


def _read(option: str, text: str, dimension: Dimension) -> float:
    from heavylift.kernel.errors import SceneError

    try:
        return dimension.read(text)
    except ValueError as error:
        raise SceneError(f"{option} '{text}': {error}") from None
