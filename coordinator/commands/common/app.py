"""The command line as a whole, and what its commands have in common: arguments and options."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from heavylift.kernel.errors import SceneError
from heavylift.kernel.trust import allowed
from typer.main import get_command_name

from . import completing
from .helping import Command, Commands

if TYPE_CHECKING:
    from heavylift.coordinator.run.watch import Watch
    from heavylift.nodes.scene.text.units import Dimension

LEAST_s = 1.0  # that a process has for an answer
AUTO = 1 << 30  # more processes than anybody has: as many as pay

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
    cls=Commands,
    add_completion=True,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Simulates tandem crane lifts: one scene file, one process per model, every message on record.",
    epilog=EXIT_CODES,
)


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"heavylift {version('heavylift')}")
        raise typer.Exit


@app.callback()
def _application(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="say which version this is")
    ] = False,
) -> None:
    pass


def process_count(text: str | int) -> int:
    """How many processes are asked for; AUTO for those that pay."""
    if text == "auto":
        return AUTO
    try:
        return int(text)
    except ValueError:
        raise typer.BadParameter(f"{text!r} is neither a number of processes nor auto") from None


def paying_processes(
    asked: int, models: int, run: Callable[[int, Watch], object], elsewhere: Collection[str] | None = None
) -> int:
    """The number `asked` for; where that is AUTO, as many as pay where `run(count, watch)` is tried, which is told."""
    if asked != AUTO:
        return asked
    if elsewhere:
        raise typer.BadParameter("--processes auto tries processes on this machine; leave out --remote and --external")
    from .paying import paying

    count, found = paying(run, models)
    typer.echo(f"--processes auto: {count}, for {found}", err=True)
    return count


def one_process(in_process: bool, processes: int, places: Sequence[str] | None) -> bool:
    """Whether all models run in this process; a parameter that says otherwise is refused."""
    if in_process and (processes or places):
        raise typer.BadParameter("--in-process: all models run in this process, leave out --processes and --place")
    return in_process


Scene = Annotated[
    str,
    typer.Argument(
        help="a scene file, or the name of a bundled scene such as turnover or lift", autocompletion=completing.scenes
    ),
]
File = Annotated[Path, typer.Argument(help="a recording (.mcap)", autocompletion=completing.recordings)]
Run = Annotated[
    str,
    typer.Argument(
        help="the recording that it writes, its run id, or its scene; default the only one",
        autocompletion=completing.runs,
    ),
]
At = Annotated[float | None, typer.Option("--at", help="time of the run [s]; default its start")]
After = Annotated[str, typer.Option("--after", help="at the end of this stage of the run")]
Json = Annotated[bool, typer.Option("--json", help="one JSON object, SI units")]
Deadline = Annotated[str, typer.Option("--deadline", help="for a process to show progress")]
Processes = Annotated[
    int,
    typer.Option(
        "--processes",
        help="deal the models out over so many processes, or as many as pay",
        parser=process_count,
        metavar="N|auto",
    ),
]
Places = Annotated[
    list[str] | None, typer.Option("--place", help="models that share a process: --place 'west,east=yard-a'")
]
Remote = Annotated[list[str] | None, typer.Option("--remote", help="this process runs on another host")]
External = Annotated[
    list[str] | None,
    typer.Option("--external", help="a program of another kind plays this process; writes NAME.ticket (WIRE.md)"),
]
Listen = Annotated[str, typer.Option("--listen", help="tls/ADDRESS:PORT for processes of other hosts")]
InProcess = Annotated[bool, typer.Option("--in-process", help="all models in this process")]
Strict = Annotated[bool, typer.Option("--strict", help="exit code 1 if the verdict is red")]
Force = Annotated[bool, typer.Option("--force", help="replace an earlier output of this name")]
Sets = Annotated[list[str] | None, typer.Option("--set", help="override a key: --set accuracy=0.5%")]


def written_to(help: str) -> Any:
    """The option for the file or folder that a command writes."""
    return typer.Option("-o", "--output", help=help)


def quantity(option: str, text: str, dimension: Dimension) -> float:
    """The value of an option with a unit, in SI units; SceneError if it is none."""
    try:
        return dimension.read(text)
    except ValueError as error:
        raise SceneError(f"{option} '{text}': {error}") from None


def duration_s(option: str, text: str) -> float:
    """A time of simulation as a user writes it, zero or more, or as long as time lasts [s]."""
    from heavylift.nodes.devs import NEVER
    from heavylift.nodes.scene.text.units import TIME

    length = quantity(option, text, TIME)
    if length < 0.0:
        raise SceneError(f"{option} {text}: a time is zero or more")
    return min(length, NEVER * 1e-9)


def deadline_s(text: str) -> float:
    """A deadline as a user writes it [s]."""
    from heavylift.nodes.scene.text.units import DURATION

    seconds = quantity("--deadline", text, DURATION)
    if seconds < LEAST_s:
        raise SceneError(f"--deadline '{text}': give a process at least {LEAST_s:g} s")
    return seconds
