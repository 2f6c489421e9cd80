"""The command line as a whole, and what its commands have in common: arguments and options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

__all__ = ["After", "At", "File", "Json", "Scene", "Sets", "app"]

app = typer.Typer(
    add_completion=True,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Simulates tandem crane lifts: one scene file, one process per model, every message on record.",
)

Scene = Annotated[
    str, typer.Argument(help="a scene file, or the name of a bundled scene (turnover, lift, arm, pendulum)")
]
File = Annotated[Path, typer.Argument(help="a recording (.mcap)")]
At = Annotated[float | None, typer.Option("--at", help="time of the run [s]; default its start")]
After = Annotated[str, typer.Option("--after", help="at the end of this stage of the run")]
Json = Annotated[bool, typer.Option("--json", help="one JSON object, SI units")]
Sets = Annotated[list[str] | None, typer.Option("--set", help="override a key: --set accuracy=0.5%")]
