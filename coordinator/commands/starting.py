"""Commands for a beginning: new, gallery, schema, doctor."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from heavylift.coordinator.commands.common import completing
from heavylift.coordinator.commands.common.app import Force, Json, app
from heavylift.kernel.errors import SceneError


@app.command()
def new(
    name: Annotated[str, typer.Argument(help="of the scene; it is written to NAME.yaml")],
    like: Annotated[
        str, typer.Option("--like", help="bundled scene that it begins as", autocompletion=completing.scenes)
    ] = "lift",
) -> None:
    """Write a scene to start from, with comments.    heavylift new my-lift"""
    from heavylift.coordinator.run.progress import command
    from heavylift.nodes.scene import begun

    path = Path(f"{name}.yaml")
    text = begun(name, like)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise SceneError(f"{path}: is there already and stays as it is; choose another name") from None
    except OSError as error:
        raise SceneError(f"{path}: cannot be written ({error.strerror}); choose another folder") from None
    typer.echo(f"wrote {path}\n\nnext: {command()} check {path}")


@app.command()
def gallery(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(help="scene files or names; default all bundled ones", autocompletion=completing.scenes),
    ] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="folder for GALLERY.md and pictures")] = Path(
        "gallery"
    ),
    force: Force = False,
) -> None:
    """Run scenes and write a page with a picture of each.    heavylift gallery lift tandem -o my-gallery"""
    from heavylift.nodes.scene import bundled, load
    from heavylift.recordings.write.partfile import written

    from .gallery import draw, page

    loaded = [load(scene) for scene in scenes or bundled()]
    for scene in loaded:
        typer.echo(f"wrote {draw(scene, output / 'pictures', force)}")
    typer.echo(f"wrote {written(page(loaded), output / 'GALLERY.md', 'a page', ('.md',), force)}")


@app.command()
def schema() -> None:
    """Print the JSON Schema of scene files, by which editors complete.    heavylift schema > heavylift.schema.json"""
    import json

    from heavylift.nodes.scene import json_schema

    typer.echo(json.dumps(json_schema(), indent=2))


@app.command()
def doctor(as_json: Json = False) -> None:
    """Check the installation: versions, rights, a short run in processes.    heavylift doctor"""
    import json

    from .health import findings

    found = []
    for finding in findings():
        found.append(finding)
        if not as_json:
            typer.echo(str(finding))
    if as_json:
        typer.echo(json.dumps([finding._asdict() for finding in found]))
    if any(finding.state == "broken" for finding in found):
        raise typer.Exit(1)
