"""The command line as a whole.

How the help of `heavylift` looks: commands by what they are about, each with an example that can be copied.

A command's docstring is `What it does.    heavylift name ...`: what stands behind the four blanks is its example and
is printed on a line of its own.  Commands stand below the heading of the file that they are written in.
"""

import inspect
import sys
from collections.abc import Callable, Iterable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer
from heavylift.kernel.trust import allowed
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command_name

MARK = "    heavylift "
HEADINGS = {
    "scenes": "Scenes",
    "running": "Runs",
    "sweeping": "Runs",
    "operating": "Runs that go on",
    "files": "Recordings",
    "measuring": "Recordings",
    "replaying": "Recordings",
    "own_models": "Models of your own",
    "hosts": "Several hosts",
    "health": "Installation",
}


class Spared:
    """Parameters without Typer's conversion by Pydantic, whose import is slow."""

    get_params: Any

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse arguments as Typer does."""
        for param in self.get_params(ctx):
            if getattr(param, "_runtime_param", param) is None:
                vars(param)["_runtime_param"] = _AsGiven()
        return super().parse_args(ctx, args)  # type: ignore[misc,no-any-return]


class _AsGiven:
    """Leave the value of a parameter unconverted."""

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        wanted = param.type_descriptor
        if value is None:
            return () if param.multiple else None
        if value == param.default or (wanted.annotation in (str, list[str]) and wanted.parameter_info.parser is None):
            return value
        param._runtime_param = None
        return param.get_runtime_param().coerce(value, param=param, ctx=ctx)


class Command(Spared, TyperCommand):
    """A command that prints its example after its options."""

    def __init__(self, *arguments: str | None, help: str | None = None, **settings: Any) -> None:
        message, mark, rest = (help or "").partition(MARK)
        example, _, more = rest.partition("\n")
        settings["short_help"] = message.strip()
        super().__init__(*arguments, help=f"{message}\n{more}".strip(), **settings)
        self.example = f"{mark}{example}".strip()

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Print the example unwrapped."""
        if self.example:
            with formatter.section("Example"):
                formatter.write(f"  {self.example}\n")
        super().format_epilog(ctx, formatter)


class CommandList(Spared, TyperGroup):
    """The list of all commands under their headings."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Print commands by heading, each with its whole first sentence."""
        by_heading: dict[str, list[tuple[str, str]]] = {heading: [] for heading in HEADINGS.values()}
        for name, command in self.commands.items():
            module = getattr(command.callback, "__module__", "").rpartition(".")[2]
            by_heading[HEADINGS[module]].append((name, command.get_short_help_str(limit=formatter.width)))
        for heading, rows in by_heading.items():
            if rows:
                with formatter.section(heading):
                    formatter.write_dl(rows)


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
    """The command-line application: every command has the same form of help."""

    def __call__(self, *args: Any, **settings: Any) -> Any:
        """Run the command line; commands that it does not name are not imported."""
        known = self.registered_commands
        named = [x for x in known if sys.argv[1:2] == [x.name or get_command_name(getattr(x.callback, "__name__", ""))]]
        self.registered_commands = named or known
        try:
            return super().__call__(*args, **settings)
        finally:
            self.registered_commands = known

    def command(self, name: str | None = None, **settings: Any) -> Callable[..., Any]:
        """Register a command with its example, and with --allow-code if it may load foreign code."""
        register = super().command(name, cls=Command, **settings)
        return lambda function: register(_with_allow_code(function))


def _code_set(sets: Iterable[str]) -> list[str]:
    """Functions named by --set, as the scene will name them; typing them on the command line trusts them."""
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
