"""The command line as a whole: how help looks, and how a command ends, with one sentence if there is an error.

A command's docstring is `What it does.    heavylift name ...`: what stands behind the four blanks is its example and
is printed on a line of its own.  Commands stand below the heading of the file that they are written in.
"""

import errno
import inspect
import os
import resource
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from heavylift.coordinator.stopping import STOPPED
from heavylift.kernel.errors import SPACES, HeavyliftError, OutputError, Stopped, out_of_memory, printable
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
    "replaying": "Recordings",
    "own_models": "Models of your own",
    "hosts": "Several hosts",
    "health": "Installation",
}


class Spared:
    """Mixin that spares a command the slow import of Pydantic, by which Typer converts parameters."""

    get_params: Any

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse arguments as Typer does, but leave the values of parameters unconverted."""
        for param in self.get_params(ctx):
            if getattr(param, "_runtime_param", param) is None:
                vars(param)["_runtime_param"] = _AsGiven()
        return super().parse_args(ctx, args)  # type: ignore[misc,no-any-return]


class _AsGiven:
    """Parameter type that leaves a value unconverted."""

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
        """Print the example of a command in its help, without wrapping the lines."""
        if self.example:
            with formatter.section("Example"):
                formatter.write(f"  {self.example}\n")
        super().format_epilog(ctx, formatter)


class CommandList(Spared, TyperGroup):
    """The list of all commands, grouped under headings."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Print commands by heading, each with the whole first sentence of its docstring."""
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
    """The command-line application, in which the help of every command has the same form."""

    def __call__(self, *args: Any, **settings: Any) -> Any:
        """Run the command line; a named command is registered alone, so that no other one is imported."""
        known = self.registered_commands
        named = [x for x in known if sys.argv[1:2] == [x.name or get_command_name(getattr(x.callback, "__name__", ""))]]
        self.registered_commands = named or known
        try:
            return super().__call__(*args, **settings)
        finally:
            self.registered_commands = known

    def command(self, name: str | None = None, **settings: Any) -> Callable[..., Any]:
        """Return a decorator that registers a command; the command gets the option --allow-code if it may load code
        that a scene or recording names."""
        register = super().command(name, cls=Command, **settings)
        return lambda function: register(_with_allow_code(function))


def _code_set(sets: Iterable[str]) -> list[str]:
    """Return the Python functions named by --set options, spelled as in a scene; the user trusts them by naming
    them."""
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


LEAST_MB = 400  # below, libraries end the command in words of their own


def carry_out() -> None:
    """Run the command line; raises SystemExit with its exit code unless that is 0."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit != resource.RLIM_INFINITY and limit < LEAST_MB << 20:
        message = f"only {limit >> 20} MB of memory may be addressed, and heavylift needs at least {LEAST_MB}"
        _fail(f"{message}; raise the limit (`ulimit -v unlimited`)")
    for word in sys.argv[1:]:
        if len(word.splitlines()) > 1 and Path(word).exists():
            _fail(f"'{printable(word)}': the name of this file has more than one line; rename it", 2)
    try:
        code = app(prog_name="heavylift", standalone_mode=False)  # of a command that ends with typer.Exit
        if code == STOPPED:  # what typer makes of Ctrl-C where nobody hears it
            print("heavylift: stopped", file=sys.stderr)
        if sys.stdout is not None:  # what does not go out is noticed here, not when Python ends
            sys.stdout.flush()
        if code:
            sys.exit(code)
    except HeavyliftError as error:
        message = str(error)
        print(f"heavylift: {message}" if "\n" not in message else message, file=sys.stderr)
        _print_partial_verdict(error)
        sys.exit(STOPPED if isinstance(error, Stopped) else 2 if isinstance(error, OutputError) else 1)
    except (typer.Abort, KeyboardInterrupt):
        _fail("stopped", STOPPED)
    except Exception as error:
        if isinstance(error, OSError) and not error.filename and (why := _unwritable()):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # so that Python does not fail as it ends
            _fail(f"standard output cannot be written ({why}); make room there or send it elsewhere")
        if hasattr(error, "format_message") and hasattr(error, "exit_code"):  # how click reports a wrong command line
            asked = type(error).__name__ == "NoArgsIsHelpError"
            message = error.format_message()
            print(message if asked else f"heavylift: {printable(message, keep=SPACES)}", file=sys.stderr)
            sys.exit(error.exit_code)
        if refused := _refused(error):
            _fail(refused)
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", prefix="heavylift-", suffix=".txt", delete=False
        ) as file:
            traceback.print_exc(file=file)
        message = f"internal error, {type(error).__name__}: {printable(str(error))}"
        _fail(f"{message}; this is a defect of heavylift, {file.name} holds the details for its developers")


def _fail(sentence: str, code: int = 1) -> NoReturn:
    """End the command with a sentence and an exit code."""
    print(f"heavylift: {sentence}", file=sys.stderr)
    sys.exit(code)


def _print_partial_verdict(error: HeavyliftError) -> None:
    """Print the verdict on the part of a run that was recorded before the error ended it."""
    if error.verdict is None:
        return
    from heavylift.coordinator.run.progress import print_verdict
    from heavylift.recordings.read.verdict import RecordedVerdict

    assert isinstance(error.verdict, RecordedVerdict)
    print_verdict(error.verdict)
    sys.stdout.flush()


def _refused(error: Exception) -> str:
    """Return a sentence for an error of the system (memory, full disk, permission); "" for any other error."""
    if out_of_memory(error):
        then = "then `heavylift resume` the recording, if there is one"
        return f"the system gives no more memory; end other programs or raise the limit (`ulimit -v`), {then}"
    if not isinstance(error, OSError):
        return ""
    if error.errno in (errno.EMFILE, errno.ENFILE):
        return "too many files are open for the system's limit; raise it, for instance with `ulimit -n 256`"
    if error.filename:
        return f"{error.filename}: {error.strerror}; give another name or place"
    return "" if _here() else "the working directory is gone; change to one that is there (`cd`)"


def _here() -> bool:
    try:
        return bool(os.getcwd())
    except FileNotFoundError:
        return False


def _unwritable() -> str:
    """Return why standard output cannot be written to; "" if it can."""
    try:
        if sys.stdout is not None:
            os.write(sys.stdout.fileno(), b"\n")  # what has failed once is gone from Python's own buffer
    except OSError as error:
        return error.strerror or type(error).__name__
    return ""
