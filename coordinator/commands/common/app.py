"""The command line as a whole."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer
from heavylift.kernel.trust import allowed
from typer.main import get_command_name

from .helping import Command, CommandList

CODE = {"scene", "scenes", "verify", "strict", "connect"}  # parameters of commands that hear of Python code of others
AllowCode = Annotated[
    list[Path] | None,
    typer.Option(
        exists=True, resolve_path=True, help="let Python code in this file or folder run; `heavylift trust` for good"
    ),
]
EXIT_CODES = """Exit codes: 0 done; 1 the scene, the run or the file is at fault, or two runs differ; 2 the command line
is wrong, or would overwrite what heavylift has not made; 86 a process on this host has lost its coordinator; 130
stopped by Ctrl-C, 129, 131 and 143 by SIGHUP, SIGQUIT and SIGTERM; 141 nobody reads the output any more. One sentence
says what is wrong."""


class App(typer.Typer):
    """All commands have the same form of help."""

    def __call__(self, *args: Any, **settings: Any) -> Any:
        """Do what the command line says; commands that it does not name are not made ready."""
        known = self.registered_commands
        named = [x for x in known if sys.argv[1:2] == [x.name or get_command_name(getattr(x.callback, "__name__", ""))]]
        self.registered_commands = named or known
        try:
            return super().__call__(*args, **settings)
        finally:
            self.registered_commands = known

    def command(self, name: str | None = None, **settings: Any) -> Callable[..., Any]:
        """A command, with its example behind its options, and --allow-code if it may hear of code of others."""
        register = super().command(name, cls=Command, **settings)
        return lambda function: register(_with_allow_code(function))


def _code_set(sets: Iterable[str]) -> list[str]:
    """The functions that --set names, as the scene will name them: typing them allows them."""
    found = []
    for key, _, value in (setting.partition("=") for setting in sets):
        module, colon, name = value.strip().strip("'\"").rpartition(":")
        if key.strip().rpartition(".")[2] in ("function", "guards") and colon:
            found.append(f"{Path(module).resolve() if module.endswith('.py') else module}:{name}")
    return found


def _with_allow_code(function: Callable[..., Any]) -> Callable[..., Any]:
    signature = inspect.signature(function, eval_str=True)
    if not CODE.intersection(signature.parameters):
        return function

    @wraps(function)
    def command(*args: Any, allow_code: list[Path] | None = None, **kwargs: Any) -> Any:
        with allowed([*map(str, allow_code or []), *_code_set(kwargs.get("sets") or [])]):
            return function(*args, **kwargs)

    more = inspect.Parameter("allow_code", inspect.Parameter.KEYWORD_ONLY, default=None, annotation=AllowCode)
    whole = signature.replace(parameters=[*signature.parameters.values(), more])
    command.__annotations__ = {x.name: x.annotation for x in whole.parameters.values()}
    command.__signature__ = whole  # type: ignore[attr-defined]
    return command


app = App(
    cls=CommandList,
    add_completion=True,
    no_args_is_help=True,
    context_settings={"color": True},  # whatever steers a terminal is shown, not cut out
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Simulates tandem crane lifts: one scene file, one process per model, every message on record.",
    epilog=EXIT_CODES,
)


def _version(asked: bool) -> None:
    if asked:
        from heavylift.kernel.version import __version__

        typer.echo(f"heavylift {__version__}")
        raise typer.Exit


@app.callback()
def _application(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="say which version this is")
    ] = False,
) -> None:
    pass
