"""`heavylift trust`: whose Python code may run when a scene, a recording or a coordinator names it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from heavylift.coordinator.commands.common.app import app


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
